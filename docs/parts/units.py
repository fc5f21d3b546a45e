"""Numbers: the units they may be written in, and the periods of the loops."""

from __future__ import annotations

from humanoid_bt.core import clock
from humanoid_bt.core.units import UNITS, factors
from parts.markdown import code, table


def units() -> str:
    """Return the table of units."""
    return table(("declared in", "may be written in"), [(f"`{unit}`", code(factors(unit))) for unit in UNITS])


def clocks() -> str:
    """Return the table of the loops' periods."""
    loops = {
        "servo, supervisor, physics": clock.SERVO_PERIOD,
        "estimate: where the robot is, what it carries and feels": clock.ESTIMATE_PERIOD,
        "whole body: balance, walking, inverse kinematics": clock.WHOLE_BODY_PERIOD,
        "decision: one tick of the tree": clock.DECISION_PERIOD,
        "perception": clock.PERCEPTION_PERIOD,
    }
    rows = [
        (name, f"{1 / period:g} Hz", f"{period * 1000:g} ms", f"{clock.cycles(period)}")
        for name, period in loops.items()
    ]
    return table(("loop", "rate", "period", "servo cycles"), rows)
