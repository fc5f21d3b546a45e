"""The skill ``step_back``, alone on the simulated robot."""

import pytest

from humanoid_bt import Gait, Rig


@pytest.mark.parametrize(
    "distance", [0.1, *(pytest.param(distance, marks=pytest.mark.trials) for distance in (0.25, 0.6))]
)
def test_walks_straight_back_without_turning(rig: Rig, distance: float) -> None:
    result = rig.run("step_back", distance=distance)
    assert result.succeeded, result.feedback
    assert rig.state.stance[0] == pytest.approx(-distance, abs=0.06)
    assert all(abs(state.stance[1]) < 0.04 and abs(state.stance[2]) < 0.1 for state in result.states)
    assert not result.stops


@pytest.mark.trials
def test_back_is_where_it_does_not_face(rig: Rig) -> None:
    assert rig.run("turn", angle=1.57).succeeded
    result = rig.run("step_back", distance=0.3)
    assert result.succeeded, result.feedback
    assert rig.state.stance == pytest.approx([0.0, -0.3, 1.57], abs=0.1)


def test_gives_up_when_it_comes_no_farther(rig: Rig) -> None:
    rig.raise_estop()
    result = rig.run("step_back", patience=1.0)
    assert result.failed
    assert "comes no farther: 0.00 of 0.25 m made" in result.feedback


def test_steps_back_to_where_it_faces_as_closely_as_it_is_told(rig: Rig) -> None:
    result = rig.run("step_back", distance=0.3, tolerance=0.1, angle_tolerance=1e-6, patience=1.0)
    assert result.failed
    assert result.feedback.startswith("comes no farther")


@pytest.mark.trials
def test_stops_within_a_step_when_halted(rig: Rig) -> None:
    result = rig.run("step_back", distance=2.0, timeout=2.5)
    assert result.states[-1].gait is Gait.STEP
    where = rig.state.stance[0]
    settled = rig.settle(2.5)
    assert settled.base_settled
    assert where - settled.stance[0] < 0.25


def test_takes_no_step_for_less_than_its_tolerance(rig: Rig) -> None:
    result = rig.run("step_back", distance=0.05)
    assert result.succeeded, result.feedback
    assert result.time <= 0.3
    assert {state.gait for state in result.states} == {Gait.STAND}
    assert result.feedback == "0.00 m back"


def test_says_that_a_robot_that_stands_makes_no_step_for_so_little(rig: Rig) -> None:
    rig.settle(0.5)
    result = rig.run("step_back", distance=0.035, tolerance=0.01, patience=0.5)
    assert result.failed
    assert result.feedback == "comes no farther: 0.00 of 0.04 m made, 0.04 m to go, for which it makes no step"
