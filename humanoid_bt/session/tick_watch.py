"""Ticks that take too long: where they are while they last, and which took longer than their period.

A thread beside the run looks at the frames of a tick that lasts. A tick pays three readings of clocks for it.
"""

from __future__ import annotations

import logging
import os
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from itertools import islice
from types import FrameType
from typing import Any, Self

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import Place, relative
from humanoid_bt.files.class_files import class_file
from humanoid_bt.tree.ticking.tick import halt_alone, tick

_log = logging.getLogger(__name__)

_LOOK = 0.01  # s between two looks
_LONG = 1.0  # s after which a tick that still lasts is told
_ASKED = 0.1  # s after which it is told to whoever wants to end the run
_OF_A_NODE = {tick.__code__, halt_alone.__code__}  # their frames hold the node


@dataclass(frozen=True)
class Spot:
    """Where a tick is.

    Attributes:
        node: path of the node.
        place: the line of the skill's file, None if the node is none of a file.
    """

    node: str
    place: Place | None

    def __str__(self) -> str:
        return f"the node {self.node!r}" + (f", at {self.place}" if self.place else "")


@dataclass(frozen=True)
class SlowTick:
    """A tick that took longer than its period.

    Attributes:
        time: engine time [s].
        node: path of the node that took longest, "" if that is not known.
        duration: time that the tick took [s], without what it waited for a processor.
    """

    time: float
    node: str
    duration: float


class TickWatch:
    """Watches the ticks of one run. Use it as a context manager around them.

    Args:
        looks: whether a thread looks where a tick is that lasts; without it ticks cost no more than two times.

    Attributes:
        count: ticks that took longer than their period.
        worst: the longest of them.
        took: how long the last tick took, on the wall clock [s].
    """

    def __init__(self, looks: bool = True) -> None:
        self.looks = looks
        self.count, self.took = 0, 0.0
        self.worst: SlowTick | None = None
        self._told: set[str] = set()
        self._interruption = ""
        self._began = 0.0  # of the tick that lasts; 0 between ticks
        self._waited = 0.0
        self._processor = _Processor()
        self._seen: list[tuple[float, Spot]] = []  # begin of the tick, where it was
        self._awaited: tuple[float, str] = (0.0, "")  # since when, and what, between ticks
        self._awaiting = _Awaiting(self.awaited)
        self._said: tuple[float, str] = (0.0, "")  # begin of the tick or of what is awaited, interruption
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ticks", daemon=True)

    def __enter__(self) -> Self:
        if self.looks:
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        if self.looks:
            self._thread.join(1.0)
        self._processor.close()

    def interrupted(self, reason: str) -> None:
        """Note that somebody wants to end the run: what lasts holds it up. From any thread or handler."""
        self._interruption = reason

    def awaiting(self, what: str) -> _Awaiting:
        """Have it told what is awaited between ticks, in a ``with``, if it lasts and somebody wants to end the run."""
        self._awaited = time.perf_counter(), what
        return self._awaiting

    def awaited(self) -> None:
        """Have nothing told any more of what was awaited."""
        self._awaited = 0.0, ""

    def begin(self) -> None:
        """Begin a tick in this thread."""
        if self.looks:
            self._waited = self._processor.waited()
        self._began = time.perf_counter()

    def finish(self, now: float) -> str:
        """End the tick at an engine time [s]; return what there is to tell of it, "" if nothing is."""
        began, self._began = self._began, 0.0
        duration = self.took = time.perf_counter() - began
        seen, self._seen = self._seen, []
        if duration <= DECISION_PERIOD or not self.looks:
            return ""
        duration -= self._processor.waited() - self._waited
        if duration <= DECISION_PERIOD:
            return ""
        spots = Counter(spot.node for at, spot in seen if at == began)
        place = next((spot.place for at, spot in seen if at == began and spot.place), None)
        node = max(spots, key=spots.__getitem__, default="")
        self.count += 1
        if self.worst is None or duration > self.worst.duration:
            self.worst = SlowTick(round(now, 3), node, round(duration, 4))
        if not node or node in self._told:
            return ""
        self._told.add(node)
        took = f"a tick took {duration * 1000:.0f} ms, and its period is {DECISION_PERIOD * 1000:.0f} ms"
        return f"{took}: {Spot(node, place)}"

    def to_dict(self) -> dict[str, Any]:
        """Return the slow ticks as plain data."""
        return {"count": self.count, "worst": asdict(self.worst) if self.worst else None}

    # ---- the thread -------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._over.wait(_LOOK):
            began, (since, what) = self._began, self._awaited
            now = time.perf_counter()
            if began and now - began >= _LOOK:
                self._look(began)
            elif what and now - since > _ASKED and self._interruption and self._said[0] != since:
                self._said = since, self._interruption
                self._tell_what_holds_it_up(what)

    def _look(self, began: float) -> None:
        spot = _spot(sys._current_frames().get(self._processor.thread))
        lasts = time.perf_counter() - began
        if self._began != began or spot is None:
            return  # it is over, or between two nodes
        self._seen.append((began, spot))
        said, reason = (began, self._interruption), self._interruption
        if said != self._said and lasts > (_ASKED if reason else _LONG):
            self._said = said
            if reason:
                self._tell_what_holds_it_up(spot)
            else:
                _log.warning("a tick lasts for %.1f s by now: it is in %s", lasts, spot)

    def _tell_what_holds_it_up(self, what: Spot | str) -> None:
        reason = self._interruption
        again = "again" if reason == "Ctrl-C" else "twice"
        _log.warning("%s: waiting for %s; Ctrl-C %s ends the run at once", reason, what, again)


class _Awaiting:
    """While something is awaited: what to do when it has come. One of ``contextlib`` takes five times as long."""

    def __init__(self, over: Callable[[], None]) -> None:
        self._over = over

    def __enter__(self) -> None:
        """Begin."""

    def __exit__(self, *_: object) -> None:
        self._over()


class _Processor:
    """What a thread waited for a processor, on a machine with more to do than it has processors."""

    def __init__(self) -> None:
        self.thread = 0
        self._file = -1

    def waited(self) -> float:
        """Return how long the calling thread has waited so far [s]; 0 where the system does not tell."""
        if self.thread != (now := threading.get_ident()):
            self.close()
            self.thread = now
            with suppress(OSError):
                self._file = os.open("/proc/thread-self/schedstat", os.O_RDONLY)
        if self._file < 0:
            return 0.0
        return int(os.pread(self._file, 100, 0).split()[1]) * 1e-9

    def close(self) -> None:
        """Let go of the system's file."""
        if self._file >= 0:
            os.close(self._file)
        self._file, self.thread = -1, 0


def _column(frame: FrameType) -> int:
    """Return the column that a frame is at, counted from 1."""
    _, _, column, _ = next(islice(frame.f_code.co_positions(), frame.f_lasti // 2, None), (None,) * 4)
    return (column or 0) + 1


def _spot(frame: FrameType | None) -> Spot | None:
    """Return which node a frame belongs to, and the innermost line in its skill's file; None if to no node."""
    inside: list[FrameType] = []
    while frame is not None and frame.f_code not in _OF_A_NODE:
        inside.append(frame)
        frame = frame.f_back
    if frame is None:
        return None
    node = frame.f_locals["node"]
    file = class_file(type(node))
    for inner in inside:
        if file is not None and inner.f_code.co_filename == str(file):
            return Spot(getattr(node, "path", node.name), Place(relative(file), inner.f_lineno, _column(inner)))
    return Spot(getattr(node, "path", node.name), None)
