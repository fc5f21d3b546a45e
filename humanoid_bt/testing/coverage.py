"""Tree coverage: what of tree files was tried while trees ran, in this process and in those that it started."""

from __future__ import annotations

import json
import math
import os
import shutil
import tempfile
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from humanoid_bt.core.errors import UserError, relative, resolved
from humanoid_bt.files.whole import write_whole
from humanoid_bt.files.workspace import Workspace, yaml_files
from humanoid_bt.tree.counting import FOLDER, recorder
from humanoid_bt.tree.coverage import Coverage, FileCoverage, NodeCoverage, digest_of
from humanoid_bt.tree.source.load import load_tree

_NARROW = 40  # columns, at least


@contextmanager
def counting() -> Iterator[Path]:
    """Count what trees do meanwhile; give the folder that takes it, for :func:`coverage_in`."""
    before = os.environ.get(FOLDER)
    with tempfile.TemporaryDirectory(prefix="tree-coverage-") as folder:
        os.environ[FOLDER] = folder
        try:
            yield Path(folder)
        finally:
            if before is None:
                del os.environ[FOLDER]
            else:
                os.environ[FOLDER] = before


def save() -> None:
    """Write what this process has counted, trees included that still run."""
    if (counting_here := recorder()) is not None:
        counting_here.save()


def coverage_in(*places: Path) -> Coverage:
    """Return all that was counted in files, and in the files of folders.

    Raises:
        UserError: one of them cannot be read, holds something else, or nothing.
    """
    found = Coverage()
    for place in places:
        files = sorted(place.glob("*.json")) if place.is_dir() else [place]
        if not files:
            hint = f"it is filled while {FOLDER} names it and trees run"
            raise UserError(f"nothing was counted in {relative(place)!r}", hint=hint, code="no-file")
        for path in files:
            found.merge(Coverage.read(path))
    return found


def write(path: Path, text: str) -> None:
    """Write a file whole or not at all.

    Raises:
        UserError: it cannot be written.
    """
    try:
        write_whole(path, text.encode("utf-8", errors="replace"))
    except OSError as error:
        hint = "valid: a file in a folder that is there and that you may write"
        raise UserError(f"{relative(path)!r} cannot be written: {error.strerror}", hint=hint) from error


@dataclass(frozen=True)
class TreeCoverage:
    """What of some tree files was tried.

    Attributes:
        files: what was counted of each, with all that it could do; a file that cannot be read has no nodes.
        problems: what is wrong with those.
    """

    files: tuple[FileCoverage, ...]
    problems: tuple[str, ...] = ()

    @property
    def possible(self) -> int:
        """How much the nodes can do."""
        return sum(file.possible for file in self.files)

    @property
    def seen(self) -> int:
        """How much of that they did."""
        return sum(file.seen for file in self.files)

    @property
    def percent(self) -> float:
        """The same in percent."""
        return percent(self.seen, self.possible) if not self.problems else 0.0

    @property
    def shown(self) -> str:
        """The same for people: 100 only if nothing is missing."""
        return f"{math.floor(self.percent * 10) / 10:g}"

    def missed(self, least: float) -> str:
        """Return that less was tried than so many percent, for people; "" if it was not."""
        if self.problems or self.percent >= least:
            return self.problems[0] if self.problems else ""
        return f"{self.shown} % of what nodes can do was tried, less than {least:g} %"

    def to_json(self) -> str:
        """Return it as text that :meth:`Coverage.read` reads again."""
        whole = Coverage()
        whole.files = {(file.path, file.digest): file for file in self.files}
        totals = {"seen": self.seen, "possible": self.possible, "percent": round(self.percent, 2)}
        return json.dumps({**whole.to_dict(), "totals": totals}, indent=2) + "\n"

    def text(self, width: int | None = None) -> str:
        """Return a table of the files, and below each the lines whose nodes never did all that they can.

        Args:
            width: columns; those of the terminal if not given.
        """
        return "\n".join(self._lines(max(width or shutil.get_terminal_size().columns, _NARROW)))

    def _lines(self, width: int) -> Iterator[str]:
        names = [relative(file.path) for file in self.files]
        column = min(max(map(len, (*names, "all"))), width - 17)
        for name, file in zip(names, self.files, strict=True):
            short = name if len(name) <= column else f"…{name[1 - column :]}"
            yield _row(short, column, file.seen, file.possible)
            if file.nodes and not any(node.ticked for node in file.ordered):
                yield "         never run"
                continue
            for node in file.ordered:
                if node.missing:
                    head = f"  {node.line:>5}  "
                    text = f"{node.name}: {never(node)}"
                    yield from textwrap.wrap(text, width, initial_indent=head, subsequent_indent=" " * len(head))
        if len(self.files) != 1:
            yield _row("all", column, self.seen, self.possible)
        for line in "\n".join(self.problems).splitlines():
            yield from textwrap.wrap(line, width, subsequent_indent="    ")


def tree_files(paths: Sequence[str], root: Path) -> list[Path]:
    """Return the tree files that are meant, without links, in the order of their names.

    Args:
        paths: tree files, folders of them, or names of trees; none: all trees of the workspace.
        root: the workspace.

    Raises:
        UserError: there is no such file, or none in a folder.
    """
    found: dict[Path, None] = {}
    workspace = Workspace(root)
    for name in paths or [str(workspace.root / "trees")]:
        folder = Path(name)
        if paths and not folder.is_dir():
            found[resolved(workspace.find_tree(name))] = None
            continue
        inside = yaml_files(folder, ["trees"])
        if not inside:
            hint = "valid: a tree's file or name, or a folder with trees"
            raise UserError(f"there are no tree files in {relative(folder)!r}", hint=hint, code="no-file")
        found |= dict.fromkeys(map(resolved, inside))
    return sorted(found)


def tree_coverage(counted: Coverage, paths: Iterable[Path]) -> TreeCoverage:
    """Return what of tree files was tried.

    Args:
        counted: what was counted. Of files that have changed since then nothing was.
        paths: the files, without links.
    """
    files, problems = [], []
    for path in paths:
        whole, digest = Coverage(), digest_of(path)
        try:
            whole.add(load_tree(path, Workspace.of_tree(path)))  # all its nodes, run or not
        except UserError as error:
            problems.append(str(error))
        file = whole.files.get((path, digest), FileCoverage(path, digest))
        file.merge(counted.files.get((path, digest), file))
        files.append(file)
    return TreeCoverage(tuple(files), tuple(problems))


def percent(seen: int, possible: int) -> float:
    """Return a share in percent; all of nothing is all."""
    return 100.0 * seen / possible if possible else 100.0


def never(node: NodeCoverage) -> str:
    """Return what a node never did, for people."""
    if not node.ticked:
        return "never ticked"
    *others, last = node.missing
    return "never " + (f"{', '.join(others)} or {last}" if others else last)


def _row(name: str, column: int, seen: int, possible: int) -> str:
    share = int(percent(seen, possible)) if possible else "?"  # 99.9 is not yet 100; a file with mistakes has no nodes
    return f"{name:<{column}}  {f'{seen}/{possible}':>9}  {share:>3} %"
