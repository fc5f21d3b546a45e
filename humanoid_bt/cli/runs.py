"""Which run is meant by a command that reaches one from another terminal. Nothing heavy is imported here."""

from __future__ import annotations

from humanoid_bt.core.errors import UserError
from humanoid_bt.link.run_folder import RunFolder, RunInfo, live_runs, lockstep_root

FoundRun = tuple[RunFolder, RunInfo]


def robots(run_id: str | None) -> list[FoundRun]:
    """Return the runs that can be stopped from outside, or the one of an id.

    Raises:
        UserError: there is none.
    """
    return _chosen(live_runs(), run_id, "robot", "humanoid-bt run TREE --mode realtime starts one")


def one_robot(run_id: str | None, command: str) -> FoundRun:
    """Return the run that can be stopped from outside.

    Raises:
        UserError: there is none, or several and no id.
    """
    return _one(robots(run_id), f"humanoid-bt {command}", "robots")


def one_tree(run_id: str | None) -> FoundRun:
    """Return the run whose tree can be watched, in any mode.

    Raises:
        UserError: there is none, or several and no id.
    """
    runs = _chosen([*live_runs(), *live_runs(lockstep_root())], run_id, "tree", "humanoid-bt run TREE starts one")
    return _one(runs, "humanoid-bt show --live", "trees")


def _chosen(runs: list[FoundRun], run_id: str | None, what: str, hint: str) -> list[FoundRun]:
    if run_id is None:
        if not runs:
            raise UserError(f"no {what} is running", hint=hint)
        return runs
    chosen = [run for run in runs if run[1].run_id == run_id]
    if not chosen:
        known = "running: " + (", ".join(info.run_id for _, info in runs) or "none")
        raise UserError(f"no run {run_id!r} is running", hint=known)
    return chosen


def _one(runs: list[FoundRun], command: str, what: str) -> FoundRun:
    if len(runs) > 1:
        lines = "\n    ".join(f"{command} --run {info.run_id}   # {info.tree}" for _, info in runs)
        raise UserError(f"{len(runs)} {what} are running: say which", hint=lines)
    return runs[0]
