"""Numbers of a robot that go with its size: what the model does not say, and what the defaults are for another size."""

from __future__ import annotations

import math

from humanoid_bt.robot.config import ContactConfig, GaitConfig
from humanoid_bt.robot.survey.limbs import Surveyor

_HIGH = (0.1, 5.0)  # m: robots of another height are none in metres
USUAL_MASS = 40.0  # kg: what the defaults are for, ...
_USUAL_HEIGHT = 0.62  # m, ...and how high the centre of mass is then
_SMALL = 0.75  # of that height, up to which a robot's gait is scaled
_QUICKEST, _LOWEST = 0.3, 0.02  # s of a step and m of its lift: no small robot's drives are so much quicker
_HEAVY = 1.5  # times the usual mass, from which what counts as a contact goes with it
_SPIN = 50.0  # cost of spinning, of a robot of 1 kg whose centre of mass is 1 m high
_GRAVITY = 9.81
_LEAST = 5e-4  # m


def odd_size(surveyor: Surveyor) -> str:
    """Return what is wrong with the height of a model, "" if a robot can have it."""
    low, high = surveyor.extent()
    height, (least, most) = float(high[2] - low[2]), _HIGH
    if least <= height <= most:
        return ""
    return (
        f"the robot is about {float(f'{height:.2g}'):g} m high, expected: {least:g} to {most:g} m;"
        " lengths of the model, and of its meshes, must be in metres"
    )


def scaled_gait(height: float, mass: float) -> dict[str, float]:
    """Return numbers of the gait of a small robot, as those of the default one are for its size.

    Lengths go with the size, and times with its root: so does a pendulum (Froude). Drives set an end to it.

    Args:
        height: of the centre of mass above the feet [m].
        mass: [kg].
    """
    size = height / _USUAL_HEIGHT
    if size > _SMALL:
        return {}
    time, weight = math.sqrt(size), size * mass / USUAL_MASS
    lengths = ("step_forward", "step_back", "step_sideways", "adjust_forward", "adjust_sideways", "momentum_limit")
    times = ("single_support", "quickest_step", "double_support", "first_shift", "last_shift", "quick_shift")
    found = {key: time * getattr(GaitConfig, key) for key in times}
    found["single_support"] = max(found["single_support"], _QUICKEST)
    found |= {key: size * getattr(GaitConfig, key) for key in lengths}
    found["lift"] = max(size * GaitConfig.lift, _LOWEST)
    return found | {
        "tilt_stiffness": weight * GaitConfig.tilt_stiffness,
        "tilt_damping": weight * time * GaitConfig.tilt_damping,
    }


def scaled_contact(mass: float) -> dict[str, float]:
    """Return how hard a heavy robot must be pushed for a contact: what its model errs by goes with its weight [N]."""
    share, default = mass / USUAL_MASS, ContactConfig()
    return {key: share * getattr(default, key) for key in ("notice", "limit", "torso")} if share > _HEAVY else {}


def spin(height: float, mass: float) -> float:
    """Return how firmly it keeps from spinning."""
    return _SPIN / (mass * height**2)


def first_shift(apart: float, bears: float, height: float) -> float:
    """Return how long the weight shifts before the first step [s].

    A plan that ends at rest begins with the DCM off the middle by d exp(-omega T), for feet at d from it. A robot
    that stands there lags behind by as much: no more than what a sole can bear on one side.

    Args:
        apart: distance of the soles [m].
        bears: half of the width of what a sole bears on [m].
        height: of the centre of mass above the feet [m].
    """
    return math.log(apart / 2 / max(bears, _LEAST)) / math.sqrt(_GRAVITY / height)
