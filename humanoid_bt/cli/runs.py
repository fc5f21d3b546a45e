"""Which run is meant by a command that reaches one from another terminal. Nothing heavy is imported here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from humanoid_bt.core.errors import UserError
from humanoid_bt.link.run_folder import RunFolder, RunInfo, all_runs, in_lockstep
from humanoid_bt.link.segment import LinkError

FoundRun = tuple[RunFolder, RunInfo]
_Run = TypeVar("_Run")


def found_runs(run_id: str | None) -> list[FoundRun]:
    """Return the runs that go on, in either mode, or the one of an id.

    Raises:
        UserError: there is none.
    """
    runs = chosen(all_runs(), run_id, lambda run: run[1].run_id)
    if not runs:
        raise no_robot()
    return runs


def chosen(runs: Sequence[_Run], run_id: str | None, id_of: Callable[[_Run], str]) -> list[_Run]:
    """Return all runs, or the one whose id is given or begins so.

    Raises:
        UserError: none or several begin so.
    """
    if run_id is None:
        return list(runs)
    same = [run for run in runs if id_of(run) == run_id] or [run for run in runs if id_of(run).startswith(run_id)]
    if len(same) == 1:
        return same
    if not same:
        known = "running: " + (", ".join(map(id_of, runs)) or "none")
        raise UserError(f"no run {run_id!r} is running", hint=known)
    raise UserError(f"{len(same)} runs begin with {run_id!r}", hint="valid: " + ", ".join(map(id_of, same)))


def one_run(run_id: str | None, command: str) -> FoundRun:
    """Return the run that goes on, or the one of an id.

    Raises:
        UserError: there is none, or several and no id.
    """
    runs = found_runs(run_id)
    if len(runs) > 1:
        lines = "\n    ".join(f"humanoid-bt {command} --run {run[1].run_id}   # {titled(*run)}" for run in runs)
        raise UserError(f"{len(runs)} robots are running: say which", hint=lines)
    return runs[0]


def no_robot() -> UserError:
    """Return what is said where nothing runs."""
    return UserError("no robot is running", hint="humanoid-bt run TREE starts one")


def titled(folder: RunFolder, info: RunInfo) -> str:
    """Return what runs on what, and in which mode."""
    return f"{info.tree} on {info.robot}, {'lockstep' if in_lockstep(folder) else 'realtime'}"


def identity(folder: RunFolder) -> str:
    """Return what runs in a folder and its id: all that can be known of it, whatever is damaged."""
    try:
        return f"{titled(folder, folder.info)} ({folder.folder.name})"
    except LinkError:
        return f"a run that does not say what it is ({folder.folder.name})"
