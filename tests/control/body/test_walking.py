from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from humanoid_bt.control.body.footsteps import OTHER
from humanoid_bt.control.body.planar import ahead
from humanoid_bt.control.body.walking import Walker
from humanoid_bt.core.messages import SIDES, Array, Gait, Side
from humanoid_bt.robot.config import GaitConfig, SoleConfig

GAIT = GaitConfig()
SOLE = SoleConfig(half_length=0.105, half_width=0.045)
OMEGA, DT = 3.9, 0.005
AHEAD = np.array([1.0, 0.0, 0.0])
CARRIES = {"left": 200.0, "right": 200.0}
LEVEL = {side: np.zeros(3) for side in SIDES}


class Ideal:
    """A walker whose robot is always where it shall be, but for an error of the DCM, shape (2,)."""

    def __init__(self) -> None:
        self.walker = Walker(GAIT, SOLE, DT)
        self.walker.reset(
            {side: ahead(np.zeros(3), 0, sign * 0.09) for side, sign in zip(SIDES, (1, -1), strict=True)}, LEVEL, OMEGA
        )
        self.gaits: list[Gait] = []

    def go(
        self,
        seconds: float,
        goal: Array | None = None,
        error: Array | None = None,
        force: dict[Side, float] | None = None,
    ) -> None:
        walker = self.walker
        for _ in range(round(seconds / DT)):
            dcm = walker.dcm_reference + (np.zeros(2) if error is None else error)
            carried = {side: 200.0 * walker.contact[side] for side in SIDES}
            soles = {side: walker.foot_reference[side].copy() for side in SIDES}
            walker.update(goal, dcm, walker.zmp_reference, soles, footings=LEVEL, foot_force=force or carried)
            self.gaits.append(walker.gait)

    def until_swing(self) -> None:
        while self.walker.swing is None:
            self.go(DT, AHEAD)


@pytest.fixture
def ideal() -> Ideal:
    return Ideal()


def test_without_a_goal_it_stands(ideal: Ideal) -> None:
    ideal.go(1.0)
    assert set(ideal.gaits) == {Gait.STAND}
    assert ideal.walker.still_for == pytest.approx(1.0)
    assert ideal.walker.footsteps == []
    np.testing.assert_allclose(ideal.walker.dcm_reference, [0, 0], atol=1e-9)


@pytest.mark.parametrize("slip", [(0.0, -0.06, 0.0), (0.06, 0.0, 0.0), (0.0, 0.0, 0.4)])
def test_a_foot_that_slipped_is_put_beside_the_other_one_again(ideal: Ideal, slip: tuple[float, float, float]) -> None:
    walker = ideal.walker
    walker.foot_reference["left"] = walker.foot_reference["left"] + slip
    ideal.go(0.9)
    assert set(ideal.gaits) == {Gait.STAND}
    ideal.go(6.0)
    left, right = (walker.foot_reference[side] for side in SIDES)
    np.testing.assert_allclose(left, ahead(right, 0, 0.18), atol=5e-3)
    assert ideal.gaits[-1] is Gait.STAND
    assert walker.still_for > 2.0  # one step is enough


@pytest.mark.parametrize(("aside", "side"), [(-0.01, "left"), (0.01, "right")])
def test_of_feet_that_slipped_the_one_is_put_right_that_carries_less(ideal: Ideal, aside: float, side: Side) -> None:
    ideal.walker.foot_reference["left"] = ideal.walker.foot_reference["left"] + (0.06, 0.0, 0.0)
    while ideal.walker.swing is None:
        ideal.go(DT, error=np.array([0.0, aside]) if ideal.walker.gait is Gait.STAND else None)
    assert ideal.walker.swing.side == side


@pytest.mark.parametrize("turned", [0.01, -0.01])
def test_a_heading_that_goes_round_is_no_turn(ideal: Ideal, turned: float) -> None:
    """It stands facing backward, and is measured a little beyond half a turn."""
    walker, force = ideal.walker, dict(CARRIES)
    places = {side: np.array([0.0, -0.09 * sign, math.pi - turned]) for side, sign in zip(SIDES, (1, -1), strict=True)}
    walker.reset(places, LEVEL, OMEGA)
    places["left"] = places["left"] + (0.0, 0.0, 2 * turned - 2 * math.pi)
    for _ in range(2):
        for _ in range(300):
            walker.update(None, walker.dcm_reference, walker.zmp_reference, places, footings=LEVEL, foot_force=force)
            assert abs(math.remainder(walker.foot_reference["left"][2] - math.pi, math.tau)) < 0.02
        assert walker.gait is Gait.STAND
        walker.reset(places, LEVEL, OMEGA)


