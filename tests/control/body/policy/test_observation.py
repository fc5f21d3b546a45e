"""What a learned walker is told, number by number."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.control.body.policy.observation import Observation, Phase
from humanoid_bt.core.messages import Array, Estimate
from humanoid_bt.robot.policy.config import PhaseConfig
from humanoid_bt.robot.policy.policy import load_policy
from tests.policy_files import DESCRIPTION, write_walker

pytest.importorskip("onnxruntime", reason="learned walkers need onnxruntime: pip install 'humanoid-bt[policy]'")

NONE = np.zeros(0, dtype=np.intp)
COMMAND = np.array([0.5, 0.2, -0.3])


def estimate(joints: Array, quaternion: tuple[float, ...] = (1, 0, 0, 0)) -> Estimate:
    """A robot with four joints, of which the policy knows the last three."""
    qpos = np.concatenate([[0, 0, 1], quaternion, [9.0], joints])
    qvel = np.array([1.0, 2.0, 3.0, 0.4, 0.5, 0.6, 9.0, 0.1, 0.2, 0.3])
    return Estimate(0.0, qpos, qvel, np.zeros(4), np.zeros(2))


def observation(folder: Path, terms: str, more: str = "", after: str = "") -> Observation:
    begin, end = DESCRIPTION.split("  terms:\n")[0], "command:" + DESCRIPTION.split("\ncommand:")[1]
    text = f"{begin}  terms: {terms}\n{more}{end}{after}"
    path = write_walker(folder, text, numbers=_width(folder, text))
    return Observation(load_policy(path), np.array([1, 2, 3]), 0.02)


def _width(folder: Path, text: str) -> int:
    """Return how many numbers a description asks for: the message says it."""
    from humanoid_bt.core.errors import UserError

    try:
        return load_policy(write_walker(folder, text, numbers=1)).width
    except UserError as error:
        return int(str(error).split("the terms have ")[1].split()[0])


def test_terms_stand_in_order_with_their_scales(tmp_path: Path) -> None:
    seen = observation(
        tmp_path,
        "[{term: base_ang_vel, scale: 0.5}, {term: command, axes: [wz, vx]}, {term: joint_pos_rel},"
        " {term: joint_vel, scale: [1, 2, 3]}, {term: joint_pos, joints: [c_knee, a_hip]},"
        " {term: constant, value: [7]}, {term: last_action}]",
    )
    seen.last_action = np.array([4.0, 5.0, 6.0])
    row = seen.observe(estimate(np.array([0.1, 0.4, 0.9])), COMMAND, False, NONE)
    expected = [0.2, 0.25, 0.3, -0.3, 0.5, 0.0, 0.2, 0.6, 0.1, 0.4, 0.9, 0.9, 0.1, 7, 4, 5, 6]
    assert row.dtype == np.float32
    assert row[0] == pytest.approx(expected)


def test_gravity_and_velocity_are_seen_from_the_base(tmp_path: Path) -> None:
    seen = observation(tmp_path, "[{term: projected_gravity}, {term: base_lin_vel}]")
    half = math.sqrt(0.5)
    row = seen.observe(estimate(np.zeros(3), (half, 0, half, 0)), COMMAND, False, NONE)[0]  # pitched down by 90 deg
    assert row == pytest.approx([1, 0, 0, -3, 2, 1], abs=1e-6)


def test_what_others_move_is_at_rest_in_the_default_pose(tmp_path: Path) -> None:
    seen = observation(tmp_path, "[{term: joint_pos_rel}, {term: joint_vel}, {term: joint_pos}]")
    row = seen.observe(estimate(np.array([0.5, 0.6, 0.7])), COMMAND, False, np.array([1]))[0]
    assert row == pytest.approx([0.4, 0, 0.4, 0.1, 0, 0.3, 0.5, 0.2, 0.7])


def test_a_clip_comes_after_the_scale(tmp_path: Path) -> None:
    seen = observation(tmp_path, "[{term: command, scale: 10, clip: 4}]", "  clip: 3.5\n")
    assert seen.observe(estimate(np.zeros(3)), COMMAND, False, NONE)[0].tolist() == [3.5, 2.0, -3.0]


def test_a_clip_may_come_before_the_scale_and_have_two_bounds(tmp_path: Path) -> None:
    terms = "[{term: command, scale: [10, 20, 30], clip: [-0.1, 0.4]}]"
    seen = observation(tmp_path, terms, "  clipped: before_scale\n")
    assert seen.observe(estimate(np.zeros(3)), COMMAND, False, NONE)[0] == pytest.approx([4.0, 4.0, -3.0])


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        ("  history: 3\n", [0, 0, 1, 1, 2, 2, 0, 10, 20]),
        ("  history: 3\n  fill: first\n", [1, 1, 1, 1, 2, 2, 10, 10, 20]),
        ("  history: 3\n  order: by_time\n", [0, 0, 0, 1, 1, 10, 2, 2, 20]),
    ],
)
def test_history(tmp_path: Path, rule: str, expected: list[float]) -> None:
    terms = "[{term: command, axes: [vx, vy]}, {term: command, axes: [wz]}]"
    seen = observation(tmp_path, terms, rule)
    row = np.zeros(0)
    for value in (1.0, 2.0):
        row = seen.observe(estimate(np.zeros(3)), np.array([value, value, 10 * value]), False, NONE)[0]
    assert row.tolist() == expected


def test_the_phase_goes_round_stands_and_begins_anew() -> None:
    phase = Phase(PhaseConfig(period=0.08, start=[0.0, math.pi], standing=[math.pi, math.pi]), 0.02)
    phase.advance(False)
    assert phase.angles == pytest.approx([math.pi / 2, -math.pi / 2])
    phase.advance(True)
    assert phase.angles.tolist() == [math.pi, math.pi]
    phase.advance(False)
    assert phase.angles.tolist() == [0.0, math.pi]


def test_a_phase_without_a_rule_for_standing_goes_on() -> None:
    phase = Phase(PhaseConfig(period=0.08), 0.02)
    for _ in range(3):
        phase.advance(True)
    assert phase.angles == pytest.approx([-math.pi / 2])


@pytest.mark.parametrize(("rule", "expected"), [("before", math.sin(math.pi / 2)), ("after", 0.0)])
def test_the_phase_moves_on_before_or_after_it_is_seen(tmp_path: Path, rule: str, expected: float) -> None:
    after = f"phase: {{period: 0.08, advance: {rule}}}\n"
    seen = observation(tmp_path, "[{term: phase_sin}, {term: phase_cos}]", after=after)
    row = seen.observe(estimate(np.zeros(3)), COMMAND, False, NONE)[0]
    assert row[0] == pytest.approx(expected)


def test_a_phase_may_be_seen_as_nothing_while_the_robot_stands(tmp_path: Path) -> None:
    after = "phase: {period: 0.08, standing_zero: true}\n"
    seen = observation(tmp_path, "[{term: phase_sin}, {term: phase_cos}]", after=after)
    rows = [seen.observe(estimate(np.zeros(3)), COMMAND, stands, NONE)[0] for stands in (False, True, False)]
    assert rows[0] == pytest.approx([1, 0], abs=1e-6)
    assert rows[1].tolist() == [0, 0]
    assert rows[2] == pytest.approx([-1, 0], abs=1e-6), "it has gone on"
