"""Running a recorded run again from its inputs: the whole of it, or what its tree would decide on what it saw."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, Literal, get_args

from humanoid_bt.checking.check import load_checked
from humanoid_bt.core.errors import UserError, nearest, relative, resolved
from humanoid_bt.core.plain import plain
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.record.reading import FlightLog, read_flight
from humanoid_bt.review import staged
from humanoid_bt.review.compare_run import Parting
from humanoid_bt.review.decision_replay import decide_again
from humanoid_bt.review.recorded_files import RecordedFiles, lay_out, started_with
from humanoid_bt.review.recorded_run import recorded_run
from humanoid_bt.tree.ticking.executor import NodeError
from humanoid_bt.tree.tree import Tree

Files = Literal["recorded", "current"]
"""Which trees, skills, robots and scenes a replay uses: those of the recording, or those that are there now."""


@dataclass(frozen=True)
class Replay:
    """What came of a replay.

    Attributes:
        recording: the file.
        whole: whether control and the simulated robot ran again too; else only decision, on what it had seen.
        difference: where it first differs from the recording, None if it does not.
        ticks: how many were run again.
        duration: simulated time of them [s].
        speed: that time over the time it took.
        outcome: how the tree ended this time: success, failure, error, stopped, interrupted or unfinished.
        reason: why, in words.
        recorded_outcome, recorded_reason: how it ended when it was recorded, "" if nobody knows.
        notes: what the comparison leaves out, and why.
    """

    recording: str
    whole: bool
    difference: Parting | None
    ticks: int
    duration: float
    speed: float
    outcome: str
    reason: str
    recorded_outcome: str
    recorded_reason: str
    notes: list[str] = field(default_factory=list)

    @property
    def identical(self) -> bool:
        """Whether it did what was recorded, to the bit."""
        return self.difference is None

    @property
    def passes(self) -> bool:
        """Whether nothing went wrong this time: a whole run succeeded, or decision neither failed nor raised."""
        return self.outcome == "success" if self.whole else self.outcome not in ("failure", "error")

    def to_dict(self) -> dict[str, Any]:
        """Return it as data for JSON."""
        difference = plain(self.difference._asdict()) if self.difference is not None else None
        return {**plain(asdict(self)), "difference": difference, "identical": self.identical, "passes": self.passes}

    def __str__(self) -> str:
        what = "run" if self.whole else "decisions"
        found = f"identical {what}" if self.identical else f"the {what} differ{'s' if self.whole else ''}"
        speed = f"{self.speed:.0f}" if self.speed >= 1 else f"{self.speed:.1g}"
        lines = [f"{found}: {self.ticks} ticks, {self.duration:.2f} s, {speed}x real time"]
        if self.difference is not None:
            lines.append(f"  first difference  {self.difference}")
        lines.append(f"  recorded          {self.recorded_outcome or 'no end'}: {self.recorded_reason or 'cut short'}")
        lines.append(f"  now               {self.outcome}: {self.reason}")
        lines += [f"  note              {note}" for note in self.notes]
        return "\n".join(lines)


def replay(
    recording: str | PathLike[str],
    *,
    tree: str | PathLike[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    files: Files = "recorded",
    workspace: str | PathLike[str] | Workspace | None = None,
) -> Replay:
    """Run a recorded run again from its inputs, and compare.

    A lockstep run runs again as a whole: the tree, control, the simulated robot. Of a run in realtime mode, and
    wherever another tree or other parameters are asked for, decision runs again on the states and percepts that were
    recorded: what *would* have been decided. Skills of the recording are run: replay only recordings of people you
    trust.

    Args:
        recording: its file.
        tree: another tree, its name or file; then with the current skills.
        parameters: other values for the tree's parameters, or text as after ``--set``.
        files: "current" for the trees, skills, robots and scenes that are there now, under the same names.
        workspace: where they are looked up then; else the one that the run was started in.

    Raises:
        UserError: the recording cannot be read or lacks a part, or what it was made of is not there; the tree has
            mistakes; a test did to the run what a replay cannot.
        NodeError: a skill raised an exception in ``setup``.
    """
    if files not in get_args(Files):
        raise UserError(f"'files' cannot be {files!r}", hint=nearest(str(files), get_args(Files)))
    log = read_flight(recording)
    run = recorded_run(log)
    _refuse_staged(log)
    _refuse_incomplete(log)
    with tempfile.TemporaryDirectory(prefix="humanoid-bt-replay-") as folder, _only_recorded(resolved(Path(folder))):
        now = tree is not None or files == "current"
        found = _current(log, workspace) if now else lay_out(log.setup, Path(folder))
        whole = run.mode == "lockstep" and tree is None and not parameters
        begin = time.perf_counter()
        if whole:
            from humanoid_bt.review.run_replay import run_again  # noqa: PLC0415 (control, which takes a while)

            done = run_again(log, run, found)
        else:
            given = {**({} if tree is not None else run.given), **(parameters or {})}  # another tree has others
            loaded = _load(found, tree, given)
            begin = time.perf_counter()
            done = decide_again(log, run, loaded, found.robot)
        took = time.perf_counter() - begin
    damaged = [f"{log.damaged} blocks of the recording are damaged"] if log.damaged else []
    return Replay(
        recording=relative(log.path),
        whole=whole,
        difference=done.difference,
        ticks=done.ticks,
        duration=done.duration,
        speed=done.duration / max(took, 1e-9),
        outcome=done.outcome,
        reason=done.reason,
        recorded_outcome=run.outcome,
        recorded_reason=run.reason,
        notes=[*done.notes, *damaged],
    )


@contextmanager
def _only_recorded(folder: Path) -> Iterator[None]:
    """Say of a node that does not find a file where those of the recording are laid out that it is none of them.

    Raises:
        UserError: a node asked for such a file in ``setup``.
    """
    try:
        yield
    except NodeError as error:
        name = getattr(error.error, "filename", None)
        if not (isinstance(error.error, FileNotFoundError) and name and Path(name).is_relative_to(folder)):
            raise
        message = f"the node {error.path!r} reads {str(Path(name).relative_to(folder))!r}, which is not recorded"
        raise UserError(message, hint="replay it with the files that are there now: --current") from error


def _refuse_staged(log: FlightLog) -> None:
    """Refuse a run to which a test did something: no replay can do it, and without it another run comes of it.

    Raises:
        UserError: it is one.
    """
    if lines := staged.told(log.setup):
        did = "; ".join(lines[:3]) + ("; ..." if len(lines) > 3 else "")
        message = f"{relative(log.path)!r} is of a test that staged what happened, which a replay cannot do: {did}"
        raise UserError(message, hint="run the test again: with the same seed it does the same, to the bit")


def _refuse_incomplete(log: FlightLog) -> None:
    """Refuse a recording without its beginning, or with a gap: what it lacks cannot be compared.

    Raises:
        UserError: it is one.
    """
    if log.missing:
        lacks = ", ".join(f"part {number}" for number in log.missing)
        message = f"the recording {relative(log.path)!r} cannot be replayed without its {lacks}"
        raise UserError(message, hint="put all of its files into one folder, with the names that they had")


def _current(log: FlightLog, workspace: str | PathLike[str] | Workspace | None) -> RecordedFiles:
    """Return the files of the run as they are now.

    Raises:
        UserError: they are not there any more.
    """
    names = started_with(log.setup)
    where = workspace if isinstance(workspace, Workspace) else Workspace(workspace or log.setup["workspace"])
    return RecordedFiles(where, *(_there(where, name) for name in names))


def _there(workspace: Workspace, name: str) -> Path:
    """Return the file of this name in a workspace.

    Raises:
        UserError: there is none.
    """
    for root in workspace.layers:
        if (root / name).is_file():
            return root / name
    hint = "replay it with the files of the recording, or give --workspace DIR (workspace= in Python)"
    raise UserError(f"{name!r} of the run is not in {relative(workspace.root)!r}", hint=hint)


def _load(found: RecordedFiles, tree: str | PathLike[str] | None, given: Mapping[str, Any]) -> Tree:
    path = found.tree if tree is None else found.workspace.find_tree(str(tree))
    return load_checked(path, found.workspace, given, robot=str(found.robot), scene=str(found.scene))
