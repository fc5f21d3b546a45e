"""What a run prints: what happens as it happens, a progress line on a terminal, and the summary."""

from __future__ import annotations

import shlex
import shutil
import sys
import time
from pathlib import Path
from typing import Any

from py_trees.common import Status
from rich.console import Console
from rich.live import Live
from rich.text import Text

from humanoid_bt.cli.output import hanging, make_safe
from humanoid_bt.cli.styles import STATUS_STYLES
from humanoid_bt.core.errors import relative
from humanoid_bt.core.messages import Level
from humanoid_bt.core.texts import one_line, printable
from humanoid_bt.session.listener import Listener
from humanoid_bt.session.report import Report, aligned
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.nodes import Log
from humanoid_bt.tree.show import MARKS
from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.tree import Tree

_RAISED = ("■", "bold red")
_LEVELS: dict[Level, tuple[str, str]] = {"info": ("•", "blue"), "warning": ("!", "yellow"), "error": _RAISED}
_OUTCOME_STYLES = {
    "success": f"bold {STATUS_STYLES[Status.SUCCESS]}",
    "failure": f"bold {STATUS_STYLES[Status.FAILURE]}",
    "unfinished": "bold yellow",
}
_ORDER = {Status.SUCCESS: 0, Status.FAILURE: 0, Status.INVALID: 1, Status.RUNNING: 2}
"""Within a tick: what ended, what was halted for it, what started instead."""

_LONGEST_NAME = 18  # longer names push their own line's text to the right
_TEXT_COLUMN = 12  # where the text of an event begins
_REFRESH = 0.1  # s between progress lines


class Printer(Listener):
    """Prints a line per skill, action or condition that changed and per event, and a progress line on a terminal.

    Args:
        console: where it prints.
        quiet: print errors only.
    """

    def __init__(self, console: Console, quiet: bool) -> None:
        self._console, self._quiet = console, quiet
        self._live: Live | None = None
        self._suspended = False
        self._began = self._last = time.monotonic()
        self._nodes: dict[str, Node] = {}
        self._tree: tuple[Node, ...] = ()
        self._name_width = 0
        self._told: dict[str, Status] = {}
        self._tick: list[tuple[NodeChange, str]] = []

    def show(self, tree: Tree) -> None:
        """Take the tree whose nodes are printed from now on."""
        self._print_tick()
        self._told.clear()
        self._tree = tree.nodes
        leaves = [node for node in tree.nodes if node.kind in ("skill", "condition", "action")]
        self._nodes = {node.path: node for node in leaves if node.type.cls is not Log}  # what it tells is an event
        longest = max((len(node.name) for node in self._nodes.values()), default=0)
        self._name_width = min(longest, _LONGEST_NAME)

    def __enter__(self) -> Printer:
        self._began = time.monotonic()
        if self._console.is_terminal and not self._quiet:
            self._live = Live(console=self._console, transient=True, auto_refresh=False)
            self._live.start()
            make_safe(sys.stdout, sys.stderr)  # it takes what others print and would follow their commands
        return self

    def __exit__(self, *_: Any) -> None:
        self._print_tick()
        if self._live is not None:
            self._live.stop()

    def suspend(self) -> None:
        """Show no progress, from any thread, until :meth:`resume`: somebody types."""
        self._suspended = True
        if self._live is not None:
            self._live.update(Text(""), refresh=True)
            self._live.stop()

    def resume(self) -> None:
        """Show progress again."""
        if self._live is not None:
            self._live.start()
        self._suspended = False

    def node_changed(self, change: NodeChange) -> None:
        """Take what a skill or condition became, to be printed with what else came in its tick."""
        if self._quiet or change.path not in self._nodes:
            return
        if self._tick and self._tick[0][0].time != change.time:
            self._print_tick()
        told = self._told.get(change.path)
        if change.status is Status.INVALID and not change.feedback:
            return  # it was not running: only its branch was left
        if self._nodes[change.path].kind == "condition" and told is change.status:
            return
        self._told[change.path] = change.status
        self._tick.append((change, self._occasion(change)))

    def event(self, time: float, level: Level, text: str) -> None:
        """Print an event."""
        self._print_tick()
        if not self._quiet or level == "error":
            first, *more = printable(text).splitlines()
            self._line(time, *_LEVELS[level], "", first)
            for line in more:
                self._console.print(Text(_continued(line, self._console.is_terminal)), soft_wrap=True)

    def progress(self, time: float, running: str) -> None:
        """Show where the run is."""
        self._print_tick()
        if self._live is None or self._suspended:
            return
        now = _wall()
        if now - self._last >= _REFRESH:
            self._last = now
            speed = time / max(now - self._began, 1e-6)
            line = f"{time:7.2f} s   {speed:.1f}x  {one_line(running)}"
            self._live.update(Text(line, style="dim", no_wrap=True, overflow="ellipsis"), refresh=True)

    def _occasion(self, change: NodeChange) -> str:
        """Return why a node that stands under a key of its own, such as ``on_stale``, starts."""
        if change.status is Status.RUNNING:
            node = self._nodes[change.path]
            while node.parent >= 0:
                parent = self._tree[node.parent]
                if node.branch and parent.behaviour.feedback_message:
                    return f" ({parent.behaviour.feedback_message})"
                node = parent
        return ""

    def _print_tick(self) -> None:
        for change, occasion in sorted(self._tick, key=lambda entry: _ORDER[entry[0].status]):
            raised = change.status is Status.INVALID and change.feedback.startswith("raised ")
            sign, style = _RAISED if raised else (MARKS[change.status], STATUS_STYLES[change.status])
            text = "raised an exception" if raised else change.feedback + occasion  # which one is told elsewhere
            self._line(change.time, sign, style, self._nodes[change.path].name, text)
        self._tick.clear()

    def _line(self, at: float, sign: str, style: str, name: str, text: str) -> None:
        text, label = printable(text), f"{printable(name):<{self._name_width}} " if name else ""
        head = f"{at:7.2f} s {sign} {label}"
        lines = hanging(head, text) if self._console.is_terminal else [head + " ".join(text.split())]
        line = Text("\n".join(lines))
        line.stylize("dim", 0, 10)
        line.stylize(style, 10, 11)
        line.stylize("bold", _TEXT_COLUMN, _TEXT_COLUMN + len(label))
        self._console.print(line, soft_wrap=True)


