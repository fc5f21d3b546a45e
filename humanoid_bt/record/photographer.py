"""Orders pictures from the camera's process, and never waits for them while the run goes on."""

from __future__ import annotations

import math
import threading
import time

from humanoid_bt.plant.camera_client import CameraLost, CameraProcess
from humanoid_bt.plant.rendering import Setup, Shot

_MOST = 32  # waiting pictures above which every second is left out
_PATIENCE = 0.02  # share of the time so far that it waits at the end for what is not there yet
_MOST_PATIENCE = 5.0  # s that this is at most
_LONG_PATIENCE = 60.0  # s that it waits where every picture is wanted
_START_TIMEOUT = 30.0  # s until it must be known whether there can be pictures
_END_TIMEOUT = 5.0  # s that its thread may take to be gone: longer only if the system itself hangs


class Photographer:
    """Has the camera's process, and a thread that hands over shots and takes the pictures back.

    Args:
        setup: of the camera.
        slowest: what a picture may take of the processor [s]; inf for any time, and
            for every picture: none is left out then.

    Attributes:
        why: why there are no pictures, "" as long as there may be some.
    """

    def __init__(self, setup: Setup, slowest: float) -> None:
        self.why = ""
        self._all = math.isinf(slowest)
        self._news = threading.Condition()
        self._waiting: list[Shot] = []
        self._taken: list[tuple[Shot, bytes]] = []
        self._ending = self._over = False
        self._began = time.monotonic()
        self._answered = threading.Event()
        self._camera = CameraProcess(setup, slowest)
        self._thread = threading.Thread(target=self._work, name="camera", daemon=True)
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
        return _LONG_PATIENCE if self._all else min(_PATIENCE * (time.monotonic() - self._began), _MOST_PATIENCE)

    def finish(self) -> None:
        """Give pictures that are not there yet a little time, then end the process."""
        if self._over:
            return
        self._over = True
        with self._news:
            self._ending = True
            self._news.notify()
        self._thread.join(self.patience)
        if not self._answered.is_set():
            self.why = "the run was over before the first one was there"
        self._camera.end()
        self._thread.join(_END_TIMEOUT)

    def _work(self) -> None:
        try:
            why = self._camera.open()
            if self._camera.over:
                return
            self.why = why
            self._answered.set()
            while not self.why and (shot := self._next()) is not None:
                picture = self._camera.take(shot)
                with self._news:
                    self._taken.append((shot, picture))
        except CameraLost as error:
            if not self._ending:
                self.why = str(error)
        finally:
            self._answered.set()

    def _next(self) -> Shot | None:
        """Wait for the next shot; return None when there will be none."""
        with self._news:
            self._news.wait_for(lambda: self._waiting or self._ending)
            return self._waiting.pop(0) if self._waiting else None
