"""The engine's clock: every timeout, watchdog and timer reads it, never ``time.*``."""

from __future__ import annotations

from typing import Protocol

SERVO_PERIOD = 0.001
"""Servo and physics period [s] (1000 Hz)."""

ESTIMATE_PERIOD = 0.005
"""Period of the estimate of the robot [s] (200 Hz); a whole multiple of the servo period."""

WHOLE_BODY_PERIOD = 0.010
"""Whole-body control period [s] (100 Hz); a whole multiple of the period of the estimate."""

DECISION_PERIOD = 0.020
"""Tree tick period [s] (50 Hz)."""

PERCEPTION_PERIOD = 0.100
"""Perception period [s] (10 Hz)."""

HOLD_TIME = 10.0
"""How long control goes on balancing the robot after decision died, unless it is told otherwise [s]."""


def cycles(seconds: float) -> int:
    """Return how many servo cycles a duration [s] takes, to the nearest."""
    return round(seconds / SERVO_PERIOD)


class Clock(Protocol):
    """What tells the time."""

    def now(self) -> float:
        """Return the engine's time [s] since the run began."""
        ...


class TreeClock:
    """The engine's time without the time for which the tree stood still: what its timers see.

    Args:
        engine: the engine's clock.

    Attributes:
        stood: for how long it stood still so far [s].
    """

    def __init__(self, engine: Clock) -> None:
        self._engine = engine
        self.stood = 0.0

    def now(self) -> float:
        """Return the tree's time [s]."""
        return self._engine.now() - self.stood


class CycleClock:
    """Simulation time.

    Attributes:
        cycle: servo cycles since the run began; set it as they pass.
    """

    def __init__(self) -> None:
        self.cycle = 0

    def now(self) -> float:
        """Return the engine's time [s]."""
        return self.cycle * SERVO_PERIOD

    def due(self, period_cycles: int) -> bool:
        """Return whether a loop that runs every ``period_cycles`` runs in this cycle."""
        return self.cycle % period_cycles == 0
