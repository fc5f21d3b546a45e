"""The process that records: what it is to record comes in, then every call; what becomes of it goes out, line by line.

A process of its own, because encoding and writing take longer than decision may be silent. It ends when its input ends,
also when the run's process was killed: what that had handed over by then is written, and the file is closed.
"""

from __future__ import annotations

import io
import json
import logging
import os
import pickle
import signal
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.texts import told
from humanoid_bt.record.sample import decode_call

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

    from humanoid_bt.record.recorder import Recorder

_NICE = 5  # behind the run, before what is only meant to fill idle cores
_PAUSE = 0.01  # s between two looks at what came in
_GATHERING = 0.05  # s for which what comes in is gathered: what is done at one go takes half of the time of one by one
_SAVE = 0.03  # s after which what came in stands in the file, if it is what must not be lost
_SAVE_LOCKSTEP = 0.1  # s of a run that another one repeats to the bit
_SILENCE = 1.0  # s without a call after which what came otherwise is written
_CHUNK = 1 << 16  # bytes that are read at once
_ALONE = 60.0  # s to close a recording that nobody waits for any more


class RecorderProcess:
    """Records one run.

    Args:
        end: this process's end of the stream to decision.
    """

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self._saying = threading.Lock()
        self._source = _Unpeeked(io.BufferedReader(_Unhurried(end, self._idle, self._patience), _CHUNK))
        self._recorder: Recorder | None = None
        self._written = -float("inf")
        self._trouble = ""
        self._saved = 0.0  # on the monotonic clock [s]
        self._last = 0.0  # engine time of the last tick [s]
        self._heard = time.monotonic()
        self._left_out: set[str] = set()  # of what calls something was left out
        logging.getLogger().addHandler(_Telling(self))

    def run(self) -> None:
        """Record until decision closes the recording, or is gone."""
        from humanoid_bt.record.recorder import Recorder  # noqa: PLC0415  # while decision reads its tree

        try:
            while self._recorder is None:
                _, (setup,) = decode_call(self._source)
                self._recorder = self._opened(Recorder, setup)
            while self._obey(self._recorder, *decode_call(self._source)):
                pass
        except (EOFError, ConnectionError, pickle.UnpicklingError):
            self._outlast_control()
            self._close_alone("the process of the run ended without closing the recording")
        except Exception as error:  # a mistake of our own: the run goes on without a recording
            traceback.print_exc()
            self.say("failed", f"{type(error).__name__}: {error}")
            self._close_alone("the recorder failed")

    def _opened(self, kind: type[Recorder], setup: Mapping[str, Any]) -> Recorder | None:
        """Return the recorder, or None if it cannot be made; say which."""
        try:
            recorder = kind(
                **setup,
                announce=lambda what, limit: self.say("busy", what, limit),
                tell=lambda level, text: self.say("told", level, text),
            )
        except UserError as error:
            self.say("refused", [(problem.message, problem.hint) for problem in error.problems])
            return None
        self.say("opened", recorder.url)
        return recorder

    def _obey(self, recorder: Recorder, method: str, arguments: tuple[Any, ...]) -> bool:
        """Do what decision asks; return whether more can come."""
        self._heard = time.monotonic()
        try:
            getattr(recorder, method)(*arguments)
        except Exception as error:
            if method == "close":
                raise
            self._leave_out(method, error)
        if method == "sample":  # a tick is whole
            self._last = arguments[0].time
            self._save()
        self._tell(recorder)
        if method == "close":
            self.say("closed")
        return method != "close"

    def _leave_out(self, method: str, error: Exception) -> None:
        """Go on without what cannot be recorded; tell it once, for it may be so in every tick of hours."""
        if method not in self._left_out:
            self._left_out.add(method)
            self.say("told", "warning", f"something ({method}) cannot be recorded, and is left out: {told(error)}")

    def _save(self) -> None:
        """Write what must not be lost, if the last time was long enough ago."""
        now, recorder = time.monotonic(), self._recorder
        if recorder is not None and now - self._saved >= (_SAVE if recorder.follows else _SAVE_LOCKSTEP):
            self._saved = now
            recorder.save()
            self._tell(recorder)

    def _tell(self, recorder: Recorder) -> None:
        """Say what became of the file, if that has changed."""
        if recorder.written != self._written:
            self._written = recorder.written
            self.say("written", self._written)
        if recorder.trouble != self._trouble:
            self._trouble = recorder.trouble
            self.say("told", "error", self._trouble)

    def _idle(self) -> None:
        """Write what control goes on to do while decision hangs: it must not be lost, nor fill the memory."""
        self._save()
        if self._recorder is not None and time.monotonic() - self._heard > _SILENCE:
            self._heard = time.monotonic()
            self._recorder.write()

    def _patience(self) -> float:
        """Return how long what came in may wait [s]."""
        return 0.0 if self._recorder is None or self._recorder.follows else _GATHERING

    def _outlast_control(self) -> None:
        """Go on as long as control does, which holds the robot when decision is gone."""
        while self._recorder is not None and self._recorder.control_lives:
            self._idle()
            time.sleep(_PAUSE)

    def _close_alone(self, why: str) -> None:
        """Close the recording, for which nobody waits."""
        if self._recorder is None:
            return
        guard = threading.Timer(_ALONE, os._exit, (1,))
        guard.daemon = True
        guard.start()
        self._recorder.event(self._last, "error", why)
        self._recorder.close()

    def say(self, kind: str, *values: object) -> None:
        """Tell decision, if it is there."""
        with suppress(OSError), self._saying:
            self._end.sendall(json.dumps([kind, *values]).encode() + b"\n")


