from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.control.body.swing import Swing, TiltCompensation
from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Array, Side
from humanoid_bt.robot.config import GaitConfig, SoleConfig

GAIT = GaitConfig()
SOLE = SoleConfig(half_length=0.105, half_width=0.045)
OMEGA, DT = 3.9, 0.005
PERIODS = round(GAIT.single_support / DT)
SUPPORT = np.array([0.0, -0.09, 0.0])
START = np.array([-0.15, 0.09, 0.0])
FOOTHOLD = np.array([0.15, 0.09, 0.2])
LEVEL = np.zeros(3)
DCM_END = np.array([0.10, 0.02])  # planned at touchdown


def swing_of(side: Side = "left", footings: tuple[Array, Array] = (LEVEL, LEVEL), gait: GaitConfig = GAIT) -> Swing:
    mirror = np.array([1, 1, 1]) if side == "left" else np.array([1, -1, -1])
    return Swing(
        gait,
        SOLE,
        OMEGA,
        DT,
        side=side,
        start=START * mirror,
        foothold=FOOTHOLD * mirror,
        support=SUPPORT * mirror,
        footings=footings,
        dcm_end=DCM_END * mirror[:2],
    )


def planned_dcm(elapsed: int) -> Array:
    """The DCM from which the ZMP under the support foot leads to the planned one at touchdown."""
    return SUPPORT[:2] + (DCM_END - SUPPORT[:2]) * math.exp(-OMEGA * (PERIODS - elapsed) * DT)


def flying(swing: Swing, error: Array | None = None, since: int = 0) -> Iterator[Swing]:
    """Make the swing with a DCM error, shape (2,), from a period on; give it after each."""
    for elapsed in range(PERIODS):
        off = error if error is not None and elapsed >= since else np.zeros(2)
        swing.update(elapsed, planned_dcm(elapsed) + off, SUPPORT[:2])
        yield swing


def fly(swing: Swing, error: Array | None = None, since: int = 0) -> tuple[Array, Array]:
    """Make the swing likewise; return poses (n, 3) and heights (n,)."""
    poses, heights = [swing.pose.copy()], [swing.footing.item(0)]
    for _ in flying(swing, error, since):
        poses.append(swing.pose.copy())
        heights.append(swing.footing.item(0))
    return np.array(poses), np.array(heights)


def test_it_goes_from_lift_off_to_the_foothold() -> None:
    swing = swing_of()
    poses, heights = fly(swing)
    np.testing.assert_array_equal(poses[0], START)
    np.testing.assert_allclose(poses[-1], FOOTHOLD, atol=2e-3)
    np.testing.assert_allclose(swing.target, FOOTHOLD, atol=1e-9)
    assert swing.progress == pytest.approx(1)
    assert heights[0] == 0
    assert -0.006 < heights[-1] < 0  # it aims a little below the ground, so that it does land


def test_it_lifts_the_foot_once_and_as_high_as_the_gait_says() -> None:
    _, heights = fly(swing_of())
    top = int(heights.argmax())
    assert heights[top] == pytest.approx(GAIT.lift, rel=0.01)
    assert (np.diff(heights[: top + 1]) > 0).all()
    assert (np.diff(heights[top:]) < 0).all()


def test_it_lands_as_high_and_as_steep_as_the_ground_under_the_other_foot_says() -> None:
    """Of a slope of 0.07 rad that rises along x: the sole leans back."""
    here, there = np.array([0.01, 0.0, 0.0]), np.array([0.02, 0.0, -0.07])
    swing = swing_of(footings=(here, there))
    _, heights = fly(swing)
    assert heights[0] == 0.01
    rise = 0.07 * (FOOTHOLD - SUPPORT)[0]
    assert heights[-1] == pytest.approx(0.02 + rise - 0.004, abs=1e-3)
    np.testing.assert_allclose(swing.footing[1:], [0, -0.07], atol=1e-6)


def test_it_is_over_its_foothold_before_it_lands() -> None:
    poses, heights = fly(swing_of())
    early = -round(0.02 / DT)
    assert np.linalg.norm(poses[early, :2] - FOOTHOLD[:2]) < 0.006
    assert heights[early] < 0.01


