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
from typing import NamedTuple

from humanoid_bt.core.compiled import inlined

_TIMING_COST = 0.01  # a [m^2]
_OFFSET_COST = 100.0  # b: a wrong offset is what makes a robot fall
_GOLDEN = 0.618
_ROUNDS = 7  # that narrow the time down to a thirtieth


class Axis(NamedTuple):
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


class Pace(NamedTuple):
    """What is known of the time.

    Attributes:
        planned: tau of the plan.
        omega: of the DCM [1/s].
        speed: of the foot on its way, on average [m/s].
    """

    planned: float
    omega: float
    speed: float


@inlined
def best_place(axis: Axis, tau: float, pace: Pace) -> float:
    """Return the best foothold [m] for a time."""
    reach = pace.speed * math.log(tau) / pace.omega
    wanted = axis.pressure + axis.dcm * tau - axis.offset
    best = (axis.planned + _OFFSET_COST * wanted) / (1 + _OFFSET_COST)
    near = min(max(best, axis.foot - reach), axis.foot + reach)
    return min(max(near, axis.least), axis.most)


@inlined
def miss(axis: Axis, tau: float, pace: Pace) -> float:
    """Return how far beyond its place seen from the best foothold the DCM will be [m]."""
    return axis.pressure + axis.dcm * tau - axis.offset - best_place(axis, tau, pace)


@inlined
def _cost(axes: tuple[Axis, Axis], tau: float, pace: Pace) -> float:
    """Return what a time costs, with the best foothold for it."""
    total = 0.0
    for axis in axes:
        missed = miss(axis, tau, pace)
        total += (best_place(axis, tau, pace) - axis.planned) ** 2 + _OFFSET_COST * missed * missed
    return _TIMING_COST * (tau - pace.planned) ** 2 + total


@inlined
def best_time(axes: tuple[Axis, Axis], least: float, most: float, pace: Pace) -> float:
    """Return the best tau in its bounds.

    Args:
        axes: both directions.
        least, most: bounds of tau.
        pace: the rest.
    """
    if most - least < 1e-6 or _cost(axes, most, pace) <= _cost(axes, most - 1e-3 * (most - least), pace):
        return most  # as planned
    low, high = least, most
    inner, outer = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    inner_cost, outer_cost = _cost(axes, inner, pace), _cost(axes, outer, pace)
    for _ in range(_ROUNDS):
        if inner_cost < outer_cost:
            high, outer, outer_cost = outer, inner, inner_cost
            inner = high - _GOLDEN * (high - low)
            inner_cost = _cost(axes, inner, pace)
        else:
            low, inner, inner_cost = inner, outer, outer_cost
            outer = low + _GOLDEN * (high - low)
            outer_cost = _cost(axes, outer, pace)
    best, least_cost = least, _cost(axes, least, pace)
    for tau, cost in ((inner, inner_cost), (outer, outer_cost)):
        if cost < least_cost:
            best, least_cost = tau, cost
    return best
