"""The built-in robot with other ranges of joints."""

from __future__ import annotations

import fnmatch
import shutil
from pathlib import Path

import mujoco

from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.robot.published import read_model

_BUILTIN = builtin_root() / "sim" / "humanoid"


def write_joint_ranges(folder: Path, *patterns: str, half: float | None = None) -> Path:
    """Write such a robot into a folder; return its ``robot.yaml``.

    Args:
        folder: where to.
        patterns: of the joints.
        half: to where they turn both ways [rad]; None for on and on.
    """
    spec = read_model(_BUILTIN / "humanoid.xml")
    for joint in spec.joints:
        if any(fnmatch.fnmatch(joint.name, pattern) for pattern in patterns):
            joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE if half is None else mujoco.mjtLimited.mjLIMITED_TRUE
            joint.range = [0.0, 0.0] if half is None else [-half, half]
    (folder / "humanoid.xml").write_text(spec.to_xml())
    shutil.copy(_BUILTIN / "robot.yaml", folder)
    return folder / "robot.yaml"
