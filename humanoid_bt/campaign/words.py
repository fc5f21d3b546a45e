"""What a campaign says in words: the same in a terminal, in a report, in a pull request."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from humanoid_bt.campaign.causes import Cause
from humanoid_bt.campaign.compare import Comparison, QuantityChange
from humanoid_bt.campaign.reproduce import command
from humanoid_bt.campaign.result import SUCCESS
from humanoid_bt.campaign.summary import Summary, between, percent
from humanoid_bt.core.units import readable

Line = tuple[str, str]
"""What something is, and a text."""


def headline(summary: Summary) -> str:
    """Return how a campaign went, in a sentence."""
    rate = summary.success
    if not rate.of:
        return "no trial is done"
    share = f"{percent(rate.share)} ({between(rate.interval)})"
    left = f"; {summary.planned - rate.of} are not done" if rate.of < summary.planned else ""
    return f"{rate.count} of {rate.of} succeeded: {share}{left}"


def figures(summary: Summary) -> Iterator[Line]:
    """Yield the numbers that matter most, each in a line."""
    for name, (unit, spread) in summary.spreads.items():
        if spread.values:
            low, middle, high = (readable(spread.quantile(share), unit) for share in (0.05, 0.5, 0.95))
            rest = f"90 % from {low} to {high}" if low.startswith("-") else f"95 % within {high}"
            yield name.replace("_", " "), f"median {middle}, {rest}"
    yield "failures", ", ".join(counts(summary)) or "none"
    if summary.fell:
        yield "fell", f"{summary.fell}"
    if summary.bumped:
        yield "bumped", f"{summary.bumped}"
    if summary.missed:
        told = (f"in {count} of {summary.done} trials {what} never happened" for what, count in summary.missed.items())
        yield "missed", "; ".join(told)


def counts(summary: Summary) -> list[str]:
    """Return how many trials ended in each way but success."""
    return [f"{count} {outcome}" for outcome, count in summary.outcomes.items() if outcome != SUCCESS]


def told(cause: Cause, summary: Summary, folder: Path) -> Iterator[str]:
    """Yield what is known of a cause of failures: why, what recordings show, how to see one again."""
    yield f"{len(cause.rows)} {cause.outcome}: {cause.reason}"
    if cause.node:
        yield f"node: {cause.node}"
    yield from cause.headlines[:2]
    if cause.can_be_recorded and not all(found.same for found in cause.explained.values()):
        yield "not the same when run again: something in the tree or a skill depends on more than the seed"
    yield command(cause.rows[0].trial, summary.table.plan, folder)


def chance(p: float) -> str:
    """Return how likely something is by chance alone."""
    return "p < 0.001" if p < 0.001 else f"p = {p:.2g}"


def changed(one: QuantityChange) -> str:
    """Return how a quantity differs."""
    before, after = readable(one.before, one.unit), readable(one.after, one.unit)
    sign = "+" if one.difference > 0 else ""
    return f"median {before} → {after}, {sign}{readable(one.difference, one.unit)} in a pair ({chance(one.p)})"


def verdict(found: Comparison) -> str:
    """Return what a comparison comes to, in a sentence."""
    parts = [f"better: {', '.join(found.better)}"] * bool(found.better) + [f"worse: {', '.join(found.worse)}"] * bool(
        found.worse
    )
    return "; ".join(parts) or "nothing differs beyond chance"
