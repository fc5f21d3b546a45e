"""When and where a swinging foot lands, from where the DCM is now.

In single support the DCM runs away from the pressure under the foot as xi(T) = p + (xi - p) exp(omega T). Place u and
time T of the next foothold shall leave the DCM where it was meant to be, seen from that foothold:

    minimise (u - u_plan)^2 + a (tau - tau_plan)^2 + b (p + (xi - p) tau - u - offset)^2,  tau = exp(omega T),

within bounds on u and tau (Khadiv, Herzog, Moosavian, Righetti, "Walking control based on step timing adaptation",
IEEE T-RO 36(3), 2020). What the foot can reach until then bounds u, too: a step that must be quick is a short one.
For a given tau the best u is known, which leaves one function of tau.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

_TIMING_COST = 0.01  # a [m^2]
_OFFSET_COST = 100.0  # b: a wrong offset is what makes a robot fall
_GOLDEN = 0.618
_ROUNDS = 7  # that narrow the time down to a thirtieth


@dataclass(slots=True)
class Axis:
    """One of the two directions of the ground, seen from the support foot.

    Attributes:
        pressure: where it stays until the foot lands [m].
        dcm: seen from that pressure [m].
        planned: foothold [m].
        offset: where the DCM is to be then, seen from the foothold [m].
        least, most: bounds of the foothold [m].
        foot: where the foot is now [m].
    """

    pressure: float
    dcm: float
    planned: float
    offset: float
    least: float
    most: float
    foot: float

    def place(self, tau: float, reach: float) -> float:
        """Return the best foothold [m] for a time, in which the foot gets so far [m]."""
        wanted = self.pressure + self.dcm * tau - self.offset
        best = (self.planned + _OFFSET_COST * wanted) / (1 + _OFFSET_COST)
        near = min(max(best, self.foot - reach), self.foot + reach)
        return min(max(near, self.least), self.most)

    def cost(self, tau: float, reach: float) -> float:
        """Return what the best foothold for a time costs."""
        place = self.place(tau, reach)
        missed = self.pressure + self.dcm * tau - self.offset - place
        return (place - self.planned) ** 2 + _OFFSET_COST * missed * missed


def best_time(axes: Sequence[Axis], planned: float, least: float, most: float, *, omega: float, speed: float) -> float:
    """Return the best tau in its bounds.

    Args:
        axes: both directions.
        planned: tau of the plan.
        least, most: bounds of tau.
        omega: of the DCM [1/s].
        speed: of the foot on its way, on average [m/s].
    """

    def cost(tau: float) -> float:
        reach = speed * math.log(tau) / omega
        return _TIMING_COST * (tau - planned) ** 2 + sum(axis.cost(tau, reach) for axis in axes)

    if most - least < 1e-6 or cost(most) <= cost(most - 1e-3 * (most - least)):  # as planned
        return most
    low, high = least, most
    inner, outer = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    inner_cost, outer_cost = cost(inner), cost(outer)
    for _ in range(_ROUNDS):
        if inner_cost < outer_cost:
            high, outer, outer_cost = outer, inner, inner_cost
            inner = high - _GOLDEN * (high - low)
            inner_cost = cost(inner)
        else:
            low, inner, inner_cost = inner, outer, outer_cost
            outer = low + _GOLDEN * (high - low)
            outer_cost = cost(outer)
    return min((least, inner, outer), key=cost)
