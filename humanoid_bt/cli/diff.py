"""``humanoid-bt diff``: how two recorded runs differ."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from humanoid_bt.cli.output import columns, print_lines
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.texts import one_line, shortened
from humanoid_bt.record.reading import files_of
from humanoid_bt.record.sinks import has_display
from humanoid_bt.record.viewers import free_port, start_viewer
from humanoid_bt.review.compare_run import NodeShift, Parting
from humanoid_bt.review.compare_setup import Change
from humanoid_bt.review.difference import Difference, difference
from humanoid_bt.review.recording import Recording, open_recording
from humanoid_bt.review.words import status
from humanoid_bt.session.report import ExitCode

_DIFFERENT = 1
_MOST = 12  # lines of one part on the screen
_LONGEST = 160  # characters of a value on the screen


def diff(arguments: argparse.Namespace) -> int:
    """Print how two runs differ."""
    one, other = open_recording(arguments.one), open_recording(arguments.other)
    found = difference(one, other, arguments.tolerance, arguments.within)
    for recording in (one, other):
        for text in recording.damage:
            print(f"warning: {relative(recording.path)}: {text}", file=sys.stderr)
    if arguments.json:
        print(json.dumps(found.to_dict(), indent=2))
    else:
        _print(one, other, found)
    if arguments.view:
        _view(one, other)
    return ExitCode.SUCCESS if found.is_none else _DIFFERENT


def _print(one: Recording, other: Recording, found: Difference) -> None:
    print_lines(columns([("A", relative(one.path), one.title), ("B", relative(other.path), other.title)]))
    if found.is_none:
        print("\nthe runs are the same")
        return
    ends = ("results", "outcome")
    for part in dict.fromkeys(change.part for change in found.changes if change.part not in ends):
        _section(part, map(_change, (change for change in found.changes if change.part == part)))
    if found.parting is not None:
        _section(f"first apart at {found.parting.time:.2f} s", [_parting(found.parting)])
    _section("nodes, where they first differ", map(_shift, found.nodes))
    for part in ends:
        _section(part, map(_change, (change for change in found.changes if change.part == part)))


def _section(title: str, rows: Iterable[Sequence[str]]) -> None:
    listed = [[_short(cell) for cell in row] for row in rows]
    if listed:
        print(f"\n{title}")
        print_lines(columns(listed[:_MOST], indent=2))
        if len(listed) > _MOST:
            print(f"  and {len(listed) - _MOST} more: --json has all")


def _change(change: Change) -> tuple[str, str]:
    name = _near(change.name) if change.part in ("tree", "results") else change.name
    if change.before is None:
        return f"+ {name}", str(change.after)
    if change.after is None:
        return f"- {name}", change.before
    return f"  {name}", f"{_short(change.before)} → {_short(change.after)}"


def _parting(parting: Parting) -> tuple[str, str]:
    return parting.quantity, f"{_short(parting.before)} → {_short(parting.after)}"


def _shift(shift: NodeShift) -> tuple[str, str]:
    before, after = (
        "nothing" if at is None else f"{status(at[0])} at {at[1]:.2f} s" for at in (shift.before, shift.after)
    )
    return _near(shift.node), f"{before} → {after}"


def _near(path: str) -> str:
    """Return the end of a path, which mostly is enough to tell nodes apart."""
    above = path.split("/")
    return "/".join(["…", *above[-2:]]) if len(above) > 2 else path


def _short(text: str) -> str:
    return one_line(shortened(text, _LONGEST))


def _view(one: Recording, other: Recording) -> None:
    """Show both in one view."""
    from humanoid_bt.record.side_by_side import write_side_by_side  # the viewer's library takes its time

    both = Path(tempfile.mkdtemp(prefix="humanoid-bt-")) / f"{one.path.stem}-and-{other.path.stem}.rrd"
    try:
        write_side_by_side(both, (files_of(one.path), files_of(other.path)))
    except OSError as error:
        raise UserError(f"the view of both cannot be written: {error.strerror}: {str(both)!r}") from error
    if has_display():
        start_viewer(free_port(), both)
    else:
        print("\nthere is no display here; where there is one:")
    print(f"both in one view: {shlex.join(['rerun', str(both)])}")
