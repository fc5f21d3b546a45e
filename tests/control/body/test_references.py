from __future__ import annotations

import math

import numpy as np
import pytest

from humanoid_bt.control.body.references import (
    ComHeightReference,
    GazeReference,
    HandReference,
    PostureReference,
    approach,
)
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.config import WholeBodyConfig

WEIGHTS = WholeBodyConfig()
DT = 0.005
PALM = np.array([0.1, 0.2, 0.6])
TARGET = np.array([0.4, 0.1, 0.9])
STANCE = np.zeros(3)


def follow(hand: HandReference, periods: int, off: Array | None = None) -> list[Array]:
    """Follow the target with a planned palm that is where it shall be, and a measured one off it by shape (3,)."""
    positions, palm = [], PALM
    for _ in range(periods):
        position = hand.update(TARGET, False, palm + (np.zeros(3) if off is None else off), palm, stance=STANCE)
        assert position is not None
        positions.append(position)
        palm = position
    return positions


def test_a_hand_starts_where_it_is_and_moves_at_limited_speed() -> None:
    positions = follow(HandReference(WEIGHTS, DT), 300)
    speeds = np.linalg.norm(np.diff([PALM, *positions], axis=0), axis=1) / DT
    assert speeds.max() <= WEIGHTS.hand_speed + 1e-6
    assert speeds[50] == pytest.approx(WEIGHTS.hand_speed)
    np.testing.assert_allclose(positions[-1], TARGET, atol=3e-3)


def test_near_the_target_a_measured_error_is_corrected_up_to_a_bound() -> None:
    hand = HandReference(WEIGHTS, DT)
    sag = np.array([0, 0, -0.02])
    last = follow(hand, 300, sag)[-1]
    np.testing.assert_allclose(last, TARGET, atol=0.08)
    bounded: Array | None = last
    for _ in range(2000):
        assert bounded is not None
        bounded = hand.update(TARGET, False, TARGET + np.array([0, 0, -0.5]), bounded, stance=STANCE)
    assert bounded is not None
    assert bounded[2] == pytest.approx(TARGET[2] + 0.05, abs=1e-6)
    np.testing.assert_allclose(bounded[:2], TARGET[:2], atol=1e-3)


def test_the_correction_takes_a_steady_sag_out() -> None:
    hand, palm, sag = HandReference(WEIGHTS, DT), PALM, np.array([0.0, 0.0, -0.02])
    for _ in range(1200):
        reference = hand.update(TARGET, False, palm, palm - sag, stance=STANCE)
        assert reference is not None
        palm = reference + sag
    np.testing.assert_allclose(palm, TARGET, atol=1e-4)


def test_far_from_the_target_nothing_is_integrated() -> None:
    hand = HandReference(WEIGHTS, DT)
    first = hand.update(TARGET, False, PALM - 1.0, PALM, stance=STANCE)
    assert first is not None
    assert np.linalg.norm(first - PALM) <= WEIGHTS.hand_speed * DT + 1e-12


def test_it_is_never_far_ahead_of_a_palm_that_cannot_follow() -> None:
    hand, stuck = HandReference(WEIGHTS, DT), PALM.copy()
    for hold in (False, True):
        for _ in range(400):
            ahead = hand.update(TARGET, hold, stuck, stuck, stance=STANCE)
            assert ahead is not None
            assert np.linalg.norm(ahead - stuck) <= WEIGHTS.hand_lead + 1e-12
        stuck = stuck - np.array([0.0, 0.0, 0.1])  # the body sinks while it is held


def test_a_palm_that_could_not_follow_turns_at_once_when_its_target_comes_back() -> None:
    hand = HandReference(WEIGHTS, DT)
    for _ in range(400):
        hand.update(TARGET, False, PALM, PALM, stance=STANCE)
    back = 2 * PALM - TARGET
    periods = 2 + round(WEIGHTS.hand_lead / (WEIGHTS.hand_speed * DT))
    for _ in range(periods):
        ahead = hand.update(back, False, PALM, PALM, stance=STANCE)
    assert ahead is not None
    assert (ahead - PALM) @ (back - PALM) > 0


def test_hold_freezes_the_hand_whatever_is_commanded() -> None:
    hand = HandReference(WEIGHTS, DT)
    last = follow(hand, 60)[-1]
    for target in (None, TARGET, TARGET + 1):
        frozen = hand.update(target, True, PALM, last, stance=STANCE)
        assert frozen is not None
        np.testing.assert_array_equal(frozen, last)


