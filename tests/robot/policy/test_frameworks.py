"""The examples of docs/policies.md, one of each training framework, on models of the form that it exports."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_bt.control.body.policy.observation import Observation
from humanoid_bt.core.messages import Array, Estimate
from humanoid_bt.robot.policy.policy import Policy, load_policy
from tests.onnx_models import write_affine

pytest.importorskip("onnxruntime", reason="learned walkers need onnxruntime: pip install 'humanoid-bt[policy]'")

PAGE = Path(__file__).parents[3] / "docs" / "policies.md"
LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow", "wrist_roll", "wrist_pitch", "wrist_yaw")
WAIST = ("waist_yaw", "waist_roll", "waist_pitch")
MOTORS = [
    f"{name}_joint"
    for name in (
        *(f"{side}_{part}" for side in ("left", "right") for part in LEG),
        *WAIST,
        *(f"{side}_{part}" for side in ("left", "right") for part in ARM),
    )
]
"""Of a G1 with 29 joints, in the order of its motors."""

NONE = np.zeros(0, dtype=np.intp)
COMMAND = np.array([0.5, 0.2, -0.3])


def loaded(
    folder: Path, framework: str, *, width: int, moved: int, metadata: dict[str, Any] | None = None, state: int = 0
) -> Policy:
    """Return the walker that the page's example describes, on a model that answers zeros."""
    section = PAGE.read_text(encoding="utf-8").split(f"\n### {framework}\n")[1].split("\n#")[0]
    (text,) = re.findall(r"```yaml\n(.*?)```", section, re.DOTALL)
    text = re.sub(r"model: \S+", "model: policy.onnx", text)
    if state:
        text = text.replace(", {input: c_in, output: c_out}", "")  # the writer of models has one memory
    path = folder / "walk.policy.yaml"
    path.write_text(text)
    write_affine(folder / "policy.onnx", np.zeros((width, moved)), np.zeros(moved), metadata, state=state)
    return load_policy(path)


def seen(policy: Policy, times: int = 1) -> Array:
    """Return what the walker is told after some times: joint i of the robot at i / 100 rad, and at i / 10 rad/s."""
    robot = MOTORS
    joints = np.array([robot.index(name) for name in policy.joints])
    observation = Observation(policy, joints, 0.02)
    observation.last_action = np.arange(len(policy.moves), dtype=float)
    count = len(robot)
    qpos = np.concatenate([[0, 0, 1, 1, 0, 0, 0], np.arange(count) / 100])
    qvel = np.concatenate([[1, 2, 3, 0.4, 0.5, 0.6], np.arange(count) / 10])
    row = np.zeros(0)
    for number in range(times):
        qvel[3] = 0.4 + number
        row = observation.observe(Estimate(0.0, qpos, qvel, np.zeros(count), np.zeros(2)), COMMAND, False, NONE)[0]
    return row


def test_holosoma(tmp_path: Path) -> None:
    ranges = {"lin_vel_x": [-1, 1], "lin_vel_y": [-1, 1], "ang_vel_yaw": [-1, 1]}
    metadata = {"dof_names": MOTORS, "kp": [40.0] * 29, "kd": [2.0] * 29, "command_ranges": ranges}
    policy = loaded(tmp_path, "holosoma", width=100, moved=29, metadata=metadata)
    assert policy.default_pose[:6].tolist() == [-0.312, 0, 0, 0.669, -0.363, 0]
    assert policy.default_pose[15:19].tolist() == [0.2, 0.2, 0, 0.6]
    row = seen(policy)
    assert row[:29].tolist() == list(range(29))
    assert row[29:35] == pytest.approx([0.1, 0.125, 0.15, -0.3, 0.5, 0.2])
    angle = 2 * np.pi * 0.02
    assert row[35:37] == pytest.approx([np.cos(angle), -np.cos(angle)])
    assert row[37 + 3] == pytest.approx(0.03 - 0.669)
    assert row[66 + 3] == pytest.approx(0.05 * 0.3)
    assert row[95:98].tolist() == [0, 0, -1]


