"""References of how a palm is turned, and of the joints of an arm: limited speed, and no jumps."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from humanoid_bt.control.body.palm_reference import PalmReference, TurnReference
from humanoid_bt.control.body.references import ArmReference, HandReference
from humanoid_bt.core.geometry import quaternion, rotation_matrix, turn_between, turned
from humanoid_bt.core.messages import ArmTarget, Array, HandTarget, Pointing
from humanoid_bt.robot.config import WholeBodyConfig

WEIGHTS = WholeBodyConfig()
DT = 0.005
STEP = WEIGHTS.hand_turn_speed * DT
UPRIGHT = np.array([1.0, 0, 0, 0])
AWAY = turned(UPRIGHT, np.array([0.4, -1.8, 0.9]))
PALM = np.array([0.3, 0.2, 0.8])


def angle(one: Array, other: Array) -> float:
    return float(np.linalg.norm(turn_between(one, other)))


def follow(turn: TurnReference, target: Array | Pointing, periods: int, planned: Array) -> list[Array | Pointing]:
    """Follow a target with a palm that is where it shall be."""
    found = []
    for _ in range(periods):
        now = turn.update(target, planned, planned, heading=0.0, step=STEP)
        found.append(now)
        if isinstance(now, Pointing):
            across = np.array([0, 0, 1.0]) if abs(now.direction[2]) < 0.9 else np.array([0, 1.0, 0])
            facing = across - (across @ now.direction) * now.direction
            facing /= np.linalg.norm(facing)
            planned = np.column_stack([now.direction, np.cross(facing, now.direction), facing])
        else:
            planned = rotation_matrix(now)
    return found


def test_an_orientation_is_reached_the_shortest_way_at_limited_speed() -> None:
    found = follow(TurnReference(0.3, 0.01), AWAY, 800, np.eye(3))
    whole = angle(UPRIGHT, AWAY)
    speeds = [angle(one, other) / DT for one, other in pairwise([UPRIGHT, *found])]  # type: ignore[arg-type]  # there is a turn
    assert max(speeds) <= WEIGHTS.hand_turn_speed * 1.001
    assert sum(speeds) * DT == pytest.approx(whole, abs=0.02)  # no detour; what lags is corrected a little too much
    assert angle(found[-1], AWAY) < 1e-3  # type: ignore[arg-type]  # there is a turn


def test_a_direction_is_reached_the_shortest_way_at_limited_speed_also_right_behind() -> None:
    found = follow(TurnReference(0.3, 0.01), Pointing(np.array([-1.0, 0, 0])), 1000, np.eye(3))
    directions = [np.array([1.0, 0, 0]), *(now.direction for now in found if isinstance(now, Pointing))]
    turns = [math.acos(min(1.0, one @ other)) for one, other in pairwise(directions)]
    assert max(turns) <= STEP * 1.001
    assert sum(turns) == pytest.approx(math.pi, abs=0.02)
    np.testing.assert_allclose(directions[-1], [-1, 0, 0], atol=1e-3)


def test_it_is_never_far_ahead_of_a_palm_that_stays_behind() -> None:
    turn = TurnReference(0.3, 0.01)
    for _ in range(1000):
        now = turn.update(AWAY, np.eye(3), np.eye(3), heading=0.0, step=STEP)
    assert 0.3 <= angle(UPRIGHT, now) < 0.6  # type: ignore[arg-type]  # there is a turn


def test_near_the_target_a_measured_error_is_corrected() -> None:
    turn, sag = TurnReference(0.3, 0.01), np.array([0.02, -0.03, 0.01])
    measured = np.eye(3)
    for _ in range(1500):
        now = turn.update(AWAY, measured, measured, heading=0.0, step=STEP)
        measured = rotation_matrix(turned(now, sag))  # type: ignore[arg-type]  # there is a turn
    assert angle(quaternion(measured), AWAY) < 1e-4


def test_a_change_of_what_is_asked_begins_where_the_palm_is() -> None:
    turn = TurnReference(0.3, 0.01)
    planned = rotation_matrix(follow(turn, AWAY, 400, np.eye(3))[-1])  # type: ignore[arg-type]  # there is a turn
    now = turn.update(Pointing(np.array([0, 0, 1.0]), "facing"), planned, planned, heading=0.0, step=STEP)
    assert isinstance(now, Pointing)
    assert math.acos(now.direction @ planned[:, 2]) <= STEP * 1.001


def test_what_was_corrected_of_one_axis_is_not_of_another() -> None:
    turn, target, measured = TurnReference(0.3, 0.01), UPRIGHT, rotation_matrix(turned(UPRIGHT, np.full(3, 0.05)))
    for _ in range(100):
        turn.update(target, measured, np.eye(3), heading=0.0, step=STEP)
    now = turn.update(Pointing(np.array([1.0, 0, 0])), np.eye(3), np.eye(3), heading=0.0, step=STEP)
    assert isinstance(now, Pointing)
    np.testing.assert_allclose(now.direction, [1.0, 0, 0], atol=1e-9)


def test_of_an_error_that_stays_no_more_is_corrected_than_a_little() -> None:
    turn, measured = TurnReference(0.3, 0.01), rotation_matrix(turned(UPRIGHT, np.array([0.5, 0.0, 0.0])))
    for _ in range(1000):
        now = turn.update(UPRIGHT, measured, np.eye(3), heading=0.0, step=STEP)
    assert angle(UPRIGHT, now) == pytest.approx(0.1)  # type: ignore[arg-type]  # there is a turn


def test_a_held_palm_turns_with_the_stance() -> None:
    turn = TurnReference(0.3, 0.01)
    before = follow(turn, AWAY, 400, np.eye(3))[-1]
    planned = rotation_matrix(before)  # type: ignore[arg-type]  # there is a turn
    after = turn.update(None, planned, planned, heading=0.2, step=STEP)
    np.testing.assert_allclose(turn_between(before, after), [0, 0, 0.2], atol=1e-9)  # type: ignore[arg-type]  # there is a turn


def update(palm: PalmReference, target: HandTarget | None, hold: bool = False) -> tuple[Array, object] | None:
    return palm.update(target, hold, PALM, PALM, stance=np.zeros(3), walks=False, frames=lambda: (np.eye(3), np.eye(3)))


def test_a_place_alone_asks_for_no_frame_and_is_that_of_the_hands_reference() -> None:
    palm, hand = PalmReference(WEIGHTS, DT), HandReference(WEIGHTS, DT)

    def asked() -> tuple[Array, Array]:
        raise AssertionError("a frame costs time")

    target = PALM + 0.1
    for _ in range(50):
        found = palm.update(HandTarget(target), False, PALM, PALM, stance=np.zeros(3), walks=False, frames=asked)
        assert found is not None and found[1] is None
        np.testing.assert_array_equal(found[0], hand.update(target, False, PALM, PALM, stance=np.zeros(3)))


def test_a_released_palm_is_free_to_turn_and_a_held_one_stays_as_it_is() -> None:
    palm = PalmReference(WEIGHTS, DT)
    update(palm, HandTarget(PALM, AWAY))
    held = update(palm, None, hold=True)
    assert held is not None and held[1] is not None
    again = update(palm, HandTarget(PALM))
    assert again is not None and again[1] is None
    assert update(palm, None) is None
    assert update(palm, None, hold=True) is None


def test_a_palm_that_was_free_to_turn_begins_from_where_it_is() -> None:
    palm = PalmReference(WEIGHTS, DT)
    for target in (*[HandTarget(PALM, AWAY)] * 50, HandTarget(PALM), HandTarget(PALM, AWAY)):
        found = update(palm, target)
    assert found is not None and isinstance(found[1], HandTarget)
    assert angle(UPRIGHT, found[1].orientation) <= STEP * 1.001  # type: ignore[arg-type]  # there is a turn


@pytest.mark.parametrize(("asked", "share"), [(None, 1.0), (0.1, 0.25), (5.0, 1.0)])
def test_a_palm_turns_as_much_slower_as_it_is_to_move(asked: float | None, share: float) -> None:
    found = update(PalmReference(WEIGHTS, DT), HandTarget(PALM, AWAY, speed=asked))
    assert found is not None and isinstance(found[1], HandTarget)
    assert angle(UPRIGHT, found[1].orientation) == pytest.approx(share * STEP)  # type: ignore[arg-type]  # there is a turn


@pytest.mark.parametrize("press", [0.0, 10.0])
def test_the_place_of_a_palm_that_presses_is_not_corrected(press: float) -> None:
    """What it presses against keeps it from its reference: that is no error."""
    palm, frames = PalmReference(WEIGHTS, DT), (np.eye(3), np.eye(3))
    for _ in range(50):
        found = palm.update(
            HandTarget(PALM, press=press), False, PALM - 0.01, PALM,
            stance=np.zeros(3), walks=False, frames=lambda: frames,
        )  # fmt: skip
    assert found is not None
    assert np.array_equal(found[0], PALM) == bool(press)


@pytest.mark.parametrize(("asked", "speed"), [(None, 0.4), (0.1, 0.1), (5.0, 0.4)])
def test_a_hand_is_as_fast_as_asked_but_never_faster_than_the_robot(asked: float | None, speed: float) -> None:
    hand, palm = HandReference(WEIGHTS, DT), PALM
    places = [palm]
    for _ in range(40):
        found = hand.update(PALM + np.array([0.5, 0, 0]), False, palm, palm, stance=np.zeros(3), speed=asked)
        assert found is not None
        palm = found
        places.append(found)
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() / DT == pytest.approx(speed)


NAMES = ["waist", "left_shoulder", "left_elbow"]


@pytest.mark.parametrize(("asked", "speed"), [(None, 1.5), (0.3, 0.3), (9.0, 1.5)])
def test_arm_joints_start_where_they_are_and_move_at_limited_speed(asked: float | None, speed: float) -> None:
    arm, planned = ArmReference(NAMES, WEIGHTS, DT), np.array([0.1, 0.2, -0.4])
    for period in range(1, 30):
        arm.update(ArmTarget({"left_elbow": -1.4}, asked), planned)
        assert arm.joints == [2]
        assert arm.angles[0] == pytest.approx(-0.4 - period * speed * DT)
        planned[2] = arm.angles[0]


def test_arm_joints_are_never_far_ahead_of_those_that_stay_behind_and_are_let_go() -> None:
    arm, planned = ArmReference(NAMES, WEIGHTS, DT), np.array([0.1, 0.2, -0.4])
    for _ in range(500):
        arm.update(ArmTarget({"left_elbow": -1.4}), planned)
    assert arm.angles[0] == pytest.approx(-0.4 - WEIGHTS.arm_lead)
    arm.update(None, planned)
    assert arm.joints == []
    arm.update(ArmTarget({"left_shoulder": 0.2, "left_elbow": -0.4}), planned)
    np.testing.assert_allclose(arm.angles, planned[1:])
