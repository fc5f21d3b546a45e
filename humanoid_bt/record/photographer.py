"""Orders pictures from the camera's process, and never waits for them while the run goes on."""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import subprocess
import sys
import threading
import time
from typing import Any

from humanoid_bt.record.rendering import Setup, Shot

_MOST = 32  # waiting pictures above which every second is left out
_PATIENCE = 0.02  # share of the time so far that it waits at the end for what is not there yet
_LONG_PATIENCE = 60.0  # s that it waits where every picture is wanted
_START_TIMEOUT = 30.0  # s until it must be known whether there can be pictures
_END_TIMEOUT = 5.0  # s that a killed process may take to be gone: longer only if the system itself hangs


class Photographer:
    """Has the camera's process, and a thread that hands over shots and takes the pictures back.

    Args:
        setup: of the camera.
        slowest: what a picture may take [s]; inf for any time, and for every picture: none is left out then.

    Attributes:
        why: why there are no pictures, "" as long as there may be some.
    """

    def __init__(self, setup: Setup, slowest: float) -> None:
        self.why = ""
        self._slowest = slowest
        self._all = math.isinf(slowest)
        self._news = threading.Condition()
        self._waiting: list[Shot] = []
        self._taken: list[tuple[Shot, bytes]] = []
        self._ending = False
        self._began = time.monotonic()
        self._answered = threading.Event()
        self._process: subprocess.Popen[bytes] | None = None
        self._thread = threading.Thread(target=self._work, args=(setup,), name="camera", daemon=True)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "humanoid_bt.record.camera_process"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**os.environ, "LP_NUM_THREADS": "0", "OMP_NUM_THREADS": "1"},
                start_new_session=True,  # Ctrl-C ends the run, and the run this
            )
        except OSError as error:
            self.why = f"its process cannot be started: {error.strerror}"
            self._answered.set()
        else:
            self._thread.start()

    def wait_until_ready(self) -> None:
        """Wait until it is known whether there will be pictures."""
        if not self._answered.wait(_START_TIMEOUT):
            self.why = f"its process did not answer within {_START_TIMEOUT:g} s"

    def order(self, shot: Shot) -> None:
        """Have a picture taken."""
        with self._news:
            self._waiting.append(shot)
            if len(self._waiting) > _MOST and not self._all:
                del self._waiting[1::2]
            self._news.notify()

    def collect(self) -> list[tuple[Shot, bytes]]:
        """Return the pictures taken since the last time, as JPEG."""
        with self._news:
            taken, self._taken = self._taken, []
            return taken

    @property
    def patience(self) -> float:
        """How long :meth:`finish` waits for pictures that are not there yet [s]."""
        return _LONG_PATIENCE if self._all else _PATIENCE * (time.monotonic() - self._began)

    def finish(self) -> None:
        """Give pictures that are not there yet a little time, then end the process."""
        if self._process is None:
            return
        with self._news:
            self._ending = True
            self._news.notify()
        self._thread.join(self.patience)
        if not self._answered.is_set():
            self.why = "the run was over before the first one was there"
        self._process.kill()
        self._thread.join(_END_TIMEOUT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_END_TIMEOUT)
        self._process = None

    def _work(self, setup: Setup) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            with self._process.stdin as sink, self._process.stdout as source:
                self.why = _ask((pickle.dumps(setup), self._slowest), sink, source)
                self._answered.set()
                while not self.why and (shot := self._next()) is not None:
                    picture = _ask(shot, sink, source)
                    with self._news:
                        self._taken.append((shot, picture))
        except (OSError, EOFError, pickle.UnpicklingError):
            if not self._ending:
                self.why = "its process ended"
        finally:
            self._answered.set()

    def _next(self) -> Shot | None:
        """Wait for the next shot; return None when there will be none."""
        with self._news:
            self._news.wait_for(lambda: self._waiting or self._ending)
            return self._waiting.pop(0) if self._waiting else None


def _ask(question: object, sink: Any, source: Any) -> Any:
    pickle.dump(question, sink)
    sink.flush()
    return pickle.load(source)  # from a process that was started here
