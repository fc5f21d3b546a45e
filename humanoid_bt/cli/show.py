"""``humanoid-bt show``: drawing a tree from its file, or as it runs in another terminal."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from py_trees.common import Status
from rich.console import Console
from rich.live import Live
from rich.text import Text

from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.cli.output import width
from humanoid_bt.cli.runs import one_run
from humanoid_bt.cli.styles import STATUS_STYLES
from humanoid_bt.core.errors import HumanoidBtError, UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.link.run_folder import RunInfo
from humanoid_bt.realtime.live_tree import Moment, TreeWatch
from humanoid_bt.session.report import ExitCode
from humanoid_bt.tree.show import Outline, dot_tree, mermaid_tree, outline_of, svg_tree, unicode_tree
from humanoid_bt.tree.show.fold import fitted, folded_below, without_subtrees
from humanoid_bt.tree.show.text import Line, lines_of
from humanoid_bt.tree.source.load import load_tree

_SUFFIXES = {
    ".txt": "unicode",
    ".svg": "svg",
    ".dot": "dot",
    ".gv": "dot",
    ".mmd": "mermaid",
    ".mermaid": "mermaid",
}
_DRAWINGS: Mapping[str, Callable[..., str]] = {"svg": svg_tree, "dot": dot_tree, "mermaid": mermaid_tree}
_UNWRAPPED = 10_000  # columns of a line that goes to a file or another program
_REFRESH = 0.1  # s between two looks at a tree that runs
_PATIENCE = 2.0  # s for a run that has just started to say what its tree is


def show(arguments: argparse.Namespace) -> int:
    """Draw a tree; return the exit code."""
    live = arguments.live or arguments.run is not None
    if live and arguments.tree:
        what = "--live" if arguments.live else "--run"
        raise UserError(f"TREE does not go with {what}", hint="it shows the tree that runs: give one of the two")
    if not live and not arguments.tree:
        raise UserError("which tree? Give its name or file, or --live", hint="humanoid-bt show fetch")
    drawing = _format(arguments.format, arguments.output)
    if live:
        return _show_live(arguments, drawing)
    workspace = Workspace.of_argument(arguments.tree, arguments.workspace)
    outline = _closed(outline_of(load_tree(workspace.find_tree(arguments.tree), workspace)), arguments)
    _deliver(_drawn(drawing, outline, None, None), outline, arguments.output)
    return ExitCode.SUCCESS


def _closed(outline: Outline, arguments: argparse.Namespace) -> Outline:
    """Return what is drawn of a tree that is closed as the arguments say."""
    if arguments.closed:
        outline = without_subtrees(outline)
    return outline if arguments.depth is None else folded_below(outline, arguments.depth)


def _format(chosen: str | None, output: Path | None) -> str:
    if chosen:
        return chosen
    if output is None:
        return "unicode"
    if output.suffix not in _SUFFIXES:
        hint = f"end it in {', '.join(_SUFFIXES)}, or give --format"
        raise UserError(f"{str(output)!r} does not say in which format", hint=hint)
    return _SUFFIXES[output.suffix]


def _drawn(
    drawing: str, outline: Outline, statuses: Mapping[str, Status] | None, feedback: Mapping[str, str] | None
) -> str:
    if drawing != "unicode":
        return _DRAWINGS[drawing](outline, statuses, feedback)
    wide = width() if sys.stdout.isatty() else _UNWRAPPED
    return unicode_tree(outline, statuses, wide, feedback) + "\n"


def _deliver(text: str, outline: Outline, output: Path | None) -> None:
    if output is None:
        print(text, end="")
        return
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        hint = "valid: a file in a folder that is there and that you may write"
        raise UserError(f"{str(output)!r} cannot be written: {error.strerror}", hint=hint) from error
    count = len(outline.nodes)
    print(f"{output}: {count} node{'s' if count > 1 else ''} of {outline.name}")


# ---- a tree that runs -----------------------------------------------------------------------------------------------


def _show_live(arguments: argparse.Namespace, drawing: str) -> int:
    folder, info = one_run(arguments.run, "show --live")
    with contextlib.closing(TreeWatch(folder)) as watch:
        console = SafeConsole()
        if console.is_terminal and drawing == "unicode" and arguments.output is None:
            with contextlib.suppress(KeyboardInterrupt):
                _follow(watch, info, console, arguments)
            return ExitCode.SUCCESS
        moment = next(_moments(watch))
        outline = _closed(_titled(moment, info, watch), arguments)
        _deliver(_drawn(drawing, outline, moment.statuses, moment.feedback), outline, arguments.output)
    return ExitCode.SUCCESS


def _follow(watch: TreeWatch, info: RunInfo, console: Console, arguments: argparse.Namespace) -> None:
    """Draw the tree again and again, until the run is over."""
    with Live(console=console, auto_refresh=False) as live:
        for moment in _moments(watch):
            outline = _closed(_titled(moment, info, watch), arguments)
            live.update(_colored(moment, outline, console), refresh=True)
    console.print("the run is over", style="dim")


def _moments(watch: TreeWatch) -> Iterator[Moment]:
    """Yield what the tree does, every now and then, until the run is over.

    Raises:
        HumanoidBtError: the run does not say anything.
    """
    moment, patience = watch.latest(), time.monotonic() + _PATIENCE
    while moment is None:
        if watch.over or time.monotonic() > patience:
            raise HumanoidBtError("the run does not tell what its tree does: it has just ended, or only starts")
        time.sleep(_REFRESH)
        moment = watch.latest()
    while True:
        yield moment
        time.sleep(_REFRESH)
        if watch.over:
            return
        moment = watch.latest() or moment


def _titled(moment: Moment, info: RunInfo, watch: TreeWatch) -> Outline:
    """Return what is drawn of the tree, with what runs when instead of its description."""
    text = f"on {info.robot} at {moment.time:.1f} s"
    if watch.abandoned:
        text += ", decision is dead: what it did last"
    return replace(moment.outline, description=text)


def _colored(moment: Moment, outline: Outline, console: Console) -> Text:
    """Return the drawing with colours, as much of it as fits."""

    def lines(of: Outline) -> list[Line]:
        return lines_of(of, moment.statuses, console.width, moment.feedback)

    outline = fitted(outline, moment.statuses, lambda smaller: len(lines(smaller)) < console.height)
    text = Text(no_wrap=True, overflow="ellipsis")
    for line in lines(outline):
        status = None if line.node < 0 else moment.statuses[outline.nodes[line.node].path]
        style = "bold" if status is None else STATUS_STYLES[status]
        text.append(line.guide, "dim").append(line.text + "\n", style)
    text.rstrip()
    return text