def test_a_held_hand_comes_along_with_the_stance() -> None:
    hand = HandReference(WEIGHTS, DT)
    x, y, z = held = follow(hand, 60)[-1]
    for share in np.linspace(0, 1, 20):
        stance = share * np.array([0.3, -0.1, np.pi / 2])
        moved = hand.update(TARGET, True, PALM, held, stance=stance, walks=True)
        assert moved is not None
        held = moved
    np.testing.assert_allclose(held, [0.3 - y, -0.1 + x, z], atol=1e-12)
    after = hand.update(TARGET, False, PALM, held, stance=stance)
    assert after is not None
    assert np.linalg.norm(after - held) <= WEIGHTS.hand_speed * DT + 1e-12  # it goes on from there, without a jump


@pytest.mark.parametrize("way", [0.35, -0.25])
def test_a_hand_whose_target_is_out_of_reach_is_let_go_while_walking(way: float) -> None:
    """It falls behind, or is still far ahead."""
    hand = HandReference(WEIGHTS, DT)
    follow(hand, 60)

    def at(x: float, walks: bool) -> bool:
        return hand.update(TARGET, False, PALM, PALM, stance=np.array([x, 0.0, 0.0]), walks=walks) is not None

    assert at(way, walks=False)
    assert not at(way, walks=True)
    assert not at(way, walks=False)  # it does not go for it as soon as the robot stands
    barely = way - math.copysign(0.06, way)
    assert not at(barely, walks=True)  # hysteresis
    assert at(way / 2, walks=True)
    assert at(barely, walks=True)
    assert not at(way, walks=True)
    assert hand.update(None, False, PALM, PALM, stance=STANCE) is None
    assert at(way, walks=False)  # asked anew while it stands


def test_a_free_hand_stays_free_in_hold_and_when_released() -> None:
    hand = HandReference(WEIGHTS, DT)
    assert hand.update(None, True, PALM, PALM, stance=STANCE) is None
    follow(hand, 200, np.array([0, 0, -0.03]))
    assert hand.update(None, False, PALM, PALM, stance=STANCE) is None
    again = hand.update(PALM, False, PALM, PALM, stance=STANCE)
    assert again is not None
    np.testing.assert_allclose(again, PALM)  # neither the old place nor the old correction is left


EYES = np.array([0.0, 0.0, 1.2])


def look(gaze: GazeReference, point: Array | None, periods: int = 600, heading: float = 0.0) -> None:
    for _ in range(periods):
        gaze.update(point, False, EYES, heading)


def test_the_gaze_turns_to_a_point_at_limited_speed() -> None:
    gaze = GazeReference(WEIGHTS, DT, 1.2)
    point = np.array([1.0, 1.0, 1.2 - math.sqrt(2) * math.tan(0.3)])
    gaze.update(point, False, EYES, 0.0)
    assert gaze.yaw == pytest.approx(WEIGHTS.gaze_speed * DT)
    look(gaze, point)
    assert (gaze.yaw, gaze.pitch) == (pytest.approx(math.pi / 4), pytest.approx(0.3))


def test_the_gaze_is_relative_to_the_heading() -> None:
    gaze = GazeReference(WEIGHTS, DT, 1.2)
    look(gaze, np.array([0.0, 2.0, 1.2]), heading=math.pi / 2)
    assert gaze.yaw == pytest.approx(0, abs=1e-9)


def test_the_gaze_has_limits() -> None:
    gaze = GazeReference(WEIGHTS, DT, 1.2)
    look(gaze, np.array([-1.0, 0.2, 5.0]))
    assert gaze.yaw == pytest.approx(WEIGHTS.gaze_yaw)
    assert gaze.pitch == pytest.approx(-0.5)
    look(gaze, np.array([0.1, 0.0, 0.0]))
    assert gaze.pitch == pytest.approx(0.8)


def test_what_passes_behind_does_not_swing_the_head_around() -> None:
    gaze = GazeReference(WEIGHTS, DT, 1.2)
    look(gaze, np.array([-1.0, 0.1, 1.2]))
    look(gaze, np.array([-1.0, -0.1, 1.2]))
    assert gaze.yaw == pytest.approx(WEIGHTS.gaze_yaw)


