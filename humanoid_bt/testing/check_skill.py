"""``hbt.check_skill``: a skill tried against the contract in one call."""

from __future__ import annotations

from os import PathLike
from typing import Any

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.testing.check_skill_result import SkillCheck
from humanoid_bt.testing.rig import Rig


def check_skill(
    skill: str,
    *,
    workspace: str | PathLike[str] | Workspace | None = None,
    robot: str = "humanoid",
    timeout: float | str = 10.0,
    **values: Any,
) -> SkillCheck:
    """Try a skill against the contract on a rig of its own; print what comes back, or call its ``assert_passed()``.

    In tests ask the rig that is there: ``rig.check_skill("reach", target=(0.4, 0.2, 1.0)).assert_passed()``.

    Args:
        skill: its name in trees.
        workspace: where skills are found; the working directory if None.
        robot: name of the robot.
        timeout: longest simulated time of one of its lives [s]; or text, "2 min".
        values: its parameters, best such with which it succeeds. For one that names a percept a position (x, y, z) may
            be given, world frame [m]: the robot sees a thing there.

    Raises:
        UserError: the robot, the skill or a value has mistakes.
    """
    return Rig(workspace, robot).check_skill(skill, timeout=timeout, **values)
