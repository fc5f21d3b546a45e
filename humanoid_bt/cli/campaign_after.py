"""What is done with campaigns that are over: two of them compared, one of their trials run again."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from humanoid_bt.campaign.compare import Comparison, Pair
from humanoid_bt.campaign.compare import compare as compared
from humanoid_bt.campaign.conduct import recording_of, trial_of
from humanoid_bt.campaign.digests import changes, digests, find
from humanoid_bt.campaign.plan import Plan
from humanoid_bt.campaign.report_markdown import comparison_markdown
from humanoid_bt.campaign.result import Result
from humanoid_bt.campaign.stage_trials import Setup, make
from humanoid_bt.campaign.store import read_results
from humanoid_bt.campaign.summary import between, percent
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.words import chance, changed, verdict
from humanoid_bt.cli.output import columns, print_lines
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.report import OUTCOMES, ExitCode, aligned

_MOST = 12  # seeds that are listed
_WORSE = 1


def compare(arguments: argparse.Namespace) -> int:
    """Print how two campaigns differ; return the exit code."""
    one, other = (read_results(Path(folder)) for folder in arguments.what[1:])
    found = compared(one, other)
    if arguments.out is not None:
        _write(arguments.out, comparison_markdown(found))
    if arguments.json:
        print(json.dumps(found.to_dict(), indent=1))
    elif arguments.out is not None:
        print(f"{arguments.out}: {verdict(found)}")
    else:
        _print(found, arguments.what[1:])
    return _WORSE if found.worse else ExitCode.SUCCESS


def rerun(arguments: argparse.Namespace) -> int:
    """Run a trial of a campaign again, record and explain it; return the exit code of such a run."""
    folder, name = Path(arguments.what[1]), arguments.what[2]
    table = read_results(folder)
    row = trial_of(table, name)
    file = recording_of(folder, row)
    plan = table.plan
    there = plan.workspace if Path(plan.workspace).is_dir() else None  # results may have come from another machine
    workspace = Workspace(arguments.workspace or there or None)
    run = make(Setup.of(plan, str(workspace.root)))
    result, explained, _ = run(Task(row.trial, file))
    given = ", ".join(f"{name} {value}" for name, value in row.trial.given.items())
    print(
        f"trial {row.trial.number}: {row.trial.tree} in {row.trial.scene}, seed {row.trial.seed}"
        + f", {given}" * bool(given)
    )
    print(f"{result.outcome}: {result.reason}")
    rows = [("again", _again(row.result, result)), ("recording", relative(Path(file)))]
    if result != row.result and (names := _changed(plan, workspace)):
        rows.insert(1, ("changed", ", ".join(names)))
    if explained is not None and not result.succeeded:
        rows.insert(0, ("cause", explained.headline))
    print_lines(aligned(rows))
    return OUTCOMES.get(result.outcome, ExitCode.FAILURE)


def _again(before: Result, after: Result) -> str:
    """Return how a trial went when it was run again."""
    if after == before:
        return "as it was, bit for bit"
    if after.outcome == before.outcome:
        return "not bit for bit as it was"
    return f"it was another way before: {before.outcome}"


def _changed(plan: Plan, workspace: Workspace) -> list[str]:
    """Return which files hold something else than when a campaign began."""
    return changes(plan.files, digests(find(plan.files, workspace)))


def _print(found: Comparison, folders: Sequence[str]) -> None:
    print_lines(columns(zip("AB", map(str, folders), strict=True)))
    left = f"; without a partner {found.unpaired[0]} of A and {found.unpaired[1]} of B" if any(found.unpaired) else ""
    print(f"\n{verdict(found)}")
    rows = [("pairs", f"{found.pairs} by {', '.join(found.by)}{left}"), *_success(found)]
    rows += [(one.name.replace("_", " "), changed(one)) for one in found.quantities]
    print_lines(aligned(rows))
    if found.differs:
        print("\ndiffers")
        print_lines(columns([(name, f"{before} → {after}") for name, before, after in found.differs], indent=2))
    if causes := [one for one in found.causes if one.before != one.after]:
        print("\nfailures")
        print_lines(columns([(f"{one.before} → {one.after}", one.text) for one in causes], indent=2))


def _success(found: Comparison) -> Iterator[tuple[str, str]]:
    change = found.success
    before, after = (f"{percent(rate.share)} ({between(rate.interval)})" for rate in (change.before, change.after))
    yield "success", f"{before} → {after} ({chance(change.p)})"
    yield "gained", _seeds(change.gained)
    yield "lost", _seeds(change.lost)


def _seeds(pairs: Sequence[Pair]) -> str:
    """Return how many pairs these are, and the seeds of the first ones."""
    seeds = ", ".join(str(pair[0].trial.seed) for pair in pairs[:_MOST]) + ", …" * (len(pairs) > _MOST)
    return f"{len(pairs)}" + f": seeds {seeds}" * bool(pairs)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UserError(f"the comparison cannot be written to {str(path)!r}: {error.strerror}") from error
