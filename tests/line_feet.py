"""The built-in robot with ankles that only pitch, on narrow soles."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.core.messages import SIDES
from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.robot.published import read_model

_BUILTIN = builtin_root() / "sim" / "humanoid"
_HALF_WIDTH = 0.02  # m


def write_line_feet(folder: Path) -> Path:
    """Write such a robot into a folder; return its ``robot.yaml``."""
    spec = read_model(_BUILTIN / "humanoid.xml")
    text = (_BUILTIN / "robot.yaml").read_text().replace("half_width: 0.045", f"half_width: {_HALF_WIDTH}")
    for side in SIDES:
        spec.delete(spec.joint(f"{side}_ankle_roll"))
        text = text.replace(f"    ankle_roll: {side}_ankle_roll\n", "")
        for geom in spec.body(f"{side}_foot").geoms:
            geom.size[1] = _HALF_WIDTH
    assert "ankle_roll" not in text
    (folder / "humanoid.xml").write_text(spec.to_xml())
    (folder / "robot.yaml").write_text(text)
    return folder / "robot.yaml"
