"""The report of a campaign as a web page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import quote

from humanoid_bt.campaign import plots
from humanoid_bt.campaign.causes import Cause
from humanoid_bt.campaign.page import card, code, page, safe, table
from humanoid_bt.campaign.reproduce import command
from humanoid_bt.campaign.requirement import Verdict
from humanoid_bt.campaign.statistics import QUANTILES
from humanoid_bt.campaign.summary import Summary, percent
from humanoid_bt.campaign.words import figures, headline
from humanoid_bt.core.units import readable

_TRIALS = 12  # of a cause whose commands are listed
_LEVELS = 40  # of something that varies, which are drawn


def html(summary: Summary, verdicts: Sequence[Verdict], folder: Path) -> str:
    """Return the report.

    Args:
        summary: what the campaign says.
        verdicts: on what is required.
        folder: the campaign's; links to recordings are relative to it.
    """
    return page(summary.table.plan.name, _parts(summary, verdicts, folder))


def _parts(summary: Summary, verdicts: Sequence[Verdict], folder: Path) -> Iterator[str]:
    plan, rate = summary.table.plan, summary.success
    yield f"<h1>{safe(plan.name)}</h1>"
    if plan.description:
        yield f"<p>{safe(plan.description)}</p>"
    yield f'<p class="muted">{safe(plan.title)}</p>'
    if rate.of:
        yield f'<p class="big">{percent(rate.share)}</p>'
        yield f'<p>{safe(headline(summary))} <span class="muted">with 95 % confidence</span></p>'
    if summary.done < summary.planned:
        yield f'<p class="bad">Not done: {summary.planned - summary.done} of {summary.planned} trials.</p>'
    for one in verdicts:
        sign, kind = ("✓", "good") if one.met else ("✗", "bad")
        yield f'<p><span class="{kind}">{sign}</span> {code(one.text)} {safe(one.why)}</p>'
    yield table(("", ""), ((f'<span class="muted">{safe(name)}</span>', safe(text)) for name, text in figures(summary)))
    if any(spread.values for _, spread in summary.spreads.values()):
        yield "<h2>Of the trials that succeeded</h2>"
        yield f'<div class="cards">{"".join(_spreads(summary))}</div>'
    if summary.levels:
        yield "<h2>Success, by what varies</h2>"
        yield f'<div class="cards">{"".join(_levels(summary))}</div>'
    if summary.causes:
        yield "<h2>Why trials failed</h2>"
        yield table(("trials", "why", "node", ""), (_cause(cause, summary, folder) for cause in summary.causes))
    yield "<h2>What was run</h2>"
    yield table(("", ""), _about(summary, folder))


def _spreads(summary: Summary) -> Iterator[str]:
    for name, (unit, spread) in summary.spreads.items():
        if spread.values:
            told = ", ".join(f"{key} {readable(spread.quantile(share), unit)}" for key, share in QUANTILES.items())
            title = name.replace("_", " ")
            yield card(title, plots.histogram(spread, unit, title) + f'<p class="muted">{safe(told)}</p>')


def _levels(summary: Summary) -> Iterator[str]:
    for name, levels in summary.levels.items():
        left = f'<p class="muted">and {len(levels) - _LEVELS} more</p>' if len(levels) > _LEVELS else ""
        yield card(name, plots.rates(levels[:_LEVELS], name) + left)


def _cause(cause: Cause, summary: Summary, folder: Path) -> tuple[str, str, str, str]:
    share = percent(len(cause.rows) / summary.done)
    why = f"<p>{safe(f'{cause.outcome}: {cause.reason}')}</p>"
    why += "".join(f'<p class="muted">{safe(text)}</p>' for text in cause.headlines)
    if len(cause.kinds) > 1:
        why += f'<p class="muted">recordings show different causes: {safe(", ".join(cause.kinds))}</p>'
    for number, found in cause.explained.items():
        if not found.same:
            why += f'<p class="bad">Trial {number} went another way when it was run again.</p>'
    plan = summary.table.plan
    again = "".join(f"<p>{code(command(row.trial, plan, folder))}</p>" for row in cause.rows[:_TRIALS])
    left = f"<p>and {len(cause.rows) - _TRIALS} more: see results.csv</p>" if len(cause.rows) > _TRIALS else ""
    files = [found.recording for found in cause.explained.values() if found.recording]
    links = "".join(f'<p><a href="recordings/{quote(name)}">{safe(name)}</a></p>' for name in files)
    seen = f"<details><summary>{len(files)} recorded</summary>{links}</details>" if files else ""
    more = f"<details><summary>run it again</summary>{again}{left}</details>{seen}"
    return f"{len(cause.rows)}<br><span class=muted>{share}</span>", why, safe(cause.node.replace("/", " / ")), more


def _about(summary: Summary, folder: Path) -> Iterator[tuple[str, str]]:
    plan = summary.table.plan
    for name in ("tree", "robot", "scene"):
        yield name, ", ".join(dict.fromkeys(safe(getattr(setting, name)) for setting in plan.settings))
    yield "seeds", safe(str(plan.seeds))
    for factor in plan.factors:
        if factor.ends is not None:
            low, high = (readable(end, factor.unit) for end in factor.ends)
            yield safe(factor.name), safe(f"{low} to {high}, drawn for each trial from its seed")
        else:
            yield safe(factor.name), safe(", ".join(readable(value, factor.unit) for value in factor.values))
    if plan.sources:
        yield "perception", safe(", ".join(plan.sources))
    if plan.duration is not None:
        yield "longest time", safe(readable(plan.duration, "s"))
    if plan.script:
        yield "script", f"{len(plan.script)} events in every trial"
    if plan.fail_on:
        yield "failures, too", ", ".join(plan.fail_on)
    yield "physics", "none: a dry run, for the logic of the tree alone" if plan.dry else "MuJoCo"
    yield (
        "files",
        "<br>".join(f"{safe(path)} <span class=muted>{safe(text)}</span>" for path, text in plan.files.items()),
    )
