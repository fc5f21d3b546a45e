"""Which run is meant by a command that reaches one from another terminal. Nothing heavy is imported here."""

from __future__ import annotations

from humanoid_bt.core.errors import UserError
from humanoid_bt.link.run_folder import RunFolder, RunInfo, all_runs, in_lockstep

FoundRun = tuple[RunFolder, RunInfo]


def found_runs(run_id: str | None) -> list[FoundRun]:
    """Return the runs that go on, in either mode, or the one of an id.

    Raises:
        UserError: there is none.
    """
    runs = all_runs()
    if run_id is None:
        if not runs:
            raise UserError("no robot is running", hint="humanoid-bt run TREE starts one")
        return runs
    chosen = [run for run in runs if run[1].run_id == run_id]
    if not chosen:
        known = "running: " + (", ".join(info.run_id for _, info in runs) or "none")
        raise UserError(f"no run {run_id!r} is running", hint=known)
    return chosen


def one_run(run_id: str | None, command: str) -> FoundRun:
    """Return the run that goes on, or the one of an id.

    Raises:
        UserError: there is none, or several and no id.
    """
    runs = found_runs(run_id)
    if len(runs) > 1:
        lines = "\n    ".join(f"humanoid-bt {command} --run {run[1].run_id}   # {titled(run)}" for run in runs)
        raise UserError(f"{len(runs)} robots are running: say which", hint=lines)
    return runs[0]


def titled(run: FoundRun) -> str:
    """Return what runs on what, and in which mode."""
    folder, info = run
    return f"{info.tree} on {info.robot}, {'lockstep' if in_lockstep(folder) else 'realtime'}"