def test_it_tells_by_how_much_a_step_misses_where_the_dcm_runs_off() -> None:
    planned, aside, across = swing_of(), swing_of(), swing_of()
    fly(planned)
    assert not planned.missed.any()
    fly(aside, np.array([0.0, 0.05]))
    assert math.hypot(*aside.missed) < 0.01
    fly(across, np.array([0.0, -0.15]))  # beyond the foot that stands, where this one cannot land
    assert across.missed[1] < -0.1
    assert abs(across.missed[0]) < 0.02


@pytest.mark.parametrize(
    ("error", "least", "most"),
    [
        pytest.param((0.0, 0.0), 0.08, 0.09, id="nothing disturbs it"),
        pytest.param((-0.08, 0.0), 0.0, 0.01, id="it lands elsewhere"),
        pytest.param((0.0, -0.06), 0.0, 0.02, id="it misses where the DCM runs off"),
        pytest.param((0.0, 0.03), 0.0, 0.03, id="it hurries"),
    ],
)
def test_a_foot_lands_by_its_heel_if_nothing_disturbs_its_step(
    error: tuple[float, float], least: float, most: float
) -> None:
    assert least <= rolled(np.array(error))[PERIODS // 2 :].max() < most


def test_a_foot_that_has_to_hurry_as_its_heel_comes_down_turns_flat_without_a_jump() -> None:
    tilts = rolled(np.array([0.0, 0.06]), since=round(0.65 * PERIODS))
    assert tilts[-1] < 0.001
    assert np.abs(np.diff(tilts)).max() < 0.03


def rolled(error: Array, since: int = 0) -> Array:
    """How far a foot that is to land by its heel is pitched, with a DCM error from a period on, shape (n,) [rad]."""
    swings = flying(swing_of(gait=replace(GAIT, heel_strike=0.2)), error, since)
    return np.array([math.hypot(*swing.rolled[1:]) for swing in swings])


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_foothold_moves_the_way_the_dcm_runs_off(axis: int, sign: int) -> None:
    swing = swing_of()
    error = np.zeros(2)
    error[axis] = sign * 0.03
    fly(swing, error)
    shift = swing.target[:2] - FOOTHOLD[:2]
    assert sign * shift[axis] > 0.01
    assert abs(shift[1 - axis]) < 0.01  # what a step that lands sooner needs less


def test_an_error_that_the_ankle_has_time_to_take_out_leaves_the_foothold() -> None:
    swing = swing_of()
    for elapsed in range(round(0.85 * PERIODS)):
        swing.update(elapsed, planned_dcm(elapsed) + np.array([0.008, -0.002]), SUPPORT[:2])
    np.testing.assert_allclose(swing.target, FOOTHOLD, atol=1e-9)


@pytest.mark.parametrize("side", ["left", "right"])
def test_adjustment_keeps_its_limits_and_the_feet_apart(side: Side) -> None:
    outward = 1 if side == "left" else -1
    for error in ([1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]):
        swing = swing_of(side)
        for elapsed in range(PERIODS):
            swing.update(elapsed, np.array(error), SUPPORT[:2])
            forward = swing.target[0] - FOOTHOLD[0]
            apart = outward * (swing.target[1] - (SUPPORT[1] if side == "left" else -SUPPORT[1]))
            assert abs(forward) <= GAIT.adjust_forward + 1e-9
            assert GAIT.separation_min - 1e-9 <= apart <= GAIT.separation_max + 1e-9


def test_the_foothold_stays_late_in_the_swing() -> None:
    swing = swing_of()
    fly(swing, np.array([0.2, 0.1]), since=round(GAIT.adjust_until * PERIODS))
    np.testing.assert_allclose(swing.target, FOOTHOLD, atol=1e-9)


def test_the_reference_never_jumps_when_the_foothold_does() -> None:
    for share in (0.0, 0.3, 0.5, 0.8):
        poses, heights = fly(swing_of(), np.array([0.3, 0.3]), since=int(share * PERIODS))
        assert np.abs(np.diff(poses[:, :2], axis=0)).max() <= 4.0 * DT + 1e-12  # m/s
        assert np.abs(np.diff(heights)).max() < 0.003


def test_it_hurries_when_the_foot_would_have_to_cross_the_other() -> None:
    swing = swing_of()
    swing.update(0, planned_dcm(0) + np.array([0.0, -0.05]), SUPPORT[:2])
    assert 1.2 < swing.rate <= GAIT.single_support / GAIT.quickest_step + 1e-9
    swing.update(1, planned_dcm(1), SUPPORT[:2])
    assert swing.rate == pytest.approx(1)


def flight(dcm: list[float]) -> float:
    """Return how long a swing takes [s] with the DCM at a place."""
    swing, elapsed, flown = swing_of(), 0.0, 0.0
    while elapsed < PERIODS:
        swing.update(elapsed, np.array(dcm), SUPPORT[:2])
        elapsed += swing.rate
        flown += DT
    return flown


def test_no_step_is_quicker_than_the_quickest() -> None:
    near = flight([-0.1, -0.3])  # it would have to cross the other foot, and lands where it comes from
    assert near == pytest.approx(GAIT.quickest_step, abs=2 * DT)


def test_a_long_step_takes_longer_than_the_quickest() -> None:
    far = flight([0.25, 0.1])
    assert GAIT.quickest_step + 5 * DT < far < GAIT.single_support - 5 * DT


# ---- the swing foot stays level with the ground when the base tilts -------------------------------------------------

UPRIGHT = np.array([0.0, 0, 0.7, 1, 0, 0, 0])


def tilted(pitch: float) -> Array:
    return np.array([0.0, 0, 0.7, math.cos(pitch / 2), 0, math.sin(pitch / 2), 0])


def swing_at(progress: float) -> Swing:
    swing = swing_of()
    swing.progress = progress
    return swing


def test_no_tilt_needs_no_compensation() -> None:
    tilt = TiltCompensation(DT)
    tilt.update(swing_at(0.5), UPRIGHT, UPRIGHT)
    np.testing.assert_allclose(tilt.correction["left"], np.zeros(6), atol=1e-12)


def test_the_swing_foot_turns_against_the_tilt_and_the_stance_foot_not() -> None:
    tilt = TiltCompensation(DT)
    for _ in range(40):
        tilt.update(swing_at(0.5), tilted(0.05), UPRIGHT)
    np.testing.assert_allclose(tilt.correction["left"][3:], [0, -0.05, 0], atol=1e-3)
    np.testing.assert_array_equal(tilt.correction["right"], np.zeros(6))


@pytest.mark.parametrize("far", [[0.0, 0.0, 0.0], [40.0, -30.0, 0.0]])
def test_the_swing_foot_is_where_it_is_to_be_once_the_base_is(far: list[float]) -> None:
    tilt, swing = TiltCompensation(DT), swing_at(0.5)
    measured, reference = tilted(0.05), UPRIGHT.copy()
    reference[:2] += 0.01, 0.02
    for pose in (measured, reference, swing.pose):
        pose[:2] += far[:2]
    for _ in range(40):
        tilt.update(swing, measured, reference)
    sole = np.array([*swing.pose[:2], swing.footing[0]])
    seen_from_base = rotation_matrix(measured[3:]).T @ (sole - measured[:3])
    np.testing.assert_allclose(sole + tilt.correction["left"][:3], reference[:3] + seen_from_base, atol=1e-4)


def test_compensation_fades_in_and_is_limited() -> None:
    early, full, extreme = TiltCompensation(DT), TiltCompensation(DT), TiltCompensation(DT)
    for _ in range(100):
        early.update(swing_at(0.03), tilted(0.05), UPRIGHT)
        full.update(swing_at(0.30), tilted(0.05), UPRIGHT)
        extreme.update(swing_at(0.5), tilted(1.0), UPRIGHT)
    assert early.correction["left"][4] == pytest.approx(0.1 * full.correction["left"][4], rel=1e-3)
    assert np.abs(extreme.correction["left"]).max() == pytest.approx(0.3, rel=1e-3)


def test_compensation_decays_after_touchdown_without_a_jump() -> None:
    tilt = TiltCompensation(DT)
    for _ in range(100):
        tilt.update(swing_at(0.5), tilted(0.1), UPRIGHT)
    before = tilt.correction["left"].copy()
    tilt.update(None, tilted(0.1), UPRIGHT)
    np.testing.assert_allclose(tilt.correction["left"], before, rtol=0.05)
    for _ in range(round(0.36 / DT)):
        tilt.update(None, tilted(0.1), UPRIGHT)
    assert np.abs(tilt.correction["left"]).max() < 0.06 * np.abs(before).max()