def test_feet_that_slipped_a_little_are_let_be(ideal: Ideal) -> None:
    ideal.walker.foot_reference["left"] = ideal.walker.foot_reference["left"] + (0.02, -0.02, 0.1)
    ideal.go(3.0)
    assert set(ideal.gaits) == {Gait.STAND}


def test_a_robot_that_stays_where_it_is_lets_slipped_feet_be(ideal: Ideal) -> None:
    walker = ideal.walker
    walker.foot_reference["left"] = walker.foot_reference["left"] + (0.0, -0.06, 0.0)
    for _ in range(600):
        soles = {side: walker.foot_reference[side].copy() for side in SIDES}
        dcm, zmp, force = walker.dcm_reference, walker.zmp_reference, dict.fromkeys(SIDES, 200.0)
        walker.update(None, dcm, zmp, soles, footings=LEVEL, foot_force=force, stays=True)
        assert walker.gait is Gait.STAND


def test_it_shifts_its_weight_before_it_lifts_a_foot(ideal: Ideal) -> None:
    ideal.go(GAIT.first_shift, AHEAD)
    assert ideal.walker.gait is Gait.STEP
    assert all(ideal.walker.contact.values())
    assert ideal.walker.zmp_reference[1] > 0.08  # over the left foot; the right steps first
    assert ideal.walker.still_for == 0.0
    ideal.go(2 * DT, AHEAD)
    assert ideal.walker.contact == {"left": True, "right": False}
    heights = [0.0]
    while ideal.walker.swing is not None:
        heights.append(ideal.walker.foot_footing["right"].item(0))
        ideal.go(DT, AHEAD)
    assert max(heights) > 0.95 * GAIT.lift
    assert ideal.walker.foot_footing["left"][0] == 0


def test_it_walks_to_the_goal_settles_and_stands(ideal: Ideal) -> None:
    ideal.go(8.0, AHEAD)
    changes = [gait for i, gait in enumerate(ideal.gaits) if i == 0 or ideal.gaits[i - 1] is not gait]
    assert changes == [Gait.STEP, Gait.SETTLE, Gait.STAND]
    assert np.hypot(*(ideal.walker.stance - AHEAD)[:2]) < GAIT.arrived_distance
    assert ideal.walker.footsteps == []
    assert max(footing[0] for footing in ideal.walker.foot_footing.values()) == pytest.approx(0, abs=1e-6)


def test_a_goal_that_is_taken_away_ends_the_walk_with_the_feet_together(ideal: Ideal) -> None:
    ideal.go(1.0, AHEAD)
    assert ideal.walker.gait is Gait.STEP
    ideal.go(2 * (GAIT.single_support + GAIT.double_support) + GAIT.last_shift + 0.6)
    assert ideal.walker.gait is Gait.STAND
    apart = ideal.walker.foot_reference["left"] - ideal.walker.foot_reference["right"]
    np.testing.assert_allclose(apart, [0, GAIT.stance_width, 0], atol=5e-3)
    assert 0.1 < ideal.walker.stance[0] < 0.6


def test_a_goal_nearby_does_not_make_it_start(ideal: Ideal) -> None:
    ideal.go(0.5, np.array([0.035, 0, 0.05]))
    assert set(ideal.gaits) == {Gait.STAND}


@pytest.mark.parametrize(("share", "lands"), [(0.5, False), (0.85, True)])
def test_contact_ends_the_swing_only_when_it_is_due(ideal: Ideal, share: float, lands: bool) -> None:
    ideal.until_swing()
    ideal.go(share * GAIT.single_support, AHEAD)
    before = ideal.walker.foot_footing["right"][0]
    ideal.go(3 * DT, AHEAD, force={"left": 300.0, "right": 100.0})
    assert ideal.walker.contact["right"] is lands
    assert ideal.walker.foot_footing["right"][0] < before + 0.01


def test_a_foot_that_bounces_as_it_lands_is_not_lowered(ideal: Ideal) -> None:
    ideal.until_swing()
    ideal.go(0.85 * GAIT.single_support, AHEAD)
    ideal.go(DT, AHEAD, force={"left": 300.0, "right": 100.0})
    assert ideal.walker.contact["right"]
    landed = ideal.walker.foot_footing["right"][0]
    ideal.go(5 * DT, AHEAD, force={"left": 300.0, "right": 0.0})
    assert ideal.walker.foot_footing["right"][0] == landed


