"""The built-in robot as another modeller would have written it: it moves the same."""

from __future__ import annotations

import shutil
from pathlib import Path

from humanoid_bt.core.messages import SIDES
from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.robot.published import read_model

_BUILTIN = builtin_root() / "sim" / "humanoid"
_LEFT, _RIGHT = [0.5**0.5, 0.0, 0.0, 0.5**0.5], [0.5**0.5, 0.0, 0.0, -(0.5**0.5)]  # quarters of a turn


def write_other_frames(folder: Path) -> Path:
    """Write it with waist and neck that turn the other way round, and frames of the shoulders that look aside."""
    spec = read_model(_BUILTIN / "humanoid.xml")
    for name in ("waist_roll", "waist_pitch", "neck_pitch"):
        joint = spec.joint(name)
        joint.axis, joint.range = -joint.axis, -joint.range[::-1]
    for side in SIDES:
        spec.body(f"{side}_shoulder_pitch_link").quat = _LEFT
        spec.joint(f"{side}_shoulder_pitch").axis = [1.0, 0.0, 0.0]
        spec.body(f"{side}_shoulder_roll_link").quat = _RIGHT
    (folder / "humanoid.xml").write_text(spec.to_xml())
    shutil.copy(_BUILTIN / "robot.yaml", folder)
    return folder / "robot.yaml"
