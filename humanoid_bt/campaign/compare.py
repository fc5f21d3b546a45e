"""Two campaigns compared trial by trial: what got better or worse, and whether that is more than chance."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from humanoid_bt.campaign.causes import common, pattern
from humanoid_bt.campaign.statistics import CHANCE, Interval, Rate, Spread, binomial_p, holm, median_interval
from humanoid_bt.campaign.summary import TIME
from humanoid_bt.campaign.table import Row, Table
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.plain import plain
from humanoid_bt.files.document import as_line

Pair = tuple[Row, Row]


@dataclass(frozen=True)
class SuccessChange:
    """How success differs.

    Attributes:
        before, after: of the pairs.
        lost: pairs of which only the first succeeded.
        gained: pairs of which only the second did.
        p: how likely so uneven a change is by chance alone (McNemar's exact test).
    """

    before: Rate
    after: Rate
    lost: Sequence[Pair]
    gained: Sequence[Pair]
    p: float


@dataclass(frozen=True)
class QuantityChange:
    """How a quantity differs in the pairs that both succeeded.

    Attributes:
        name: of the quantity.
        unit: its SI unit, "" for none.
        before, after: its median.
        difference: median of what was added to it in a pair.
        interval: of that median.
        larger, smaller: in how many pairs it grew and shrank.
        p: how likely that is by chance alone (sign test), raised for the number of quantities that are compared.
    """

    name: str
    unit: str
    before: float
    after: float
    difference: float
    interval: Interval
    larger: int
    smaller: int
    p: float


@dataclass(frozen=True)
class CauseChange:
    """How often something made trials fail, before and after."""

    text: str
    before: int
    after: int


@dataclass(frozen=True)
class Comparison:
    """How two campaigns differ.

    Attributes:
        pairs: how many trials of both are of the same seed, and of the same of all else that varies.
        unpaired: how many of the first and of the second have no partner.
        by: the columns by which they are paired.
        differs: what is different in all of them: column, before, after.
        success: how success differs.
        quantities: how the time differs, and what skills report.
        causes: how the causes of failures differ, of all trials.
    """

    pairs: int
    unpaired: tuple[int, int]
    by: Sequence[str]
    differs: Sequence[tuple[str, str, str]]
    success: SuccessChange
    quantities: Sequence[QuantityChange]
    causes: Sequence[CauseChange]

    @property
    def better(self) -> list[str]:
        """What got better beyond chance."""
        return self._beyond(worse=False)

    @property
    def worse(self) -> list[str]:
        """What got worse beyond chance."""
        return self._beyond(worse=True)

    def _beyond(self, worse: bool) -> list[str]:
        # Of times, and of what skills report, errors and distances, more is worse.
        change = self.success
        more, fewer = (change.lost, change.gained) if worse else (change.gained, change.lost)
        found = ["success"] if change.p < CHANCE and len(more) > len(fewer) else []
        return found + [
            one.name
            for one in self.quantities
            if one.p < CHANCE and (one.larger > one.smaller if worse else one.larger < one.smaller)
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        change = self.success
        numbers = {
            name: [pair[0].trial.seed for pair in pairs]
            for name, pairs in (("lost", change.lost), ("gained", change.gained))
        }
        rates = {name: [rate.count, rate.of] for name, rate in (("before", change.before), ("after", change.after))}
        found = {
            **{"pairs": self.pairs, "unpaired": self.unpaired, "by": self.by, "differs": self.differs},
            "success": {**rates, "p": change.p, "seeds": numbers},
            **{"quantities": self.quantities, "causes": self.causes, "better": self.better, "worse": self.worse},
        }
        return dict(plain(found))


def compare(one: Table, other: Table) -> Comparison:
    """Compare two campaigns, the second with the first.

    Raises:
        UserError: they have no trials in common, or it is not clear which belong together.
    """
    by = _paired_by(one, other)
    first, second = _keyed(one, by), _keyed(other, by)
    pairs = [(row, second[key]) for key, row in first.items() if key in second]
    if not pairs:
        hint = f"they are paired by {', '.join(by)}: run both with the same seeds"
        raise UserError("the two campaigns have no trials in common", hint=hint)
    return Comparison(
        len(pairs),
        (len(first) - len(pairs), len(second) - len(pairs)),
        by,
        list(_differs(one, other)),
        _success(pairs),
        _quantities(pairs, {**one.values, **other.values}),
        _causes(one, other),
    )


def _paired_by(one: Table, other: Table) -> list[str]:
    """Return the columns by which trials belong together: the seed, and what varies in either campaign."""
    varies = dict.fromkeys((*one.plan.varies, *other.plan.varies))
    for table, name in ((one, "first"), (other, "second")):
        if lacking := [column for column in varies if column not in table.columns]:
            hint = "give it a value there too, so that it is known which trials belong together"
            raise UserError(f"{lacking[0]!r} varies in one campaign and is not in the {name}", hint=hint)
    return ["seed", *varies]


def _keyed(table: Table, by: Sequence[str]) -> dict[tuple[str, ...], Row]:
    found: dict[tuple[str, ...], Row] = {}
    for row in table.rows:
        cells = table.cells(row)
        found[tuple(str(cells[name]) for name in by)] = row
    return found


def _differs(one: Table, other: Table) -> Iterable[tuple[str, str, str]]:
    """Yield what all trials of a campaign have in common, and all those of the other one have otherwise."""
    sides = [_common(table) for table in (one, other)]
    varies = {*one.plan.varies, *other.plan.varies}
    for name in (name for name in dict.fromkeys((*sides[0], *sides[1])) if name not in varies):
        before, after = (side.get(name, "as it is") for side in sides)
        if before != after:
            yield name, before, after


def _common(table: Table) -> dict[str, str]:
    setting = table.plan.settings[0]._asdict() if table.plan.settings else {}
    given = {factor.name: str(factor.values[0]) for factor in table.plan.factors if factor.values}
    run = {"duration": str(table.plan.duration or "as a run"), "physics": "none" if table.plan.dry else "MuJoCo"}
    run["script"] = ", ".join(map(as_line, table.plan.script)) or "none"
    run["fail_on"] = ", ".join(table.plan.fail_on) or "none"
    if table.plan.sources:
        run["perception"] = ", ".join(table.plan.sources)
    return {**setting, **given, **run, **{f"file {path}": digest for path, digest in table.plan.files.items()}}


def _success(pairs: Sequence[Pair]) -> SuccessChange:
    before, after = (Rate(sum(pair[side].result.succeeded for pair in pairs), len(pairs)) for side in (0, 1))
    lost = [pair for pair in pairs if pair[0].result.succeeded and not pair[1].result.succeeded]
    gained = [pair for pair in pairs if pair[1].result.succeeded and not pair[0].result.succeeded]
    return SuccessChange(before, after, lost, gained, binomial_p(len(lost), len(gained)))


def _quantities(pairs: Sequence[Pair], values: Mapping[str, str]) -> list[QuantityChange]:
    good = [pair for pair in pairs if pair[0].result.succeeded and pair[1].result.succeeded]
    found = [change for name, unit in {TIME: "s", **values}.items() if (change := _quantity(name, unit, good))]
    raised = holm({change.name: change.p for change in found})
    return [replace(change, p=raised[change.name]) for change in found]


def _quantity(name: str, unit: str, pairs: Sequence[Pair]) -> QuantityChange | None:
    numbers = [(before, after) for pair in pairs if (before := _of(pair[0], name)) is not None
               and (after := _of(pair[1], name)) is not None]  # fmt: skip
    if not numbers:
        return None
    added = [after - before for before, after in numbers]
    larger, smaller = sum(value > 0 for value in added), sum(value < 0 for value in added)
    one, other = (Spread.of([pair[side] for pair in numbers]).quantile(0.5) for side in (0, 1))
    middle, interval = Spread.of(added).quantile(0.5), median_interval(added)
    return QuantityChange(name, unit, one, other, middle, interval, larger, smaller, binomial_p(larger, smaller))


def _of(row: Row, name: str) -> float | None:
    value = row.result.time if name == TIME else row.result.values.get(name)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return None
    return float(value)


def _causes(one: Table, other: Table) -> list[CauseChange]:
    groups: dict[tuple[str, str], tuple[list[str], list[str]]] = {}  # the reasons before, and after
    for side, table in enumerate((one, other)):
        for result in (row.result for row in table.rows if not row.result.succeeded):
            groups.setdefault((result.node, pattern(result.reason)), ([], []))[side].append(result.reason)
    found = [
        CauseChange(f"{node}: {reason}" if node else reason, len(before), len(after))
        for (node, _), (before, after) in groups.items()
        for reason in [common([*before, *after])]
    ]
    return sorted(found, key=lambda change: (-abs(change.after - change.before), -change.before - change.after))