def test_references_of_the_feet_never_jump(ideal: Ideal) -> None:
    previous = {side: ideal.walker.foot_reference[side].copy() for side in SIDES}
    for _ in range(round(6.0 / DT)):
        heights = {side: ideal.walker.foot_footing[side][0] for side in SIDES}
        ideal.go(DT, np.array([0.6, 0.4, 1.0]))
        for side in SIDES:
            moved = ideal.walker.foot_reference[side] - previous[side]
            assert np.hypot(*moved[:2]) < 0.015  # minimum jerk: 1.875 times 0.44 m in 0.34 s
            assert abs(moved[2]) < 0.02
            assert abs(ideal.walker.foot_footing[side][0] - heights[side]) < 0.004
            previous[side] = ideal.walker.foot_reference[side].copy()


def test_a_standing_foot_takes_the_height_and_slowly_the_tilt_of_the_ground(ideal: Ideal) -> None:
    walker = ideal.walker
    soles = {side: pose.copy() for side, pose in walker.foot_reference.items()}
    slope = {side: np.array([0.02, 0.0, -0.07]) for side in SIDES}
    heights, tilts = [], []
    for _ in range(200):
        walker.update(None, walker.dcm_reference, np.zeros(2), soles, footings=slope, foot_force=CARRIES)
        heights.append(walker.foot_footing["left"][0])
        tilts.append(walker.foot_footing["left"][2])
    assert max(np.abs(np.diff(heights))) < 0.002
    assert heights[40] > 0.9 * 0.02
    assert -0.06 < tilts[40] < -0.02
    np.testing.assert_allclose(walker.foot_footing["left"], slope["left"], atol=3e-3)
    assert walker.ground == pytest.approx(0.02, abs=1e-3)
    tips = {side: np.array([0.02, 0.5, -0.5]) for side in SIDES}  # no ground is so steep
    for _ in range(200):
        walker.update(None, walker.dcm_reference, np.zeros(2), soles, footings=tips, foot_force=CARRIES)
    np.testing.assert_allclose(walker.foot_footing["left"][1:], [0.2, -0.2])


def test_a_foot_that_finds_no_ground_where_it_lands_is_lowered(ideal: Ideal) -> None:
    ideal.until_swing()
    while ideal.walker.swing is not None:
        ideal.go(DT, AHEAD)
    before = ideal.walker.foot_footing["right"][0]
    ideal.go(4 * DT, AHEAD, force={"left": 400.0, "right": 0.0})
    assert ideal.walker.foot_footing["right"][0] < before - 0.006


def test_a_standing_foot_that_slips_is_followed_slowly(ideal: Ideal) -> None:
    walker = ideal.walker
    slipped = {side: pose + np.array([0.02, 0, 0.1]) for side, pose in walker.foot_reference.items()}
    walker.update(None, np.zeros(2), np.zeros(2), slipped, footings=LEVEL, foot_force=CARRIES)
    assert 0 < walker.foot_reference["left"][0] < 0.002
    for _ in range(100):
        walker.update(None, np.array([0.02, 0]), np.zeros(2), slipped, footings=LEVEL, foot_force=CARRIES)
    np.testing.assert_allclose(walker.foot_reference["left"], slipped["left"], atol=1e-3)


@pytest.mark.parametrize(
    ("error", "steps", "side"),
    [
        ([0.05, 0], False, ""),
        ([0.11, 0], True, ""),
        ([0, 0.10], False, ""),
        ([0, 0.14], True, "right"),
        ([0, -0.14], True, "left"),
    ],
)
def test_a_push_beyond_the_feet_makes_a_standing_robot_step(
    ideal: Ideal, error: list[float], steps: bool, side: str
) -> None:
    ideal.go(0.5)
    leans = 200.0 + 1000.0 * error[1]  # on the left foot: it carries more when it is pushed to the left
    ideal.go(DT, error=np.array(error), force={"left": leans, "right": 400.0 - leans})
    assert (ideal.walker.gait is Gait.STEP) is steps
    if side:
        assert ideal.walker.footsteps[0].side == side


def push(ideal: Ideal, error: list[float], until: float = 1.0, goal: Array = AHEAD) -> None:
    """Let the DCM be off [m] until that share of a swing is over, and wait for the foot to land."""
    ideal.go(DT, goal)
    ideal.until_swing()
    while (swing := ideal.walker.swing) is not None:
        ideal.go(DT, goal, error=np.array(error) if swing.progress < until else np.zeros(2))


