"""Learned walkers for tests: descriptions beside tiny models."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from tests.onnx_models import write_affine

SIM = Path(__file__).resolve().parents[1] / "sim" / "humanoid"

JOINTS = ("a_hip", "b_hip", "c_knee")

DESCRIPTION = """\
format: 1
model: walk.onnx
default_pose: [0.1, 0.2, 0.3]
action: {scale: 0.5, clip: 2}
observation:
  terms:
    - {term: base_ang_vel, scale: 0.25}
    - {term: command, axes: [wz, vx]}
    - {term: joint_pos_rel}
    - {term: last_action}
command: {vx: [-1, 1], vy: [-0.5, 0.5], wz: [-1, 1]}
"""
METADATA = {"dof_names": list(JOINTS), "kp": [10, 20, 30], "kd": "1, 2, 3"}


def write_walker(folder: Path, description: str = DESCRIPTION, numbers: int = 11, **model: object) -> Path:
    """Write a walker of three joints whose answer is its offset; return its description."""
    write_affine(folder / "walk.onnx", np.zeros((numbers, 3)), [1.0, 0.0, -1.0], METADATA, **model)  # type: ignore[arg-type]  # of each their own kind
    path = folder / "walk.policy.yaml"
    path.write_text(description)
    return path


STANDING = """\
format: 1
model: stand.onnx
action: {{scale: 1}}
default_pose: {{{pose}}}
stiffness: 500
damping: 20
observation: {{terms: [{{term: projected_gravity}}, {{term: command}}, {{term: joint_pos_rel}}]}}
command: {{vx: [-1, 1], vy: [-1, 1], wz: [-1, 1]}}
"""


def write_standing_robot(folder: Path, joints: tuple[str, ...], pose: np.ndarray) -> Path:
    """Write the built-in robot with a policy that holds a posture by stiff drives; return its ``robot.yaml``."""
    count = len(joints)
    for file in ("robot.yaml", "humanoid.xml"):
        shutil.copy(SIM / file, folder)
    path = folder / "robot.yaml"
    path.write_text(path.read_text() + "\nbody: {walk: policy, policy: stand.policy.yaml}\n")
    write_affine(folder / "stand.onnx", np.zeros((6 + count, count)), np.zeros(count), {"joint_names": list(joints)})
    angles = ", ".join(f"{name}: {angle:.6f}" for name, angle in zip(joints, pose, strict=True))
    (folder / "stand.policy.yaml").write_text(STANDING.format(pose=angles))
    return path