def test_the_torso_helps_only_beyond_what_the_neck_turns() -> None:
    gaze = GazeReference(WEIGHTS, DT, 1.0)
    gaze.yaw = 0.6
    assert gaze.torso_yaw == 0
    gaze.yaw = -1.5
    assert -1.0 < gaze.torso_yaw <= -0.5  # at least what is missing: the neck turns 1 rad, and keeps a reserve
    without_neck = GazeReference(WEIGHTS, DT, 0.0)
    without_neck.yaw = 0.5
    assert without_neck.torso_yaw == 0.5


def test_eyes_far_ahead_of_what_turns_them_do_not_swing_it_too_far() -> None:
    gaze, eyes, point = GazeReference(WEIGHTS, DT, 0.0), np.array([0.3, 0.0, 1.0]), np.array([0.5, 0.1, 0.6])
    for _ in range(600):
        gaze.update(point, False, eyes, 0.0, axis=np.zeros(3))
    assert gaze.yaw == pytest.approx(math.atan2(0.1, 0.5))


def test_hold_freezes_the_gaze_and_release_looks_ahead() -> None:
    gaze = GazeReference(WEIGHTS, DT, 1.2)
    look(gaze, np.array([1.0, 1.0, 1.2]))
    for _ in range(100):
        gaze.update(None, True, EYES, 0.0)
    assert gaze.yaw == pytest.approx(math.pi / 4)
    look(gaze, None)
    assert (gaze.yaw, gaze.pitch) == (0, 0)


def test_released_joints_go_home_at_limited_speed() -> None:
    home = np.array([0.0, 0.5, -0.5])
    posture = PostureReference(home, DT)
    np.testing.assert_array_equal(posture.joints, home)
    posture.release_from(np.array([0.3, 0.5, -0.504]))
    posture.update()
    np.testing.assert_allclose(posture.joints, [0.3 - DT, 0.5, -0.5], atol=1e-12)
    for _ in range(60):
        posture.update()
    np.testing.assert_allclose(posture.joints, home, atol=1e-12)


def test_the_height_of_a_robot_that_a_push_made_sink_as_it_steps_follows_it_down_and_rises_slowly() -> None:
    com = ComHeightReference(0.0, DT)
    com.reset(0.7)
    assert com.update(0.7, 0.695, steps=True) == 0.7  # as every step sways
    falls = [com.update(0.7, 0.6, steps=True) for _ in range(40)]
    assert falls[0] == pytest.approx(0.7 - 1.0 * DT)
    assert falls[-1] == pytest.approx(0.61)
    rises = [com.update(0.7, 0.75, steps=True) for _ in range(40)]
    assert rises[0] == pytest.approx(0.61 + 0.6 * DT)
    assert rises[-1] == 0.7


def test_the_height_of_a_robot_that_stands_does_not_sink_with_it() -> None:
    com = ComHeightReference(0.0, DT)
    com.reset(0.7)
    assert com.update(0.7, 0.6, steps=False) == 0.7
    assert com.update(0.65, 0.6, steps=False) == 0.65  # what is asked for, at once: it is slow itself
    assert com.update(0.7, 0.6, steps=False) == pytest.approx(0.65 + 0.6 * DT)


def test_the_body_rises_in_long_steps_and_comes_down_again() -> None:
    com = ComHeightReference(0.02, DT)
    com.reset(0.7)

    def heights(stride: float) -> np.ndarray:
        return np.array([com.height] + [com.update(0.7, 0.72, steps=True, stride=stride) for _ in range(400)])

    rises = heights(1.0)
    assert rises[-1] == pytest.approx(0.72, abs=1e-4)
    assert 0 < np.diff(rises).max() < 0.05 * DT
    assert np.abs(np.diff(rises, 2)).max() < 1.0 * DT**2  # no jerk
    assert heights(0.5)[-1] == pytest.approx(0.71, abs=1e-4)
    sinks = heights(0.0)
    assert sinks[-1] == pytest.approx(0.7, abs=1e-4)
    assert sinks.min() > 0.6999
    heights(1.0)
    com.reset(0.7)
    assert com.update(0.7, 0.7, steps=False) == 0.7


def test_the_plan_of_a_robot_that_rises_stays_near_it() -> None:
    com = ComHeightReference(0.02, DT)
    com.reset(0.7)
    assert max(com.update(0.7, 0.7, steps=True, stride=1.0) for _ in range(400)) == pytest.approx(0.71)


@pytest.mark.parametrize(("value", "goal", "after"), [(0, 1, 0.1), (0, -1, -0.1), (0.95, 1, 1), (1, 1, 1)])
def test_approach_never_overshoots(value: float, goal: float, after: float) -> None:
    assert approach(value, goal, 0.1) == pytest.approx(after)
