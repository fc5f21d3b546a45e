"""Checking files of every kind, scenarios and campaigns among them."""

from __future__ import annotations

import os
from os import PathLike

from humanoid_bt.campaign.file import FOLDER
from humanoid_bt.campaign.planning import checked_campaign
from humanoid_bt.checking.check import Kinds, collect, findings, settled
from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.gateway.file import FOLDER as GATEWAYS
from humanoid_bt.gateway.file import load_gateway
from humanoid_bt.testing.scenario_check import checked_scenario

KINDS: Kinds = {"scenarios": checked_scenario, FOLDER: checked_campaign, GATEWAYS: lambda path, _: load_gateway(path)}
"""What reads the files of a folder that are no trees, scenes, robots or skills."""


def check(*paths: str | PathLike[str], workspace: str | PathLike[str] | Workspace | None = None) -> list[Problem]:
    """Return what ``humanoid-bt check`` finds: errors and warnings, each with its place and the repair.

    Args:
        paths: names, files or folders of trees, skills, scenes, robots, scenarios, campaigns; the workspace if none.
        workspace: folder in which names are looked up; the working directory if None.

    Raises:
        UserError: there is nothing to check.
    """
    for path in paths:
        if not isinstance(path, (str, PathLike)):
            hint = "valid: a name, a file or a folder, as text or a Path"
            raise UserError(f"{path!r} cannot be checked", hint=hint, code="wrong-type")
    files, missing = collect([os.fspath(path) for path in paths], workspace)
    return [*missing, *settled({path: findings(path, where, KINDS) for path, where in files.items()})]
