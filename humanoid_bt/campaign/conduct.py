"""Conducting a campaign: every trial that is not done yet, then recordings of some of each cause of failure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from humanoid_bt.campaign.causes import Cause, causes
from humanoid_bt.campaign.result import Explained
from humanoid_bt.campaign.store import RECORDINGS, Store, recorded_as
from humanoid_bt.campaign.summary import Summary
from humanoid_bt.campaign.table import Row, Table
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.workers import Done
from humanoid_bt.core.errors import UserError


class Runners(Protocol):
    """Whoever runs trials: processes of this machine, or those of many."""

    def run(self, tasks: Iterable[Task]) -> Iterator[Done]:
        """Yield tasks as they are done, each once."""

    def close(self) -> None:
        """Leave nothing running."""


class Progress:
    """Is told how a campaign goes; this one does nothing with it."""

    def trial(self, done: Done) -> None:
        """A trial is done."""

    def explaining(self, count: int) -> None:
        """All trials are done; so many of the failures are run again and recorded."""

    def explained(self, done: Done) -> None:
        """One of them is."""


def conduct(store: Store, runners: Runners, recordings: int, progress: Progress) -> None:
    """Run what is not done yet, and keep what comes of it.

    Args:
        store: where it is kept.
        runners: who runs trials.
        recordings: how many failures of each cause are recorded and explained.
        progress: is told how it goes.

    Raises:
        UserError: a trial cannot be run, for a mistake in a file or a value.
        Unwritable: the results cannot be written any more.
        HumanoidBtError: no process can be started.
    """
    for done in runners.run(Task(trial) for trial in store.plan.trials if not store.has(trial.number)):
        store.add(done)
        progress.trial(done)
    table, known = Table.of(store.plan, store.results), store.explained
    again = [row for cause in causes(table) for row in _chosen(cause, recordings) if row.trial.number not in known]
    if not again:
        return
    progress.explaining(len(again))
    before = {row.trial.number: row.result for row in again}
    for done in runners.run([Task(row.trial, recording_of(store.folder, row)) for row in again]):
        number = done.task.trial.number
        explained = done.explained or Explained("", done.result.reason)
        store.explain(number, replace(explained, same=done.result == before[number]))
        progress.explained(done)


def summary(store: Store) -> Summary:
    """Write the tables of a campaign; return what it says so far.

    Raises:
        Unwritable: the tables cannot be written.
    """
    return Summary(store.write_tables(), store.explained)


def trial_of(table: Table, text: str) -> Row:
    """Return a trial of a campaign by its number or its id.

    Raises:
        UserError: there is none, or it is not done.
    """
    for row in table.rows:
        if text in (str(row.trial.number), row.trial.id):
            return row
    hint = "valid: what the columns trial and id of results.csv hold"
    raise UserError(f"no trial {text!r} of this campaign is done", hint=hint)


def _chosen(cause: Cause, recordings: int) -> tuple[Row, ...]:
    """Return which trials of a cause are recorded: each of another seed, as long as there are others."""
    if not cause.can_be_recorded:
        return ()
    often: Counter[int] = Counter()
    turns = []
    for row in cause.rows:
        turns.append((often[row.trial.seed], row.trial.number, row))
        often[row.trial.seed] += 1
    return tuple(row for _, _, row in sorted(turns, key=lambda turn: turn[:2])[:recordings])


def recording_of(folder: Path, row: Row) -> str:
    """Return where a trial of the campaign in a folder is recorded; its run overwrites what is there."""
    return str((folder / RECORDINGS / recorded_as(row.trial)).absolute())