def test_after_a_step_that_caught_a_push_the_feet_come_together_before_it_walks_on(ideal: Ideal) -> None:
    push(ideal, [0.0, -0.08])
    walker = ideal.walker
    caught = walker.foot_reference["right"].copy()
    assert caught[1] < -0.16
    assert [step.side for step in walker.footsteps[:2]] == ["left", "right"]
    np.testing.assert_allclose([step.pose[0] for step in walker.footsteps], caught[0], atol=1e-9)
    np.testing.assert_allclose(walker.footsteps[0].pose[1], caught[1] + GAIT.stance_width, atol=1e-9)
    ideal.go(8.0, AHEAD)
    assert walker.gait is Gait.STAND
    assert np.hypot(*(walker.stance - AHEAD)[:2]) < GAIT.arrived_distance


def test_a_foot_that_is_still_needed_waits(ideal: Ideal) -> None:
    """The right foot swings first; the DCM is 4 cm nearer to it than it is to be, but between the feet."""
    ideal.go(GAIT.first_shift + 10 * DT, AHEAD, error=np.array([0.0, -0.04]))
    assert all(ideal.walker.contact.values())
    np.testing.assert_array_equal(ideal.walker.zmp_reference, ideal.walker.dcm_reference)
    ideal.go(3 * DT, AHEAD)
    assert not ideal.walker.contact["right"]


def test_a_foot_does_not_wait_for_ever_nor_when_the_dcm_has_left_the_feet(ideal: Ideal) -> None:
    ideal.go(GAIT.first_shift + 0.35, AHEAD, error=np.array([0.0, -0.04]))
    assert not ideal.walker.contact["right"]
    pushed = Ideal()
    pushed.go(GAIT.first_shift + 4 * DT, AHEAD, error=np.array([0.2, -0.04]))
    assert not pushed.walker.contact["right"]


def test_the_next_foot_waits_as_long_though_the_one_before_did(ideal: Ideal) -> None:
    turn = np.array([0.0, 0.0, -1.0])
    ideal.go(GAIT.first_shift + 0.35, turn, error=np.array([0.0, -0.04]))
    while ideal.walker.swing is not None:
        ideal.go(DT, turn)
    ideal.go(GAIT.double_support + 10 * DT, turn, error=np.array([0.0, 0.04]))
    assert all(ideal.walker.contact.values())


def test_a_foot_that_lands_early_does_not_hurry_the_next_step() -> None:
    lifted = []
    for force in (None, {"left": 300.0, "right": 100.0}):
        ideal = Ideal()
        ideal.until_swing()
        ideal.go(0.85 * GAIT.single_support, AHEAD)
        ideal.go(DT, AHEAD, force=force)
        while ideal.walker.swing is not None:
            ideal.go(DT, AHEAD)
        ideal.until_swing()
        lifted.append(len(ideal.gaits))
    assert lifted[1] == pytest.approx(lifted[0], abs=1)


def test_steps_are_shorter_after_one_in_which_the_standing_foot_turned(ideal: Ideal) -> None:
    walker = ideal.walker
    ideal.until_swing()
    assert walker.swing is not None
    stands, before = OTHER[walker.swing.side], walker.swing.target.copy()
    soles = {side: walker.foot_reference[side].copy() for side in SIDES}
    soles[stands][2] += 0.15
    force = {side: 200.0 * (side == stands) for side in SIDES}
    while walker.swing is not None:
        soles[OTHER[stands]] = walker.foot_reference[OTHER[stands]].copy()
        walker.update(AHEAD, walker.dcm_reference, walker.zmp_reference, soles, footings=LEVEL, foot_force=force)
    longest = max(math.dist(one.pose[:2], other.pose[:2]) for one, other in pairwise(walker.footsteps))
    assert before[0] == pytest.approx(GAIT.step_forward)
    assert longest < math.hypot(0.7 * GAIT.step_forward, GAIT.stance_width)
    again = {side: ahead(np.zeros(3), 0, sign * 0.09) for side, sign in zip(SIDES, (1, -1), strict=True)}
    walker.reset(again, LEVEL, OMEGA)
    ideal.until_swing()
    assert walker.swing.target[0] == pytest.approx(GAIT.step_forward)


