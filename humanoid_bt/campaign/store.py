"""The folder of a campaign: what it runs, what came of it so far, and what is made of that."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from humanoid_bt.campaign.digests import changes
from humanoid_bt.campaign.journal import Entry, Journal, Unwritable, read_journal
from humanoid_bt.campaign.plan import Plan
from humanoid_bt.campaign.result import Cost, Explained, Result
from humanoid_bt.campaign.table import Table, costs_csv
from humanoid_bt.campaign.trial import Trial
from humanoid_bt.campaign.workers import Done
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.files.whole import write_whole

RESULTS, COSTS = "results.csv", "wall_clock.csv"
_ABOUT, _JOURNAL, _EXPLAINED = "campaign.json", "journal.jsonl", "explained.jsonl"
RECORDINGS = "recordings"
_LOGS = "workers"
_MOST = 3  # changes that are listed


class Store:
    """The folder of a campaign, while it is written; nobody else writes it meanwhile.

    Args:
        folder: made if it is not there.
        plan: what the campaign runs.
        resume: go on with what is there.

    Attributes:
        folder: it.
        plan: the same as given.
        results: what came of trials, by number.
        explained: what recordings of trials show, by number.

    Raises:
        UserError: there is a campaign or something else already, or with ``resume`` another one, or a damaged one.
        Unwritable: it cannot be made.
    """

    def __init__(self, folder: Path, plan: Plan, resume: bool) -> None:
        self.folder, self.plan = folder, plan
        with self._writing():
            _refuse(folder, plan, resume)
            for part in (folder, self.logs, self.recordings):
                part.mkdir(parents=True, exist_ok=True)
        self._stack = contextlib.ExitStack()
        with self._stack as stack:
            self._journal = stack.enter_context(Journal(folder / _JOURNAL))
            self._explanations = stack.enter_context(Journal(folder / _EXPLAINED))
            self.results = _results(folder, self._journal.entries)
            with _undamaged(folder / _JOURNAL):
                self._costs = {number: Cost(**entry["cost"]) for number, entry in self._journal.entries.items()}
            with _undamaged(folder / _EXPLAINED):
                self.explained = {number: Explained(**entry) for number, entry in self._explanations.entries.items()}
            if not self._journal.entries:
                self.write(_ABOUT, f"{json.dumps(plan.to_dict(), indent=1)}\n".encode())
            self._stack = stack.pop_all()

    @property
    def logs(self) -> Path:
        """Where processes say what goes wrong."""
        return self.folder / _LOGS

    @property
    def recordings(self) -> Path:
        """Where recordings of failures are."""
        return self.folder / RECORDINGS

    def has(self, number: int) -> bool:
        """Return whether a trial is done."""
        return number in self.results

    def add(self, done: Done) -> None:
        """Keep what came of a trial.

        Raises:
            Unwritable: it cannot be written.
        """
        number = done.task.trial.number
        self._journal.add(number, {"result": done.result.to_dict(), "cost": asdict(done.cost)})
        self.results[number], self._costs[number] = done.result, done.cost

    def explain(self, number: int, explained: Explained) -> None:
        """Keep what the recording of a trial shows; raises as :meth:`add`."""
        self._explanations.add(number, asdict(explained))
        self.explained[number] = explained

    def write(self, name: str, content: bytes) -> None:
        """Write a file of the folder, whole or not at all.

        Raises:
            Unwritable: it cannot be written.
        """
        with self._writing():
            write_whole(self.folder / name, content)

    def write_tables(self) -> Table:
        """Write and return the table of all results so far, and what they took on the wall clock; raises as write."""
        table = Table.of(self.plan, self.results)
        self.write(RESULTS, table.csv())
        self.write("results.parquet", table.parquet())
        self.write(COSTS, costs_csv(self.plan, self._costs))
        return table

    @property
    def share_simulating(self) -> float:
        """Share of the time of all trials in which a robot was simulated, from 0 to 1."""
        wall = sum(cost.wall for cost in self._costs.values())
        return sum(cost.simulating for cost in self._costs.values()) / wall if wall else 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            why = "Not a directory" if isinstance(error, FileExistsError) else error.strerror
            raise Unwritable(f"{relative(self.folder)!r} cannot be written: {why}") from error


def recorded_as(trial: Trial) -> str:
    """Return the name of the file to which a trial is recorded."""
    return f"{trial.number:06}-{trial.id}.rrd"


def read_results(folder: Path) -> Table:
    """Return what came of a campaign so far.

    Raises:
        UserError: there is none in the folder, or it is damaged.
    """
    plan = _plan(folder)
    if plan is None:
        hint = "valid: the folder of a campaign, which has campaign.json"
        raise UserError(f"there is no campaign in {relative(folder)!r}", hint=hint)
    return Table.of(plan, _results(folder, read_journal(folder / _JOURNAL)))


def _refuse(folder: Path, plan: Plan, resume: bool) -> None:
    """See that nothing else is in a folder than the campaign that goes on."""
    there = _plan(folder)
    if there is None:
        known = (_JOURNAL, _EXPLAINED, _LOGS, RECORDINGS)  # there before campaign.json is
        if folder.is_dir() and any(path.name not in known and path.name[0] != "." for path in folder.iterdir()):
            raise UserError(f"{relative(folder)!r} is there already and holds no campaign", hint="choose another --out")
    elif not read_journal(folder / _JOURNAL):
        return  # it never came to a trial
    elif not resume:
        hint = "--resume goes on with it; or choose another --out"
        raise UserError(f"there is a campaign in {relative(folder)!r} already", hint=hint)
    elif changes := list(_changes(*(json.loads(json.dumps(one.to_dict())) for one in (there, plan)))):
        hint = "what was run differently does not belong into one table: begin anew with another --out"
        few = ", ".join(changes[:_MOST]) + f" and {len(changes) - _MOST} more" * (len(changes) > _MOST)
        raise UserError(f"the campaign in {relative(folder)!r} is another one: {few}", hint=hint)


def _changes(before: dict[str, Any], after: dict[str, Any]) -> Iterator[str]:
    """Yield in which respects two plans differ, but for what is only said."""
    for name, value in before.items():
        if name == "files":
            yield from (f"{path} has changed" for path in changes(value, after[name]))
        elif name not in ("name", "description", "workspace") and value != after[name]:
            yield f"its {name} are others" if name.endswith("s") else f"its {name} is another"


def _plan(folder: Path) -> Plan | None:
    """Return what the campaign of a folder runs, None if there is none."""
    path = folder / _ABOUT
    try:
        with _undamaged(path):
            return Plan.from_dict(json.loads(path.read_bytes()))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise UserError(f"{relative(path)!r} cannot be read: {error.strerror}") from error


def _results(folder: Path, entries: Mapping[int, Entry]) -> dict[int, Result]:
    """Return what the journal of a folder says came of trials, by number."""
    with _undamaged(folder / _JOURNAL):
        return {number: Result(**entry["result"]) for number, entry in entries.items()}


@contextlib.contextmanager
def _undamaged(path: Path) -> Iterator[None]:
    """Tell a file by name from which nothing can be made."""
    try:
        yield
    except (ValueError, LookupError, TypeError) as error:
        raise UserError(f"{relative(path)!r} is damaged, or of another version") from error
