"""What a campaign says when it is done: how often it succeeds, how long that takes, where and why it does not."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from humanoid_bt.campaign.causes import Cause, causes
from humanoid_bt.campaign.result import CRASHED, HUNG, Explained
from humanoid_bt.campaign.statistics import QUANTILES, Interval, Rate, Spread
from humanoid_bt.campaign.table import Row, Table
from humanoid_bt.campaign.trial import PUSH
from humanoid_bt.core.plain import plain
from humanoid_bt.core.units import readable_apart, readable_ranges

TIME = "time"
"""The quantity that every run has."""

_NO_RESULT = ("error", HUNG, CRASHED)

_BINS = 4  # into which the values of what was drawn are sorted, as many trials in each


@dataclass(frozen=True)
class Level:
    """The trials with one value of something, or with those of a range.

    Attributes:
        text: the value, as people read it.
        success: how many of them succeeded.
    """

    text: str
    success: Rate


@dataclass(frozen=True)
class Summary:
    """What a campaign says.

    Attributes:
        table: of its results.
        explained: what recordings show, by the number of their trial.
    """

    table: Table
    explained: Mapping[int, Explained]

    @property
    def planned(self) -> int:
        """How many trials there are to be."""
        return len(self.table.plan)

    @property
    def done(self) -> int:
        """How many are done."""
        return len(self.table.rows)

    @cached_property
    def success(self) -> Rate:
        """How many succeeded."""
        return _success(self.table.rows)

    @cached_property
    def outcomes(self) -> Mapping[str, int]:
        """How many ended in which way, the most frequent first."""
        return dict(Counter(row.result.outcome for row in self.table.rows).most_common())

    @property
    def without_result(self) -> int:
        """How many say nothing of the robot: a skill raised an exception, the process died, or the trial hung."""
        return sum(self.outcomes.get(outcome, 0) for outcome in _NO_RESULT)

    @property
    def fell(self) -> int:
        """In how many the robot fell."""
        return sum(row.result.fell for row in self.table.rows)

    @property
    def bumped(self) -> int:
        """In how many it touched something that no hand was sent to."""
        return sum(bool(row.result.bumped) for row in self.table.rows)

    @cached_property
    def missed(self) -> Mapping[str, int]:
        """What was to happen in every trial, and in how many it did not: the most frequent first."""
        missed = [what for row in self.table.rows for what in row.result.missed.split(", ") if what]
        return dict(Counter(missed).most_common())

    @property
    def incomplete(self) -> int:
        """In how many something that was to happen did not."""
        return sum(bool(row.result.missed) for row in self.table.rows)

    @cached_property
    def spreads(self) -> Mapping[str, tuple[str, Spread]]:
        """The quantities of the trials that succeeded, each with its unit: the time, and what skills reported."""
        good = [row.result for row in self.table.rows if row.result.succeeded]
        found = {TIME: ("s", Spread.of([result.time for result in good]))}
        for name, unit in self.table.values.items():
            numbers = [number for result in good if (number := _number(result.values.get(name))) is not None]
            if numbers and name != TIME:
                found[name] = (unit, Spread.of(numbers))
        return found

    @cached_property
    def causes(self) -> list[Cause]:
        """Why trials failed, the most frequent cause first."""
        return causes(self.table, self.explained)

    @cached_property
    def levels(self) -> Mapping[str, Sequence[Level]]:
        """For each column in which trials differ beside their seed, how those with each of its values went.

        Those in which a push never happened say nothing of its numbers.
        """
        found = {name: list(self._levels(name)) for name in self.table.plan.varies}
        return {name: levels for name, levels in found.items() if levels}

    def _levels(self, name: str) -> Iterator[Level]:
        factor = next((factor for factor in self.table.plan.factors if factor.name == name), None)
        unit = factor.unit if factor else ""
        of, _, number = name.rpartition(".")[0].partition(".")
        rows = [row for row in self.table.rows if of != PUSH or not row.result.has_missed(f"{PUSH} {number}")]
        cells = [(self.table.cells(row)[name], row) for row in rows]
        if factor is not None and factor.ends is not None:
            cells.sort(key=lambda cell: cell[0])
            bins = [cells[number * len(cells) // _BINS : (number + 1) * len(cells) // _BINS] for number in range(_BINS)]
            parts = [part for part in bins if part]
            texts = readable_ranges([(part[0][0], part[-1][0]) for part in parts], unit)
        else:
            values = factor.values if factor else dict.fromkeys(value for value, _ in cells)
            parts = [part for value in values if (part := [cell for cell in cells if cell[0] == value])]
            texts = readable_apart([part[0][0] for part in parts], unit)
        for text, part in zip(texts, parts, strict=True):
            yield Level(text, _success([row for _, row in part]))

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return {
            "name": self.table.plan.name,
            "title": self.table.plan.title,
            "planned": self.planned,
            "done": self.done,
            "success": _rate(self.success),
            "fell": self.fell,
            "bumped": self.bumped,
            "missed": dict(self.missed),
            "outcomes": dict(self.outcomes),
            "spreads": {
                name: {"unit": unit, **{key: plain(spread.quantile(share)) for key, share in QUANTILES.items()}}
                for name, (unit, spread) in self.spreads.items()
            },
            "levels": {
                name: [{"value": level.text, "success": _rate(level.success)} for level in levels]
                for name, levels in self.levels.items()
            },
            "causes": [
                {
                    **{"outcome": cause.outcome, "node": cause.node, "reason": cause.reason},
                    **{"count": len(cause.rows), "trials": [row.trial.number for row in cause.rows]},
                    "explained": cause.headlines,
                }
                for cause in self.causes
            ],
        }


def percent(share: float) -> str:
    """Return a rate as people read it, with digits behind the point where they tell something: 100 % is all."""
    digits = 1
    while float(text := f"{100 * share:.{digits}f}") in (0, 100) and share not in (0, 1):
        digits += 1
    return f"{text.removesuffix('.0')} %"


def between(interval: Interval) -> str:
    """Return an interval of a rate as people read it."""
    return f"{percent(interval.low).removesuffix(' %')} to {percent(interval.high)}"


def _success(rows: Sequence[Row]) -> Rate:
    return Rate(sum(row.result.succeeded for row in rows), len(rows))


def _rate(rate: Rate) -> dict[str, Any]:
    return {"count": rate.count, "of": rate.of, "share": plain(rate.share), "interval": list(rate.interval)}


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None