def test_reset_stands_where_the_feet_are(ideal: Ideal) -> None:
    ideal.go(2.0, AHEAD)
    soles: dict[Side, Array] = {"left": np.array([1.0, 0.1, 0.0]), "right": np.array([1.0, -0.1, 0.0])}
    ideal.walker.reset(soles, LEVEL, OMEGA)
    assert ideal.walker.gait is Gait.STAND
    assert ideal.walker.footsteps == []
    assert all(ideal.walker.contact.values())
    np.testing.assert_allclose(ideal.walker.stance, [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(ideal.walker.dcm_reference, [1, 0], atol=1e-12)


def test_a_step_that_something_else_began_is_finished_where_the_robot_goes(ideal: Ideal) -> None:
    walker = ideal.walker
    lifted = np.array([-0.05, -0.09, 0.0])
    soles = {"left": np.array([0.0, 0.09, 0.0]), "right": lifted}
    walker.reset(soles, {"left": np.zeros(3), "right": np.array([0.06, 0.0, 0.0])}, OMEGA)
    walker.go_on("right", np.array([0.15, 0.0]))
    ideal.go(DT)
    assert walker.contact == {"left": True, "right": False}
    assert walker.swing is not None
    np.testing.assert_allclose(walker.foot_reference["right"], lifted, atol=0.01)
    assert walker.foot_footing["right"][0] == pytest.approx(0.06, abs=0.01)
    ideal.go(0.36)
    assert walker.foot_reference["right"][0] > 0.1
    assert walker.foot_footing["right"][0] == pytest.approx(0.0, abs=0.01)
    ideal.go(4.0)
    assert walker.gait is Gait.STAND


def test_a_walker_strides_while_it_walks_ahead_and_not_once_it_stands(ideal: Ideal) -> None:
    ideal.until_swing()
    ideal.go(1.0, AHEAD)
    assert ideal.walker.stride > 0.5
    ideal.go(6.0, AHEAD)
    assert ideal.walker.gait is Gait.STAND
    assert ideal.walker.stride == 0.0
    ideal.go(1.0, 3 * AHEAD)
    assert ideal.walker.stride > 0.5
    ideal.walker.reset(ideal.walker.foot_reference, LEVEL, OMEGA)
    assert ideal.walker.stride == 0.0


def test_a_foot_that_meets_the_ground_by_its_heel_has_landed_when_it_lies_nearly_flat_and_does_not_jump() -> None:
    walker = Walker(replace(GAIT, toe_off=0.4, heel_strike=0.2), SOLE, DT)
    soles = {side: ahead(np.zeros(3), 0, sign * 0.09) for side, sign in zip(SIDES, (1, -1), strict=True)}
    walker.reset(soles, LEVEL, OMEGA)
    landed: Side | None = None
    pitches: list[float] = []
    heel_down = 0  # control periods
    while len(pitches) < 60:
        early = walker.swing is not None and walker.swing.progress > 0.85 and walker.swing.rolled[2] < -0.05
        if early and landed is None:
            landed = walker.swing.side if walker.swing else None
        soles = {side: walker.foot_reference[side].copy() for side in SIDES}
        force = {side: 200.0 * (walker.contact[side] or side == landed) for side in SIDES}
        footings = {side: walker.foot_footing[side].copy() for side in SIDES}
        walker.update(AHEAD, walker.dcm_reference, walker.zmp_reference, soles, footings=footings, foot_force=force)
        if landed and walker.contact[landed]:
            pitches.append(float(walker.foot_footing[landed][2]))
        elif landed:
            heel_down += 1
    assert heel_down > 1  # it swings on: the weight is not there yet
    assert -0.05 < pitches[0] < -0.03
    assert np.abs(np.diff(pitches)).max() < 0.03
    assert abs(pitches[-1]) < 0.005


@pytest.mark.parametrize("stops", [False, True])
def test_a_robot_that_is_stopped_in_mid_step_lands_flat(stops: bool) -> None:
    walker = Walker(replace(GAIT, toe_off=0.4, heel_strike=0.2), SOLE, DT)
    soles = {side: ahead(np.zeros(3), 0, sign * 0.09) for side, sign in zip(SIDES, (1, -1), strict=True)}
    walker.reset(soles, LEVEL, OMEGA)
    pitches: list[float] = []  # from when it would land by its heel
    while walker.swing is not None or not pitches:
        soles = {side: walker.foot_reference[side].copy() for side in SIDES}
        footings = {side: walker.foot_footing[side].copy() for side in SIDES}
        force = {side: 200.0 * walker.contact[side] for side in SIDES}
        dcm, zmp, stays = walker.dcm_reference, walker.zmp_reference, stops and bool(pitches)
        walker.update(AHEAD, dcm, zmp, soles, footings=footings, foot_force=force, stays=stays)
        if walker.swing is not None and (pitches or walker.swing.rolled[2] < -0.1):
            pitches.append(float(walker.swing.rolled[2]))
    least = min(pitches)
    assert least > -0.13 if stops else least < -0.18
