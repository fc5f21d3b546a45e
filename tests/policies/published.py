"""Published robots with learned walkers: as a newcomer would bring them into a workspace."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.robot.published import read_model
from humanoid_bt.robot.survey.description import describe
from tests.published import published_policy, published_robot

G1_LEG, G1_ARMS = "-0.312, 0, 0, 0.669, -0.363, 0", "0.2, 0.2, 0, 0.6, 0, 0, 0, 0.2, -0.2, 0, 0.6, 0, 0, 0"
T1_LEG, T1_ARMS = "-0.2, 0, 0, 0.4, -0.25, 0", "0.2, -1.35, 0, -0.5, 0, 0, 0, 0.2, 1.35, 0, 0.5, 0, 0, 0"
POSE = {"g1": f"{G1_LEG}, {G1_LEG}, 0, 0, 0, {G1_ARMS}", "t1": f"0, 0, {T1_ARMS}, 0, {T1_LEG}, {T1_LEG}"}
SCALES = {"g1": (0.25, 0.05), "t1": (1.0, 0.1)}
MODELS = {"g1": "unitree_g1_29dof/g1_29dof.xml", "t1": "booster_t1_29dof/t1_29dof.xml"}

DESCRIPTION = """\
format: 1
model: {model}
rate: 50
default_pose: [{pose}]
action: {{scale: 0.25, clip: 100, last_action: raw}}
observation:
  terms:
    - {{term: last_action}}
    - {{term: base_ang_vel, scale: {rate}}}
    - {{term: command, axes: [wz]}}
    - {{term: command, axes: [vx, vy]}}
    - {{term: phase_cos}}
    - {{term: joint_pos_rel}}
    - {{term: joint_vel, scale: {speed}}}
    - {{term: projected_gravity}}
    - {{term: phase_sin}}
phase: {{period: 1 s, start: [0, 180 deg], standing: [180 deg, 180 deg]}}
lend: {{waist: [{waist}]}}
"""


def write_robot(folder: Path, robot: str, algorithm: str) -> Path:
    """Write a robot with a walker of holosoma into a folder, as ``robots init`` does; return its ``robot.yaml``."""
    model = published_robot(MODELS[robot])
    network = published_policy(f"holosoma/{algorithm}_{robot}_29dof.onnx")
    text = describe(read_model(model).compile(), robot, str(model)).text
    path = folder / "robot.yaml"
    path.write_text(text + "\nbody: {walk: policy, policy: walk.policy.yaml}\n")
    rate, speed = SCALES[robot]
    waist = '"waist_*"' if robot == "g1" else ""
    description = DESCRIPTION.format(model=network, pose=POSE[robot], rate=rate, speed=speed, waist=waist)
    (folder / "walk.policy.yaml").write_text(description)
    return path
