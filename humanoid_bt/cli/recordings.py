"""``recordings``, ``keep``: the folder of recordings."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from humanoid_bt.cli.output import columns, hanging, print_lines
from humanoid_bt.core.errors import UserError, nearest, relative
from humanoid_bt.core.sizes import shown_size
from humanoid_bt.record.folder import Recorded, recordings_in, report_beside, stem_of
from humanoid_bt.record.folder_limits import load_limits
from humanoid_bt.session.options import RUNS
from humanoid_bt.session.report import ExitCode

_MOST_SHOWN = 20


def recordings(arguments: argparse.Namespace) -> int:
    """List the recordings of this folder, newest first; return the exit code."""
    found = recordings_in(RUNS)
    shown = found if arguments.all or arguments.json else found[:_MOST_SHOWN]
    if arguments.json:
        print(json.dumps([_plain(one) for one in shown], indent=2))
        return ExitCode.SUCCESS
    print_lines(columns(_row(one) for one in shown))
    limits, kept = load_limits(RUNS), [one for one in found if one.kept]
    total = shown_size(sum(one.size for one in found if not one.kept))
    lines = [f"{len(found) - len(kept)} of at most {limits.recordings}, {total} of at most {limits.size}"]
    if kept:
        lines.append(f"{len(kept)} kept besides, {shown_size(sum(one.size for one in kept))}")
    if len(shown) < len(found):
        lines.append(f"{len(found) - len(shown)} older ones are not shown: --all")
    print_lines(line for text in lines for line in hanging("", text))
    return ExitCode.SUCCESS


def keep(arguments: argparse.Namespace) -> int:
    """Keep recordings for good, or no longer; return the exit code."""
    found = {one.first.stem: one for one in recordings_in(RUNS)}
    for one in dict.fromkeys(_named(name, found).first.stem for name in arguments.recordings):
        recorded, wanted = found[one], not arguments.undo
        already = recorded.keep(wanted)
        print(f"{'kept' if wanted else 'no longer kept'}{' already' if already else ''}: {relative(recorded.first)}")
    return ExitCode.SUCCESS


def _named(name: str, found: dict[str, Recorded]) -> Recorded:
    """Return the recording that a name or the path of one of its files is of."""
    path = Path(name)
    if path.parent != Path() and path.parent.resolve() != RUNS.resolve():
        raise UserError(f"{name!r} is not in {str(RUNS)!r}", hint=f"only recordings in {str(RUNS)!r} are ever removed")
    if (stem := stem_of(path.name)) not in found:
        hint = nearest(stem, found, "humanoid-bt recordings") or f"there is none in {str(RUNS)!r} here"
        raise UserError(f"no recording {name!r}", hint=hint)
    return found[stem]


def _row(one: Recorded) -> tuple[str, ...]:
    ended = _ended(one)
    began = f"{one.began:%Y-%m-%d %H:%M:%S}"
    outcome = ended.get("outcome") or ("being written" if one.is_written else "unknown")
    length = _shown_time(ended["sim_time"]) if ended else ""
    parts = f"{len(one.parts)} parts" if len(one.parts) > 1 else ""
    rest = ", ".join(filter(None, [relative(one.first), parts, "kept" if one.kept else ""]))
    return began, one.tree, outcome, length, shown_size(one.size), rest


def _plain(one: Recorded) -> dict[str, Any]:
    ended = _ended(one)
    return {
        "recording": relative(one.first),
        "tree": one.tree,
        "began": one.began.isoformat(),
        "outcome": ended.get("outcome"),
        "sim_time": ended.get("sim_time"),
        "size": one.size,
        "parts": [relative(part) for part in one.parts],
        "kept": one.kept,
        "being_written": one.is_written,
    }


def _ended(one: Recorded) -> dict[str, Any]:
    """Return how the run ended, nothing if it does not say."""
    try:
        report = json.loads(report_beside(one.first).read_bytes())
        return {"outcome": str(report["outcome"]), "sim_time": float(report["sim_time"])}
    except (OSError, ValueError, KeyError, TypeError):
        return {}


def _shown_time(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.1f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"
