from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.control.body.catching import Catching
from humanoid_bt.control.body.planar import ahead, rotate
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.config import GaitConfig, SoleConfig

GAIT = GaitConfig()
SOLE = SoleConfig(half_length=0.105, half_width=0.045)
OMEGA = 3.8
BOTH = {"left": 200.0, "right": 200.0}
ON_LEFT = {"left": 390.0, "right": 10.0}


def feet(apart: float = 0.0, at: Array | None = None) -> dict[Side, Array]:
    """Return feet that stand beside each other, the left one so far ahead [m], around a pose."""
    around = np.zeros(3) if at is None else at
    return {"left": ahead(around, apart, 0.09), "right": ahead(around, 0.0, -0.09)}


@pytest.fixture
def catching() -> Catching:
    return Catching(GAIT, SOLE)


@pytest.mark.parametrize("dcm", [[0.0, 0.0], [0.09, 0.05], [-0.09, -0.05], [0.0, 0.12], [0.0, -0.12]])
def test_a_dcm_over_the_feet_needs_no_step(catching: Catching, dcm: list[float]) -> None:
    assert catching.step(np.array(dcm), feet(), BOTH, OMEGA) is None


@pytest.mark.parametrize("dcm", [[0.10, 0.0], [-0.10, 0.0], [0.0, 0.13], [0.0, -0.13]])
def test_a_dcm_beyond_the_feet_needs_one_wherever_they_stand(catching: Catching, dcm: list[float]) -> None:
    at = np.array([2.0, -1.0, 2.5])
    beyond = at[:2] + rotate(np.array(dcm), at[2])
    assert catching.step(np.array(dcm), feet(), BOTH, OMEGA) is not None
    assert catching.step(beyond, feet(at=at), BOTH, OMEGA) == catching.step(np.array(dcm), feet(), BOTH, OMEGA)


def test_feet_that_stand_one_ahead_of_the_other_hold_more(catching: Catching) -> None:
    dcm = np.array([0.16, 0.04])  # over the left foot
    assert catching.step(dcm, feet(), BOTH, OMEGA) is not None
    assert catching.step(dcm, feet(apart=0.2), BOTH, OMEGA) is None


@pytest.mark.parametrize(("loaded", "steps"), [("left", "right"), ("right", "left")])
def test_the_foot_that_carries_nothing_catches_a_push_ahead_at_once(
    catching: Catching, loaded: Side, steps: Side
) -> None:
    force = {side: 400.0 * (side == loaded) for side in SIDES}
    assert catching.step(np.array([0.11, 0.0]), feet(), force, OMEGA) == (steps, 0.0)


def test_the_weight_gets_time_to_leave_a_foot_that_carries(catching: Catching) -> None:
    step = catching.step(np.array([0.11, 0.0]), feet(), BOTH, OMEGA)
    assert step is not None
    assert step[1] == pytest.approx(GAIT.quick_shift / 2)


def test_a_push_to_the_side_is_caught_by_the_other_foot_first(catching: Catching) -> None:
    """The foot on that side carries everything: it can step out only when the other one stands beside it."""
    assert catching.step(np.array([0.0, 0.14]), feet(), ON_LEFT, OMEGA) == ("right", pytest.approx(0.0025))
    assert catching.step(np.array([0.0, -0.14]), feet(), {"left": 10.0, "right": 390.0}, OMEGA) == (
        "left",
        pytest.approx(0.0025),
    )


@pytest.mark.parametrize("way", [1.0, -1.0], ids=["ahead", "back"])
def test_a_foot_is_not_chosen_that_cannot_get_there(catching: Catching, way: float) -> None:
    """The DCM is so far from the left foot that the right one, which carries less, does not reach it from there."""
    far = {"left": np.array([-0.3 * way, 0.09, 0.0]), "right": np.array([0.0, -0.09, 0.0])}
    step = catching.step(np.array([0.14 * way, -0.09]), far, {"left": 250.0, "right": 150.0}, OMEGA)
    assert step is not None
    assert step[0] == "left"


@pytest.mark.parametrize(
    ("aside", "load", "steps"), [(0.14, 150.0, "right"), (0.20, 140.0, "left")], ids=["it misses", "it is as good"]
)
def test_the_foot_that_carries_less_steps_where_it_lands_as_well(
    catching: Catching, aside: float, load: float, steps: Side
) -> None:
    step = catching.step(np.array([0.0, aside]), feet(), {"left": load, "right": 400.0 - load}, OMEGA)
    assert step is not None
    assert step[0] == steps


@pytest.mark.parametrize("other", [300.0, 0.0])
def test_the_weight_gets_no_time_to_leave_a_foot_that_seems_to_pull_or_to_carry_nothing(
    catching: Catching, other: float
) -> None:
    assert catching.step(np.array([0.11, 0.0]), feet(), {"left": -20.0, "right": other}, OMEGA) == ("left", 0.0)
