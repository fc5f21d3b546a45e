"""Recording as decision sees it: a recorder's calls, carried out by a process of its own."""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import subprocess
import sys
import weakref
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import HumanoidBtError, Problem, UserError
from humanoid_bt.core.messages import Array, Level
from humanoid_bt.decision.result import Reported
from humanoid_bt.link.processes import how_ended
from humanoid_bt.perception.track import Track
from humanoid_bt.record.outbox import Outbox, Stuck
from humanoid_bt.record.sample import encode_call, encode_cycles, encode_results, encode_sample
from humanoid_bt.record.subject import TreeView
from humanoid_bt.record.tick import Tick

_START_TIMEOUT = 90.0  # s to open everything: a viewer on a cold disk, a camera that is insisted on
_PATIENCE = 10.0  # s without a sign of life after which a recorder that is waited for is given up
_BEHIND = 5.0  # s that a recorder which is not waited for may be behind before ticks are left out
_ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MALLOC_MMAP_THRESHOLD_": str(1 << 25),  # bytes; a batch is to lie where the last one did, and not in new pages,
    "MALLOC_TRIM_THRESHOLD_": str(1 << 26),  # of which each costs 1 us: so much glibc may keep
    "RUST_LOG": "off",  # it tells of trouble itself
    "RERUN_STRICT": "1",  # what cannot be drawn is an error: else a whole batch is lost with a warning that nobody sees
}
_ROOM = 1 << 22  # bytes of other news that wait for it then
_END_TIMEOUT = 5.0  # s that an ended process may take to be gone


