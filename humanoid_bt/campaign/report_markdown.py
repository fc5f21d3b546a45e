"""The report of a campaign as Markdown, short enough for a pull request."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from humanoid_bt.campaign.compare import Comparison
from humanoid_bt.campaign.reproduce import command
from humanoid_bt.campaign.requirement import Verdict
from humanoid_bt.campaign.summary import Summary, between, percent
from humanoid_bt.campaign.words import chance, changed, figures, headline, verdict
from humanoid_bt.core.texts import one_line

_CAUSES = 8  # that are listed


def markdown(summary: Summary, verdicts: Sequence[Verdict], folder: Path) -> str:
    """Return the report.

    Args:
        summary: what the campaign says.
        verdicts: on what is required.
        folder: the campaign's.
    """
    return "\n".join(_lines(summary, verdicts, folder)) + "\n"


def _lines(summary: Summary, verdicts: Sequence[Verdict], folder: Path) -> Iterator[str]:
    plan = summary.table.plan
    yield f"### {_text(plan.name)}: {headline(summary)}"
    yield ""
    yield _text(plan.title)
    yield ""
    yield from _table(("", ""), figures(summary))
    for name, levels in summary.levels.items():
        yield ""
        rows = (
            (level.text, f"{percent(level.success.share)} ({between(level.success.interval)})", str(level.success.of))
            for level in levels
        )
        yield from _table((name, "success", "trials"), rows)
    if summary.causes:
        yield ""
        yield from _table(("failures", "why", "again"), _causes(summary, folder))
        if (left := len(summary.causes) - _CAUSES) > 0:
            yield f"\nand {left} more causes in the report"
    for one in verdicts:
        yield ""
        yield f"{'✓' if one.met else '✗'} `{one_line(one.text)}`: {_text(one.why)}"


def _causes(summary: Summary, folder: Path) -> Iterator[Sequence[str]]:
    for cause in summary.causes[:_CAUSES]:
        why = (cause.headlines or [cause.reason])[0]
        yield (
            str(len(cause.rows)),
            f"{cause.outcome}: {why}",
            f"`{command(cause.rows[0].trial, summary.table.plan, folder)}`",
        )


def comparison_markdown(found: Comparison) -> str:
    """Return how two campaigns differ, as Markdown."""
    change = found.success
    rows = [
        (
            "success",
            percent(change.before.share),
            percent(change.after.share),
            f"+{len(change.gained)} −{len(change.lost)}, {chance(change.p)}",
        )
    ]
    lines = [f"### {found.pairs} pairs: {verdict(found)}", "", *_table(("", "before", "after", "pairs"), rows), ""]
    lines += [f"- {one.name}: {_text(changed(one))}" for one in found.quantities]
    return "\n".join(lines) + "\n"


def _table(head: Sequence[str], rows: Iterator[Sequence[str]] | Sequence[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield f"|{' --- |' * len(head)}"
    for row in rows:
        yield f"| {' | '.join(map(_text, row))} |"


def _text(text: str) -> str:
    """Return a text that Markdown shows as it is, on one line; what stands in backquotes stays."""
    return one_line(text).replace("|", "\\|").replace("<", "&lt;")
