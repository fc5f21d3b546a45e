from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from humanoid_bt.control.body.body import Footstep
from humanoid_bt.control.body.footsteps import OTHER, SIGN, FootstepPlanner
from humanoid_bt.control.body.planar import ahead, seen_from, wrap
from humanoid_bt.core.messages import Array, Side
from humanoid_bt.robot.config import GaitConfig, SoleConfig

GAIT = GaitConfig()
SOLE = SoleConfig(half_length=0.105, half_width=0.045)
ORIGIN = np.zeros(3)
NO_CONTACT = 0.10  # m between the feet's centres; the built-in soles are 0.09 m wide
GOALS = [
    np.array([distance * math.cos(bearing), distance * math.sin(bearing), heading])
    for distance, bearing, heading in np.random.default_rng(0).uniform([0, -3, -3], [3, 3, 3], (25, 3))
]


@pytest.fixture
def planner() -> FootstepPlanner:
    return FootstepPlanner(GAIT, SOLE)


def walk(planner: FootstepPlanner, goal: Array) -> list[Footstep]:
    """Make one planned step after the other from the origin until the plan ends the walk."""
    swing = planner.first_swing(ORIGIN, goal)
    made = [Footstep(OTHER[swing], planner.foothold(OTHER[swing], ORIGIN))]
    while len(made) < 150:
        steps, done = planner.plan(swing, made[-1].pose, goal)
        made.append(steps[0])
        if done and len(steps) == 1:
            return made
        swing = OTHER[swing]
    pytest.fail(f"the walk to {goal} does not end")


@pytest.mark.parametrize("goal", GOALS, ids=lambda goal: f"{goal[0]:.1f},{goal[1]:.1f},{goal[2]:.1f}")
def test_a_walk_reaches_its_goal_in_steps_that_the_robot_can_make(planner: FootstepPlanner, goal: Array) -> None:
    made = walk(planner, goal)
    assert planner.arrived(planner.stance_beside(made[-1].side, made[-1].pose), goal)
    for before, step in pairwise(made):
        assert step.side == OTHER[before.side]
        start = planner.stance_beside(before.side, before.pose)
        end = planner.stance_beside(step.side, step.pose)
        forward, sideways = seen_from(start, end)
        assert -GAIT.step_back - 1e-9 <= forward <= GAIT.step_forward + 1e-9
        assert abs(sideways) <= GAIT.step_sideways + 1e-9
        assert abs(wrap(end[2] - start[2])) <= GAIT.step_turn + 1e-9
        assert SIGN[step.side] * seen_from(before.pose, step.pose)[1] > NO_CONTACT


def test_it_turns_the_longer_way_round_where_that_saves_steps(planner: FootstepPlanner) -> None:
    made = walk(planner, np.array([0.7, -0.7, 3.1]))
    turns = [wrap(after.pose.item(2) - before.pose.item(2)) for before, after in pairwise(made)]
    assert sum(turns) == pytest.approx(3.1 - 2 * math.pi, abs=0.03)


def test_steps_are_no_longer_than_their_number_asks_for(planner: FootstepPlanner) -> None:
    made = walk(planner, np.array([1.5 * GAIT.step_forward, 0.0, 0.0]))
    stances = [planner.stance_beside(step.side, step.pose) for step in made]
    assert max(np.diff([stance.item(0) for stance in stances])) < 0.86 * GAIT.step_forward


def test_the_right_foot_starts_where_either_could(planner: FootstepPlanner) -> None:
    assert planner.first_swing(ORIGIN, np.array([1.0, 0.0, 0.0])) == "right"


def test_it_plans_a_few_steps_ahead_and_says_that_more_will_follow(planner: FootstepPlanner) -> None:
    steps, done = planner.plan("left", planner.foothold("right", ORIGIN), np.array([3.0, 0, 0]))
    assert [step.side for step in steps] == ["left", "right", "left", "right"]
    assert not done


def test_the_step_after_arriving_brings_the_feet_together_and_ends_the_walk(planner: FootstepPlanner) -> None:
    steps, done = planner.plan("left", planner.foothold("right", ORIGIN), np.array([0.2, 0, 0]))
    assert done
    beside = planner.stance_beside("right", steps[-2].pose if steps[-2].side == "right" else steps[-1].pose)
    np.testing.assert_allclose(beside, [0.2, 0, 0], atol=1e-9)


def test_without_a_goal_it_brings_the_feet_together(planner: FootstepPlanner) -> None:
    support = np.array([1.0, 2.0, 0.3])
    steps, done = planner.plan("right", support, None)
    assert done
    assert [step.side for step in steps] == ["right"]
    np.testing.assert_allclose(steps[0].pose, ahead(support, 0, -GAIT.stance_width), atol=1e-12)


