"""The camera's process as those see it who want pictures."""

from __future__ import annotations

import contextlib
import os
import pickle
import select
import subprocess
import sys
from typing import Any

from humanoid_bt.plant.opengl import CHOICE
from humanoid_bt.plant.rendering import Setup, Shot

_END_TIMEOUT = 5.0  # s that a killed process may take to be gone: longer only if the system itself hangs
_OTHER_CHOICE = "PYOPENGL_PLATFORM"  # PyOpenGL's; MuJoCo sets it itself, and refuses any but its own
_BEGIN_TIMEOUT = 60.0  # s until it is ready, at least: a busy machine takes long to load MuJoCo
_OTHERS = ("osmesa",) if sys.platform == "linux" else ()  # ways to render without a display, besides the first one


class CameraLost(OSError):  # noqa: N818 (the name says it)
    """The camera's process has ended, or does not answer."""


class CameraProcess:
    """A process that takes pictures, one after the other.

    Args:
        setup: of the camera.
        slowest: what a picture may take [s]; inf for any time.
        timeout: how long it may take to answer [s], once it is ready; None for any time.

    Attributes:
        process: it, None before :meth:`open`.
        over: whether it was ended.
    """

    def __init__(self, setup: Setup, slowest: float, timeout: float | None = None) -> None:
        self._setup, self._slowest, self._timeout = setup, slowest, timeout
        self.process: subprocess.Popen[bytes] | None = None
        self.over = False

    def open(self) -> str:
        """Start it; return why there are no pictures, "" if there are.

        Where EGL does not render, OSMesa is tried, unless ``MUJOCO_GL`` says what is to be used.
        """
        why = self._started(None)
        if why and (chosen := os.environ.get(CHOICE)):
            return f"{why}; {CHOICE} is {chosen!r}: unset it, and EGL or OSMesa is taken, whichever is there"
        for other in _OTHERS if why else ():
            self._kill()
            if not self.over and not self._started(other):
                return ""
        return why

    def take(self, shot: Shot) -> Any:
        """Return a picture, as :meth:`~humanoid_bt.plant.rendering.Camera.take` gives it.

        Raises:
            CameraLost: there is none.
        """
        return self._ask(shot, self._timeout)

    def end(self) -> None:
        """End it for good, whatever it is at."""
        self.over = True
        self._kill()

    def _kill(self) -> None:
        if self.process is None:
            return
        self.process.kill()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(_END_TIMEOUT)

    def _started(self, backend: str | None) -> str:
        environment = {**os.environ, "LP_NUM_THREADS": "0", "OMP_NUM_THREADS": "1"}
        environment.pop(_OTHER_CHOICE, None)
        if backend is not None:
            environment[CHOICE] = backend
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-P", "-m", "humanoid_bt.plant.camera_process"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=environment,
                start_new_session=True,  # Ctrl-C ends the run, and the run this
            )
        except OSError as error:
            return f"its process cannot be started: {error.strerror}"
        if self.over:  # another thread has ended it meanwhile
            self._kill()
        try:
            patience = None if self._timeout is None else max(self._timeout, _BEGIN_TIMEOUT)
            answer: str = self._ask((pickle.dumps(self._setup), self._slowest), patience)
        except CameraLost as error:
            return str(error)
        return answer

    def _ask(self, question: object, timeout: float | None) -> Any:
        process = self.process
        if process is None or process.stdin is None or process.stdout is None:
            raise CameraLost("its process ended")
        try:
            pickle.dump(question, process.stdin)
            process.stdin.flush()
            if timeout is not None and not select.select([process.stdout], [], [], timeout)[0]:
                raise CameraLost(f"its process did not answer within {timeout:g} s")
            return pickle.load(process.stdout)  # from a process that was started here
        except CameraLost:
            raise
        except (OSError, EOFError, ValueError, pickle.UnpicklingError):
            raise CameraLost("its process ended") from None