def _continued(line: str, wraps: bool) -> str:
    """Return a further line of an event, below the first one's text."""
    text = line.lstrip()
    head = " " * (_TEXT_COLUMN + len(line) - len(text))
    return "\n".join(hanging(head, text)) if wraps else head + text


def print_summary(console: Console, report: Report) -> None:
    """Print how a run ended."""
    style = _OUTCOME_STYLES.get(report.outcome, "bold red")
    first, *others = printable(report.reason).splitlines() or [""]
    lines = hanging(f"{report.outcome}: ", first)
    for line in others:
        lines += hanging(line[: len(line) - len(line.lstrip())], line.lstrip())
    text = Text("\n".join(["", *lines]))
    text.stylize(style, 0, len(report.outcome) + 1)
    console.print(text, soft_wrap=True)
    rows = report.summary
    if report.recording and Path(report.recording).exists():
        files = shlex.quote(report.recording)
        if len(report.recording_parts) > 1:
            files = f"{shlex.quote(str(Path(report.recording).with_suffix('')))}.*rrd"
        rows.append(("open it", f"{shlex.quote(_viewer_command())} {files}"))
        if report.outcome not in ("success", "interrupted"):
            rows.append(("explain it", f"humanoid-bt explain {shlex.quote(report.recording)}"))
    for line in aligned(rows):
        console.print(line, soft_wrap=True, markup=False)


def _viewer_command() -> str:
    """Return the viewer's command: beside this interpreter if it is not on the path."""
    beside = Path(sys.executable).parent / "rerun"
    if shutil.which("rerun") or not beside.exists():
        return "rerun"
    return relative(beside)


def _wall() -> float:
    return time.monotonic()