@pytest.mark.parametrize(
    ("goal", "arrived", "must_walk"),
    [
        ([0.020, 0, 0], True, False),
        ([0.030, 0, 0], False, False),  # between the thresholds: a robot that stands stays, one that walks goes on
        ([0.050, 0, 0], False, True),
        ([0, 0, 0.03], True, False),
        ([0, 0, -0.05], False, False),
        ([0, 0, 0.07], False, True),
    ],
)
def test_arriving_and_leaving_have_a_hysteresis(
    planner: FootstepPlanner, goal: list[float], arrived: bool, must_walk: bool
) -> None:
    assert planner.arrived(ORIGIN, np.array(goal)) is arrived
    assert planner.must_walk(ORIGIN, np.array(goal)) is must_walk


def first_step(planner: FootstepPlanner, goal: Array, swing: Side = "left") -> Array:
    """Return the stance after the first step from the origin: forward, sideways [m], turn [rad]."""
    steps, _ = planner.plan(swing, planner.foothold(OTHER[swing], ORIGIN), goal)
    return planner.stance_beside(swing, steps[0].pose)


def test_it_turns_to_a_goal_far_away_while_it_walks(planner: FootstepPlanner) -> None:
    forward, sideways, turn = first_step(planner, np.array([2.0, 2.0, math.pi / 4]))
    assert turn == pytest.approx(GAIT.step_turn)
    assert forward > 0.3 * GAIT.step_forward
    assert sideways > 0


def test_a_foot_turns_farther_outward_than_inward(planner: FootstepPlanner) -> None:
    goal = np.array([0.0, 0.0, 3.0])
    outward, inward = (first_step(planner, goal, side)[2] for side in ("left", "right"))
    assert outward == pytest.approx(GAIT.step_turn)
    assert 0 < inward < outward


def test_a_goal_behind_is_walked_to_backward_if_it_is_near(planner: FootstepPlanner) -> None:
    near, far = np.array([-0.5, 0.0, 0.0]), np.array([-6.0, 0.1, 0.0])
    np.testing.assert_allclose(first_step(planner, near), [-GAIT.step_back, 0, 0], atol=1e-12)
    assert abs(first_step(planner, far)[2]) > 0.4 * GAIT.step_turn


def test_a_goal_beside_makes_it_sidestep_without_turning(planner: FootstepPlanner) -> None:
    _, sideways, turn = first_step(planner, np.array([-0.05, 0.15, 0]))
    assert turn == 0
    assert 0.6 * GAIT.step_sideways < sideways <= GAIT.step_sideways


def test_it_turns_to_its_end_as_it_comes_there_and_not_after(planner: FootstepPlanner) -> None:
    goal = np.array([1.0, 0.0, 1.2])
    turns = len(walk(planner, goal)) - len(walk(planner, np.array([1.0, 0.0, 0.0])))
    in_place = len(walk(planner, np.array([0.0, 0.0, 1.2]))) - 2  # without the first foot, and that which follows
    assert turns <= in_place - 1


@pytest.mark.parametrize("turn", [0.003, 0.05])
def test_a_robot_that_hardly_turns_walks_all_the_same(turn: float) -> None:
    planner = FootstepPlanner(replace(GAIT, step_turn=turn), SOLE)
    steps, done = planner.plan("left", planner.foothold("right", ORIGIN), np.array([0.5, 0.2, 3.0]))
    assert len(steps) == 4
    assert not done


@pytest.mark.parametrize("swing", ["left", "right"])
def test_no_walk_has_fewer_steps_the_farther_it_leads(planner: FootstepPlanner, swing: Side) -> None:
    support = planner.foothold(OTHER[swing], ORIGIN)
    counts = []
    for way in np.arange(0.05, 0.8, 0.05):
        steps, done = planner.plan(swing, support, np.array([way, 0.0, 0.0]))
        counts.append(len(steps) if done else 4)
    assert counts == sorted(counts)


@pytest.mark.parametrize(
    ("goal", "side"), [([2, 1, 0], "left"), ([2, -1, 0], "right"), ([0, 0, 1], "left"), ([0, 0, -1], "right")]
)
def test_the_foot_inside_the_turn_steps_first(planner: FootstepPlanner, goal: list[float], side: str) -> None:
    assert planner.first_swing(ORIGIN, np.array(goal, dtype=float)) == side


def test_steps_are_shorter_where_feet_slip_and_grow_again_where_they_do_not(planner: FootstepPlanner) -> None:
    turn, far = np.array([0.0, 0.0, 3.0]), np.array([3.0, 0.0, 0.0])
    planner.stood(0.3)
    assert first_step(planner, turn)[2] == pytest.approx(0.6 * GAIT.step_turn)
    assert first_step(planner, far)[0] == pytest.approx(0.6 * GAIT.step_forward)
    for _ in range(5):
        planner.stood(-0.3)
    shortest = planner.stride
    assert 0.3 < shortest < 0.6
    planner.stood(0.01)
    assert shortest < planner.stride < 0.6
    for _ in range(20):
        planner.stood(0.01)
    assert first_step(planner, turn)[2] == pytest.approx(GAIT.step_turn)
    planner.stood(0.3)
    planner.reset()
    assert planner.stride == 1.0
    assert first_step(planner, turn)[2] == pytest.approx(GAIT.step_turn)
