"""A source at work: in a thread of its own, so that one that raises or blocks harms no other."""

from __future__ import annotations

import ctypes
import itertools
import queue
import threading
import time
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from humanoid_bt.core.errors import relative
from humanoid_bt.core.messages import SIGHT, Array, Percept
from humanoid_bt.core.texts import one_line, shortened, told
from humanoid_bt.files.class_files import class_file, place_in_file
from humanoid_bt.perception.interface import OLDEST
from humanoid_bt.perception.source import Moment, PerceptSource

SETUP_PATIENCE = 60.0
"""How long a source may take to set itself up, on the wall clock [s]."""

_TURN = 0.1  # s that an answer is waited for at a time
_LONGEST = 300  # characters of what an exception says


class Stuck(BaseException):
    """Raised in the thread of a source that does not come back, so that a loop in it ends."""


class PerceptError(ValueError):
    """What a source gave is no percept, or none of its own."""


class Looked(NamedTuple):
    """What came of a look.

    Attributes:
        percepts: what was seen.
        unseen: why others were never seen so far, by name.
    """

    percepts: list[Percept]
    unseen: Mapping[str, str]


_NOTHING = Looked([], {})


class Worker:
    """Has a source look, one moment after the other.

    Args:
        source: it.
        label: what it is called.
        mark: called in its thread when it begins to work, and again when it has done it.

    Attributes:
        off: why it does not work any more, "" while it does.
        busy: whether it is at work.
    """

    def __init__(self, source: PerceptSource, label: str, mark: Callable[[], None] | None = None) -> None:
        self.source, self.label = source, label
        self._mark = mark or (lambda: None)
        self.off, self.busy = "", False
        self._since = 0.0
        self._limit = SETUP_PATIENCE
        self._orders: queue.SimpleQueue[Callable[[], Any] | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[Looked | BaseException] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name=f"source {label}", daemon=True)
        self._thread.start()

    def set_up(self) -> None:
        """Have the source set itself up."""
        self._order(self.source.setup, SETUP_PATIENCE)

    def look(self, now: Moment, never: Collection[str]) -> None:
        """Have the source look, if it is neither at work nor off.

        Args:
            now: at what.
            never: the percepts of which it is to say why they were never seen, if they are not seen now either.
        """
        if not (self.busy or self.off):
            self._order(lambda: looked(self.source, now, never), self.source.patience)

    def take(self, wait: bool) -> Looked:
        """Return what it has seen since the last time; note why it is off if it has failed.

        Args:
            wait: until it is done, or has taken too long.
        """
        if not self.busy:
            return _NOTHING
        until = self._since + self._limit
        try:
            answer = self._awaited(until) if wait else self._answers.get_nowait()
        except queue.Empty:
            if wait or until < time.monotonic():
                self._give_up()
            return _NOTHING
        self.busy = False
        if isinstance(answer, BaseException):
            self.off = self._told(answer)
            return _NOTHING
        return answer

    def close(self) -> None:
        """End its thread when it has done what it is at."""
        if self.busy and not self.off:
            self._interrupt()
        self._orders.put(None)

    def _awaited(self, until: float) -> Looked | BaseException:
        """Wait for its answer, in short turns: a signal that comes just before one is heard after it.

        Raises:
            queue.Empty: there is none until a time of the monotonic clock [s].
        """
        while (left := until - time.monotonic()) > _TURN:
            with suppress(queue.Empty):
                return self._answers.get(timeout=_TURN)
        return self._answers.get(timeout=max(left, 0.001))

    def _order(self, what: Callable[[], Any], limit: float) -> None:
        self.busy, self._since, self._limit = True, time.monotonic(), limit
        self._orders.put(what)

    def _work(self) -> None:
        with suppress(Stuck):  # it may come when there is nothing to end any more
            self._obey()

    def _obey(self) -> None:
        while (order := self._orders.get()) is not None:
            self._mark()
            answer = _obeyed(order)
            self._mark()
            self._answers.put(answer)

    def _give_up(self) -> None:
        self.off = f"has been at it for more than {self._limit:g} s"
        self._interrupt()

    def _interrupt(self) -> None:
        if self._thread.ident is not None:
            ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self._thread.ident), ctypes.py_object(Stuck))

    def _told(self, error: BaseException) -> str:
        """Return what it raised, and where."""
        file = class_file(type(self.source))
        place = place_in_file(error, file) if file else None
        where = f" ({place or relative(file or Path(self.label))})"
        if isinstance(error, PerceptError):
            return f"answers wrongly: {error}{where}"
        return f"raised {shortened(one_line(told(error).removesuffix(': ')), _LONGEST)}{where}"


def _obeyed(order: Callable[[], Any]) -> Looked | BaseException:
    """Return what came of an order, or what it raised."""
    try:
        found = order()
    except BaseException as error:  # whatever it is, it is this source's alone
        return error
    return found if isinstance(found, Looked) else _NOTHING