class _Unhurried(io.RawIOBase):
    """Reads a stream and looks at it from time to time, instead of sleeping on it.

    Whoever writes to a process that sleeps wakes it up, and may have to make room for it at once.

    Args:
        end: of the stream.
        idle: done at every look that finds nothing to hand on.
        patience: returns how long what came in may wait for more [s]; at the stream's end nothing waits.
    """

    def __init__(self, end: socket.socket, idle: Callable[[], None], patience: Callable[[], float]) -> None:
        self._end, self._idle, self._patience = end, idle, patience
        self._gathered = memoryview(b"")
        self._due = 0.0  # when it is handed on, on the monotonic clock [s]

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: WriteableBuffer) -> int:
        view = memoryview(buffer)
        if not self._gathered:
            self._gathered = memoryview(self._gather())
        size = min(len(view), len(self._gathered))
        view[:size], self._gathered = self._gathered[:size], self._gathered[size:]
        return size

    def _gather(self) -> bytes:
        """Return what came in; nothing at the stream's end."""
        parts: list[bytes] = []
        while True:
            try:
                parts.append(self._end.recv(_CHUNK, socket.MSG_DONTWAIT))
            except ConnectionError:  # closed by somebody who has not heard all that was said
                break
            except BlockingIOError:
                now = time.monotonic()
                if parts and now >= self._due:
                    self._due = now + self._patience()
                    break
                self._idle()
                time.sleep(_PAUSE)
                continue
            if not parts[-1]:
                break
        return b"".join(parts)


class _Unpeeked:
    """What pickle needs of a stream, but ``peek``: with that it copies all that is buffered at every step.

    Args:
        stream: it.
    """

    def __init__(self, stream: io.BufferedReader) -> None:
        self.read, self.readinto, self.readline = stream.read, stream.readinto, stream.readline


class _Telling(logging.Handler):
    """Makes an event of the run of what is logged here."""

    def __init__(self, process: RecorderProcess) -> None:
        super().__init__(logging.WARNING)
        self._process = process

    def emit(self, record: logging.LogRecord) -> None:
        self._process.say("told", "warning", record.getMessage())


def main() -> None:
    """Record the run at the other end of the standard input, which takes answers too.

    The argument, if there is any, is the processor that is left to control.
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda _number, _frame: None)  # they are decision's to answer: its end is this one's
    with suppress(OSError):
        os.nice(_NICE)
    if sys.platform == "linux":
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))  # when it wakes up it takes no core from the run
        os.sched_setaffinity(0, os.sched_getaffinity(0) - set(map(int, sys.argv[1:])))
    RecorderProcess(socket.socket(fileno=sys.stdin.fileno())).run()
    os._exit(0)  # all is closed; whatever the viewer's library still waits for, nobody needs it


if __name__ == "__main__":
    main()
