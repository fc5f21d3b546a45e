"""When and where a swinging foot lands, from where the DCM is now.

In single support the DCM runs away from the pressure under the foot as xi(T) = p + (xi - p) exp(omega T). Place u and
time T of the next foothold shall leave the DCM where it was meant to be, seen from that foothold:

    minimise (u - u_plan)^2 + a (tau - tau_plan)^2 + b (p + (xi - p) tau - u - offset)^2,  tau = exp(omega T),

within bounds on u and tau (Khadiv, Herzog, Moosavian, Righetti, "Walking control based on step timing adaptation",
IEEE T-RO 36(3), 2020). For a given tau the best u is known, so this is one convex function of tau.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

_TIMING_COST = 0.01  # a [m^2]
_OFFSET_COST = 100.0  # b: a wrong offset is what makes a robot fall


@dataclass(slots=True)
class Axis:
    """One of the two directions of the ground, seen from the support foot.

    Attributes:
        pressure: where it stays until the foot lands [m].
        dcm: seen from that pressure [m].
        planned: foothold [m].
        offset: where the DCM is to be then, seen from the foothold [m].
        least, most: bounds of the foothold [m].
    """

    pressure: float
    dcm: float
    planned: float
    offset: float
    least: float
    most: float

    def place(self, tau: float) -> float:
        """Return the best foothold [m] for a time."""
        wanted = self.pressure + self.dcm * tau - self.offset
        best = (self.planned + _OFFSET_COST * wanted) / (1 + _OFFSET_COST)
        return min(max(best, self.least), self.most)

    def slope(self, tau: float) -> float:
        """Return half the derivative of the cost by tau, with the best foothold for each tau."""
        return _OFFSET_COST * self.dcm * (self.pressure + self.dcm * tau - self.offset - self.place(tau))

    def bends(self) -> list[float]:
        """Return where the slope bends: the tau beyond which a bound holds the foothold."""
        if abs(self.dcm) < 1e-6:
            return []
        rest = self.offset - self.pressure
        ends = (((1 + _OFFSET_COST) * end - self.planned) / _OFFSET_COST for end in (self.least, self.most))
        return [(end + rest) / self.dcm for end in ends]


def best_time(axes: Sequence[Axis], planned: float, least: float, most: float) -> float:
    """Return the best tau in its bounds: the zero of a slope that grows, and is straight from bend to bend."""

    def slope(tau: float) -> float:
        return _TIMING_COST * (tau - planned) + sum(axis.slope(tau) for axis in axes)

    if slope(most) <= 0:  # as planned
        return most
    low, low_slope = least, slope(least)
    if low_slope >= 0:
        return least
    bends = sorted(bend for axis in axes for bend in axis.bends() if least < bend < most)
    for high in (*bends, most):
        high_slope = slope(high)
        if high_slope > 0:
            return low - low_slope * (high - low) / (high_slope - low_slope)
        low, low_slope = high, high_slope
    return most
