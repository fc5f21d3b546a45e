"""What hysteresis remembers."""

from __future__ import annotations

from humanoid_bt.decision.robot import Robot


class Held:
    """Whether something held when it was asked last, if that was in this tick or the one before.

    What was not asked for a whole tick has begun anew: its branch was left, another part of its expression decided,
    or nobody told what it asks for.

    Attributes:
        holds: whether it held then.
    """

    __slots__ = ("_asked", "holds")

    def __init__(self) -> None:
        self.holds = False
        self._asked = 0  # in which tick

    def ask(self, robot: Robot) -> bool:
        """Return whether it has held up to now; it does not any more until ``holds`` is set."""
        held, self.holds = self.holds and robot.ticks - self._asked <= 1, False
        self._asked = robot.ticks
        return held