def looked(source: PerceptSource, now: Moment, never: Collection[str]) -> Looked:
    """Return what a source sees now, and why it never saw others; raises PerceptError and what the source raises.

    Args:
        source: it.
        now: at what it looks.
        never: the percepts that were never seen so far.
    """
    percepts = checked(source.look(now), source.names, now.time)
    seen = {percept.name for percept in percepts}
    return Looked(percepts, {name: _why_unseen(source, name) for name in never if name not in seen})


def _why_unseen(source: PerceptSource, name: str) -> str:
    why: Any = source.why_unseen(name)
    if not isinstance(why, str):
        raise PerceptError(f"why_unseen({name!r}) gave {shortened(repr(why), 80)}, and must give a text")
    return shortened(one_line(why), _LONGEST)


def checked(found: Iterable[Percept], names: Iterable[str], time: float) -> list[Percept]:
    """Return percepts as they may be published, with arrays that nobody can write into.

    Args:
        found: what a source gave.
        names: the percepts that it publishes.
        time: of the look [s].

    Raises:
        PerceptError: one of them is none, is another's, comes twice, or is not finite.
    """
    if found is None or isinstance(found, Percept):
        given = "None" if found is None else "a percept"
        raise PerceptError(f"look() gave {given}, and must give a list of percepts, which may be empty")
    own, seen = set(names), dict[str, Percept]()
    for percept in itertools.islice(found, len(own) + 1):
        if not isinstance(percept, Percept):
            raise PerceptError(f"look() gave a list with {shortened(repr(percept), 80)} in it, which is no Percept")
        if percept.name in seen:
            raise PerceptError(f"look() gave the percept {percept.name!r} twice at once")
        if percept.name not in own:
            message = f"look() gave the percept {shortened(str(percept.name), 80)!r}, which it does not publish"
            raise PerceptError(f"{message}: it publishes {', '.join(sorted(own)) or 'none'}")
        seen[percept.name] = _checked(percept, time)
    return list(seen.values())


def _checked(percept: Percept, time: float) -> Percept:
    what = f"the percept {percept.name!r}"

    def numbers(field: str, shape: tuple[int, ...]) -> Array | None:
        value = getattr(percept, field)
        if value is None:
            return None
        try:
            array = np.array(value, dtype=float)
        except (TypeError, ValueError):
            array = np.full(0, np.nan)
        if array.shape != shape or not np.isfinite(array).all():
            given = shortened(" ".join(repr(value).split()), 80)  # an array is written in lines
            raise PerceptError(f"{what} has the {field} {given}: no {shape} finite numbers")
        array.setflags(write=False)
        return array

    position = numbers("position", (3,))
    if position is None:
        raise PerceptError(f"{what} has no position")
    if (far := float(np.linalg.norm(position))) > SIGHT:  # it was told in millimetres
        raise PerceptError(f"{what} is {far:g} m away: positions are in metres, at most {SIGHT:g} m from the base")
    for field in ("stamp", "confidence", "heading"):
        value = getattr(percept, field)
        if not isinstance(value, (int, float, np.floating, np.integer)) or not np.isfinite(value):
            raise PerceptError(f"{what} has the {field} {value!r}: no finite number")
    if not 0 <= percept.confidence <= 1:
        raise PerceptError(f"{what} has the confidence {percept.confidence!r}: it is from 0 to 1")
    if percept.stamp > time + 1e-9:
        raise PerceptError(f"{what} has the stamp {percept.stamp:g} s, and it is {time:g} s: it was not seen yet")
    if (age := time - percept.stamp) > OLDEST:
        raise PerceptError(f"{what} has the stamp of {age:.0f} s ago: where the robot stood is known of {OLDEST:g} s")
    orientation, size, covariance = numbers("orientation", (4,)), numbers("size", (3,)), numbers("covariance", (3, 3))
    if orientation is not None:
        length = float(np.linalg.norm(orientation))
        if not 0.99 < length < 1.01:
            raise PerceptError(f"{what} has an orientation of length {length:g}: a unit quaternion wxyz has 1")
    if size is not None and not (size > 0).all():
        raise PerceptError(f"{what} has the size {size.tolist()}: lengths are above 0")
    if covariance is not None and (
        not np.allclose(covariance, covariance.T) or np.linalg.eigvalsh(covariance)[0] < -1e-9
    ):
        raise PerceptError(f"{what} has a covariance that is not symmetric and positive")
    if not isinstance(percept.class_name, str):
        raise PerceptError(f"{what} has the class {percept.class_name!r}: no text")
    return Percept(
        percept.name,
        float(percept.stamp),
        position,
        float(percept.confidence),
        size,
        float(percept.heading),
        orientation,
        percept.class_name,
        covariance,
    )