class RemoteRecorder:
    """Has the recorder's process, and hands over to it what happens, in every tick.

    Made early, because its process takes most of a second to come up; it records nothing before :meth:`open`. Whatever
    becomes of the process then, no call raises: what is lost is told by :meth:`take_news` and counted.

    Args:
        waits: wait for a recorder that is slow, so that nothing is lost. Else never wait: ticks that it cannot take in
            time are left out.
        core: processor that it does not use, None for none.

    Attributes:
        url: address of the web viewer, "" if none is served.

    Raises:
        HumanoidBtError: the system has no room for the process.
    """

    def __init__(self, *, waits: bool, core: int | None = None) -> None:
        self.url = ""
        self._waits = waits
        self._end, other = socket.socketpair()
        with other:
            self._process = _start(other, core)
        self._outbox = Outbox(self._end, _PATIENCE if waits else 0.0)
        self._ears = select.poll()
        self._ears.register(self._end, select.POLLIN)
        self._finalize = weakref.finalize(self, _end_process, self._process, self._end)
        _ends.add(self._end)
        self._inbox, self._news = b"", list[tuple[Level, str]]()
        self._answers: list[list[Any]] = []
        self._collected: list[bytes] = []  # calls since the last tick
        self._opened = self._over = False  # over: nothing is handed over any more
        self._told_behind = False
        self._first: float | None = None  # engine times of ticks [s]
        self._last = self._handed = 0.0
        self._written = -float("inf")  # up to when the recording has everything [s]
        self._under_way: deque[float] = deque()  # engine times of ticks that were handed over and are not written [s]
        self._left_out = 0.0  # s

    # ---- life -------------------------------------------------------------------------------------------------------

    def open(self, **setup: Any) -> None:
        """Open the recording. Once more if that is refused.

        Args:
            setup: arguments of a :class:`~humanoid_bt.record.recorder.Recorder`.

        Raises:
            UserError: a sink cannot be opened, or pictures are insisted on and there is no OpenGL.
            HumanoidBtError: the process does not come up.
        """
        try:
            self._outbox.put(encode_call("open", setup), _START_TIMEOUT)
            while (answer := self._answer(_START_TIMEOUT))[0] == "busy":
                pass
        except (OSError, Stuck) as error:
            told = [text for _, text in self.take_news()]
            how = f"it did not answer within {_START_TIMEOUT:g} s" if isinstance(error, Stuck) else self._how_ended()
            raise HumanoidBtError(told[0] if told else f"the recorder process did not come up: {how}") from None
        kind, result = answer
        if kind == "refused":
            raise UserError([Problem(message, hint=hint) for message, hint in result])
        self.url = result
        self._opened = True

    def close(self) -> None:
        """Write the rest, close the recording and end the process. Twice is once.

        Every wait has a limit. Whoever interrupts it does not wait: the recorder then ends by itself.
        """
        try:
            if self._opened and not self._over:
                self._finish()
        except BaseException:
            self._end.close()
            self._finalize.detach()
            raise
        finally:
            self._over = True
        self._finalize()
        if self._opened and self.missing:
            self._news.append(("error", f"{self.missing:.1f} s of {self.length:.1f} s are missing in the recording"))
        self._opened = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # ---- what happens -----------------------------------------------------------------------------------------------

    def sample(
        self, tick: Tick, tracks: Mapping[str, Track], objects: Mapping[str, Array], hidden: Iterable[str] = ()
    ) -> None:
        """Record one tick, and hand over everything since the last one.

        Args:
            tick: what decision saw and commanded.
            tracks: percepts by name, placed in the world.
            objects: true positions of scene objects by name, world frame, shape (3,) [m].
            hidden: names of those that perception cannot see now.
        """
        time = tick.state.time
        if self._first is None:
            self._first = self._last = time
        step, self._last = time - self._last, time
        self._follow()
        if self._over or self._behind():
            self._left_out += step
        else:
            self._handed = time
            if not self._waits:
                self._under_way.append(time)
            self._collected.append(encode_sample(tick, tracks, objects, hidden))
        self._hand_over()

    def truth(self, time: float, pose: Sequence[float]) -> None:
        """Record where the base really is, as :meth:`~humanoid_bt.record.recorder.Recorder.truth`."""
        self._collected.append(encode_call("truth", time, pose))

    def routes(self, time: float, routes: Sequence[Sequence[Sequence[float]]]) -> None:
        """Record the ways that are followed, as :meth:`~humanoid_bt.record.recorder.Recorder.routes`."""
        self._collected.append(encode_call("routes", time, routes))

    def cycles(self, plans: Array, cycles: Array) -> None:
        """Record servo cycles, as :meth:`~humanoid_bt.record.recorder.Recorder.cycles`."""
        self._collected += encode_cycles(plans, cycles)

    def follow(self, plans: Path, cycles: Path) -> None:
        """Record the servo cycles that control keeps in these tables, whatever becomes of this process."""
        self._collected.append(encode_call("follow", plans, cycles))
        self._hand_over()

    def node_changed(self, time: float, path: str, status: str, feedback: str) -> None:
        """Record that a node's status changed."""
        self._collected.append(encode_call("node_changed", time, path, status, feedback))

    def results(self, time: float, path: str, results: Sequence[Reported]) -> None:
        """Record what a skill has reported by now."""
        if results:
            self._collected.append(encode_results(time, path, results))

    def show_tree(self, time: float, tree: TreeView, info: Mapping[str, str]) -> None:
        """Record that another tree takes the place of the one so far."""
        self._collected.append(encode_call("show_tree", time, tree, info))

    def event(self, time: float, level: Level, text: str) -> None:
        """Record something that happened."""
        self._collected.append(encode_call("event", time, level, text))
        self._hand_over()  # at once: it may be the last word of a skill that ends the process

    def news(self, time: float, kind: str, value: Any) -> None:
        """Keep something that happened, as :meth:`~humanoid_bt.record.recorder.Recorder.news`."""
        self._collected.append(encode_call("news", time, kind, value))

    # ---- what became of it ------------------------------------------------------------------------------------------

    @property
    def length(self) -> float:
        """Time that there was to record [s]."""
        return 0.0 if self._first is None else self._last - self._first

    @property
    def missing(self) -> float:
        """How much of that the recording lacks [s]; final after :meth:`close`."""
        if self._first is None:
            return 0.0
        return self._left_out + self._handed - max(self._written, self._first)

    def take_news(self) -> list[tuple[Level, str]]:
        """Return what went wrong since the last time: how bad it is, and a line of text."""
        news, self._news = self._news, []
        return news

    # ---- the other process ------------------------------------------------------------------------------------------

    def _behind(self) -> bool:
        """Return whether the recorder is too far behind what it was given to be given more."""
        while self._under_way and self._under_way[0] <= self._written:
            self._under_way.popleft()
        behind = not self._waits and len(self._under_way) * DECISION_PERIOD > _BEHIND
        if behind and not self._told_behind:
            self._told_behind = True
            text = f"the recorder is more than {_BEHIND:g} s behind: what it cannot take is missing in the recording"
            self._news.append(("error", text))
        return behind

    def _hand_over(self) -> None:
        """Hand over what was collected, and what still waits before it: one call of the system a tick."""
        collected, self._collected = self._collected, []
        if self._over:
            return
        try:
            self._outbox.put(b"".join(collected))
        except Stuck:
            self._lose(f"the recorder took nothing for {_PATIENCE:g} s and was ended")
        except OSError:  # it is about to be heard how it ended
            pass
        if self._outbox.size > _ROOM and not self._over:
            self._lose("the recorder was far too slow and was ended")

    def _follow(self) -> None:
        """Hear all that the recorder has said, to its end if it has ended."""
        try:
            while not self._over and self._ears.poll(0):
                self._hear()
        except OSError:
            if how := how_ended(self._process):  # else it is about to
                self._lose(f"the recorder process ended ({how})")

    def _lose(self, what: str, *, kill: bool = True) -> None:
        """Go on without a recorder, in the midst of the run."""
        self._over = True
        if kill:
            self._process.kill()
        self._news.append(("error", f"{what}: nothing is recorded from {self._last:.2f} s on"))

    def _hear(self) -> None:
        """Take what there is.

        Raises:
            OSError: there never will be anything.
        """
        data = self._end.recv(1 << 16)
        if not data:
            raise ConnectionResetError
        *lines, self._inbox = (self._inbox + data).split(b"\n")
        for kind, *values in map(json.loads, lines):
            match kind:
                case "written":
                    (self._written,) = values
                case "told":
                    self._news.append((values[0], values[1]))
                case "failed":
                    self._lose(f"the recorder failed ({values[0]})", kill=False)  # it closes the file
                case _:
                    self._answers.append([kind, *values])

    def _answer(self, patience: float) -> list[Any]:
        """Wait for an answer.

        Raises:
            Stuck: there was no sign of life for so long [s].
            OSError: there will be none.
        """
        while not self._answers:
            if self._over or not self._ears.poll(1000 * patience):
                raise Stuck
            self._hear()
        return self._answers.pop(0)

    def _finish(self) -> None:
        """Have the recording closed."""
        self._hand_over()
        what, limit = "read what it was given", 0.0
        try:
            self._outbox.put(encode_call("close"), _PATIENCE)
            with suppress(OSError):  # it has closed already
                self._end.shutdown(socket.SHUT_WR)
            while (answer := self._answer(limit + _PATIENCE))[0] != "closed":
                _, what, limit = answer
        except Stuck:
            if not self._over:  # else it has failed, and that is told
                took = f"more than {limit + _PATIENCE:g} s"
                self._news.append(("error", f"the recorder was ended: it took {took} to {what}"))
        except OSError:
            why = f"the recorder process ended before the recording was closed ({self._how_ended()})"
            self._news.append(("error", why))

    def _how_ended(self) -> str:
        """Return how the process ended, which has let go of its end: it may take a moment to be gone."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_END_TIMEOUT)
        return how_ended(self._process) or "it ended"


def _start(end: socket.socket, core: int | None) -> subprocess.Popen[bytes]:
    """Start the process out of reach of the terminal's signals: they are decision's to answer."""
    try:
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "humanoid_bt.record.recorder_process", *([] if core is None else [str(core)])],
            stdin=end.fileno(),
            stdout=subprocess.DEVNULL,
            env={**os.environ, **_ENVIRONMENT},
            start_new_session=True,
        )
    except OSError as error:
        raise HumanoidBtError(f"the recorder process cannot be started: {error.strerror}") from error


_ends: weakref.WeakSet[socket.socket] = weakref.WeakSet()


def _leave_to_parent() -> None:
    """Close the ends in a child that a skill forked: a recorder ends when nobody has its other end any more."""
    for end in list(_ends):
        end.close()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


def _end_process(process: subprocess.Popen[bytes], end: socket.socket) -> None:
    end.close()
    if process.poll() is None:
        with suppress(ProcessLookupError):  # with what its libraries start as they load, which would complain
            os.killpg(process.pid, signal.SIGKILL)
    with suppress(subprocess.TimeoutExpired):
        process.wait(_END_TIMEOUT)
