"""The command that runs a trial again."""

from __future__ import annotations

import shlex
from pathlib import Path

from humanoid_bt.campaign.plan import Plan
from humanoid_bt.campaign.store import RECORDINGS, read_results, recorded_as
from humanoid_bt.campaign.trial import CONDITION, SET, Trial
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.params import params_of
from humanoid_bt.files.document import as_line
from humanoid_bt.testing.conditions import Conditions

_AS_IT_IS = {f"{CONDITION}.{name}": spec.default for name, spec in params_of(Conditions).items()}


def command_of(recording: Path) -> str:
    """Return the command that runs the trial of a recording again, "" if no campaign made it."""
    path = recording.absolute()
    folder = path.parent.parent
    if path.parent.name != RECORDINGS:
        return ""
    try:
        plan = read_results(folder).plan
    except UserError:
        return ""
    trial = next((trial for trial in plan.trials if path.name == recorded_as(trial)), None)
    return command(trial, plan, folder) if trial else ""


def command(trial: Trial, plan: Plan, folder: Path) -> str:
    """Return the command that runs a trial of a campaign again, bit for bit.

    It is a plain run of the tree where that is enough: without pushes, a script and changed conditions.

    Args:
        trial: it.
        plan: the campaign's.
        folder: the campaign's.
    """
    altered = {name: value for name, value in trial.given.items() if not name.startswith(f"{SET}.")}
    if plan.script or trial.dry or any(_AS_IT_IS.get(name) != value for name, value in altered.items()):
        return shlex.join(["humanoid-bt", "campaign", "rerun", relative(folder), str(trial.number)])
    root = relative(Path(plan.workspace)) if plan.workspace else "."
    where = ["--workspace", root] if root != "." else []
    words = [
        "humanoid-bt",
        "run",
        trial.tree,
        "--robot",
        trial.robot,
        "--scene",
        trial.scene,
        "--seed",
        str(trial.seed),
    ]
    for name, value in trial.part(SET).items():
        words += ["--set", f"{name}={value if isinstance(value, str) else as_line(value)}"]
    for source in plan.sources:
        words += ["--perception", source]
    if trial.duration is not None:
        words += ["--duration", repr(trial.duration).removesuffix(".0")]
    return shlex.join(words + where)