def test_unitree_rl_gym(tmp_path: Path) -> None:
    policy = loaded(tmp_path, "unitree_rl_gym", width=47, moved=12, state=64)
    assert (list(policy.joints), policy.states) == (MOTORS[:12], {"h_in": "h_out"})
    assert policy.default_pose[:6].tolist() == [-0.1, 0, 0, 0.3, -0.2, 0]
    assert policy.stiffness[:6].tolist() == [100, 100, 100, 150, 40, 40]
    assert policy.damping[:6].tolist() == [2, 2, 2, 4, 2, 2]
    row = seen(policy)
    assert row[:9] == pytest.approx([0.1, 0.125, 0.15, 0, 0, -1, 1.0, 0.4, -0.075])
    assert row[9 + 3] == pytest.approx(0.03 - 0.3)
    assert row[21 + 3] == pytest.approx(0.05 * 0.3)
    assert row[33:45].tolist() == list(range(12))
    angle = 2 * np.pi * 0.02 / 0.8
    assert row[45:] == pytest.approx([np.sin(angle), np.cos(angle)])


def test_unitree_rl_lab(tmp_path: Path) -> None:
    policy = loaded(tmp_path, "unitree_rl_lab", width=5 * 96, moved=29)
    order = [0, 6, 12, 1, 7, 13, 2, 8, 14, 3, 9, 15, 22, 4, 10, 16, 23, 5, 11, 17, 24, 18, 25, 19, 26, 20, 27, 21, 28]
    assert [MOTORS.index(name) for name in policy.joints] == order, "its joint_ids_map"
    stiffness = dict(zip(policy.joints, policy.stiffness, strict=True))
    assert [stiffness[name] for name in MOTORS] == [*[100, 100, 100, 150, 40, 40] * 2, *[200] * 3, *[40] * 14]
    damping = dict(zip(policy.joints, policy.damping, strict=True))
    assert [damping[name] for name in MOTORS] == [*[2, 2, 2, 4, 2, 2] * 2, *[5] * 3, *[10] * 14]
    assert policy.default_pose[9:17].tolist() == [0.3, 0.3, 0.3, 0.3, -0.2, -0.2, 0.25, -0.25]
    row = seen(policy, times=2)
    rates = row[:15].reshape(5, 3)
    assert rates[:, 0] == pytest.approx([0.08] * 4 + [0.28]), "filled with the first, the newest last"
    first_pose = row[45:74]
    assert first_pose == pytest.approx(np.array(order) / 100 - policy.default_pose)


@pytest.mark.parametrize("written", ["json", "commas"])
def test_mjlab(tmp_path: Path, written: str) -> None:
    numbers = [round(0.01 * number, 3) for number in range(29)]
    text = numbers if written == "json" else ",".join(f"{number:.3f}" for number in numbers)
    names = MOTORS if written == "json" else ",".join(MOTORS)
    keys = ("joint_stiffness", "joint_damping", "default_joint_pos", "action_scale")
    metadata = {"joint_names": names, **dict.fromkeys(keys, text)}
    policy = loaded(tmp_path, "mjlab", width=99, moved=29, metadata=metadata)
    assert list(policy.joints) == MOTORS
    for found in (policy.stiffness, policy.damping, policy.default_pose, policy.scale):
        assert found == pytest.approx(numbers)
    row = seen(policy)
    assert row[:9] == pytest.approx([1, 2, 3, 0.4, 0.5, 0.6, 0, 0, -1])
    assert row[9:38] == pytest.approx(np.zeros(29), abs=1e-6)
    assert row[-3:] == pytest.approx(COMMAND)


def test_isaac_lab(tmp_path: Path) -> None:
    policy = loaded(tmp_path, "Isaac Lab", width=12 + 3 * 13, moved=13)
    stiffness = dict(zip(policy.joints, policy.stiffness, strict=True))
    assert (stiffness["left_hip_pitch_joint"], stiffness["left_hip_yaw_joint"]) == (200, 150)
    assert policy.offset.tolist() == policy.default_pose.tolist()
    row = seen(policy)
    assert row[9:12] == pytest.approx(COMMAND)
    assert row[12:15] == pytest.approx([0 + 0.2, 0.06 + 0.2, 0.12])
    assert row[25:28] == pytest.approx([0, 0.6, 1.2])
