"""Control's side of the e-stop: what is raised stops the robot, and resets are answered."""

from __future__ import annotations

from collections.abc import Callable

from humanoid_bt.control.supervisor import Supervisor, reset_text
from humanoid_bt.core.messages import Level, Mode
from humanoid_bt.link.estop import EStop
from humanoid_bt.link.segment import LinkError

Tell = Callable[[Level, str], None]
"""Is told what happens."""


class EStopFollower:
    """Lets a supervisor obey the e-stop of a run.

    Args:
        estop: an end of it, for this alone.
        supervisor: what stops the robot.
        tell: is told of resets, and of answers that cannot be written.
    """

    def __init__(self, estop: EStop, supervisor: Supervisor, tell: Tell) -> None:
        self._estop, self._supervisor, self._tell = estop, supervisor, tell
        self._look_again = False  # what is raised there is not in force yet

    def poll(self) -> None:
        """Do what is new, if anything is."""
        if self._estop.poll() or self._look_again:
            self._follow()

    def reset(self, source: str) -> None:
        """Ask for a reset, and answer it at once.

        Raises:
            LinkError: it cannot be written; nothing is done.
        """
        self._estop.request_reset(source)
        while self._estop.poll():
            pass
        self._follow()

    def close(self) -> None:
        """Let go of the e-stop."""
        self._estop.close()

    def _follow(self) -> None:
        supervisor = self._supervisor
        raised = self._estop.raised
        if raised is not None:
            supervisor.raise_estop(raised.source, raised.reason)
        self._look_again = raised is not None and supervisor.mode not in (Mode.EMERGENCY_STOP, Mode.DAMP)
        if self._look_again:
            return  # a reset clears only what has stopped the robot
        while (request := self._estop.reset_request) is not None:
            refusal = supervisor.reset()
            try:
                self._estop.answer(request.ticket, not refusal, refusal)
            except LinkError as error:  # not told, so not done: what is raised there is taken up again
                self._tell("error", str(error))
                break
            self._tell("warning", reset_text(request.source, refusal))
        raised = self._estop.raised
        if raised is not None:
            supervisor.raise_estop(raised.source, raised.reason)
