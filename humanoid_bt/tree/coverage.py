"""What the nodes of tree files did while somebody counted, of all that they can do; as JSON it can be merged.

Nodes are known by where they are written, so that a sub-tree's belong to its own file, whoever uses it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from py_trees.behaviours import Dummy
from py_trees.common import Status

from humanoid_bt.core.errors import UserError, relative, resolved
from humanoid_bt.tree.results import ANYTHING, Below, Results
from humanoid_bt.tree.tree import Tree

DEEDS = ("success", "failure", "running", "halted")
"""What a node can do."""

DEED_OF: Mapping[Status, str] = {status: status.name.lower() for status in ANYTHING}
"""What a node does whose tick returns a status."""

_FORMAT = 1


@dataclass
class NodeCoverage:
    """What was counted of the node at one place of a file.

    Attributes:
        line, column: where it is written.
        name: as the file calls it, or its type.
        type: its type.
        possible: what it can do, of :data:`DEEDS`.
        seen: what it did.
        ticked: whether it was ticked at all; one that raised an exception may have done nothing else.
    """

    line: int
    column: int
    name: str
    type: str
    possible: set[str] = field(default_factory=set)
    seen: set[str] = field(default_factory=set)
    ticked: bool = False

    @property
    def counted(self) -> tuple[str, ...]:
        """What it can do, in the order of :data:`DEEDS`."""
        return tuple(deed for deed in DEEDS if deed in self.possible | self.seen)

    @property
    def missing(self) -> tuple[str, ...]:
        """What it can do and never did."""
        return tuple(deed for deed in self.counted if deed not in self.seen)


@dataclass
class FileCoverage:
    """What was counted of a tree file.

    Attributes:
        path: the file.
        digest: of its text, as it was then.
        nodes: its nodes by line and column.
    """

    path: Path
    digest: str
    nodes: dict[tuple[int, int], NodeCoverage] = field(default_factory=dict)

    @property
    def ordered(self) -> list[NodeCoverage]:
        """Its nodes as they are written."""
        return [self.nodes[place] for place in sorted(self.nodes)]

    @property
    def possible(self) -> int:
        """How much its nodes can do."""
        return sum(len(node.counted) for node in self.nodes.values())

    @property
    def seen(self) -> int:
        """How much of that they did."""
        return sum(len(node.seen) for node in self.nodes.values())

    def merge(self, other: FileCoverage) -> None:
        """Add what was counted elsewhere of the same text."""
        for place, node in other.nodes.items():
            mine = self.nodes.setdefault(place, NodeCoverage(*place, node.name, node.type))
            mine.possible |= node.possible
            mine.seen |= node.seen
            mine.ticked |= node.ticked


class Coverage:
    """What was counted of tree files.

    Attributes:
        files: of each file with each of its texts.
    """

    def __init__(self) -> None:
        self.files: dict[tuple[Path, str], FileCoverage] = {}

    def add(self, tree: Tree) -> dict[str, NodeCoverage]:
        """Count a tree's nodes from now on; return them by their paths."""
        digests = {path: digest for path in tree.files if (digest := digest_of(path))}
        found: dict[str, NodeCoverage] = {}
        for node, results in zip(tree.nodes, _results(tree), strict=True):
            path = _file(node.place.file, digests)
            if path is None or node.type.cls is Dummy:  # made in Python; a parameter without a value
                continue
            key = resolved(path), digests[path]
            file = self.files.setdefault(key, FileCoverage(*key))
            place = node.place.line, node.place.column
            counted = file.nodes.setdefault(place, NodeCoverage(*place, node.name, node.type_name))
            counted.possible |= {DEED_OF[status] for status in results}
            if Status.RUNNING in results:
                counted.possible.add("halted")
            found[node.path] = counted
        return found

    def merge(self, other: Coverage) -> None:
        """Add what was counted elsewhere."""
        for key, file in other.files.items():
            self.files.setdefault(key, FileCoverage(file.path, file.digest)).merge(file)

    def to_dict(self, name: Callable[[Path], str] = relative) -> dict[str, Any]:
        """Return it as plain data.

        Args:
            name: how files are called; as seen from the working directory if not given.
        """
        files = [{"file": name(file.path), **_plain(file)} for _, file in sorted(self.files.items())]
        return {"format": _FORMAT, "files": files}

    @classmethod
    def read(cls, path: Path) -> Coverage:
        """Return what a file holds that was written from :meth:`to_dict`.

        Raises:
            UserError: it cannot be read, or holds something else.
        """
        found = cls()
        try:
            data = json.loads(path.read_text(encoding="utf-8"))
            if data["format"] != _FORMAT:
                raise ValueError(f"its format is {data['format']}, not {_FORMAT}")
            for entry in data["files"]:
                file = FileCoverage(resolved(Path(entry["file"])), entry["digest"])
                for node in entry["nodes"]:
                    place = node["line"], node["column"]
                    possible, seen = (set(DEEDS) & set(node[what]) for what in ("possible", "seen"))
                    ticked = node["ticked"] is True
                    file.nodes[place] = NodeCoverage(*place, node["name"], node["type"], possible, seen, ticked)
                found.files[file.path, file.digest] = file
        except OSError as error:
            raise UserError(f"{relative(path)!r} cannot be read: {error.strerror}", code="unreadable") from error
        except (ValueError, KeyError, TypeError) as error:
            message = f"{relative(path)!r} holds no tree coverage: {type(error).__name__}: {error}"
            raise UserError(message, hint="valid: what --tree-coverage-json has written", code="format") from error
        return found


def digest_of(path: Path) -> str:
    """Return the digest of a file's text, "" if it cannot be read."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    except OSError:
        return ""


# ---- details --------------------------------------------------------------------------------------------------------


def _file(name: str, files: Iterable[Path]) -> Path | None:
    """Return which of a tree's files a place names, seen from wherever it was loaded."""
    exact = (path for path in files if name in (relative(path), str(path)))
    return next(exact, None) or next((path for path in files if str(path).endswith(f"/{name}")), None)


def _results(tree: Tree) -> list[Results]:
    """Return what each node of a tree can answer."""
    found: list[Results] = [ANYTHING] * len(tree.nodes)
    below: dict[int, list[int]] = {}
    for index in reversed(range(len(tree.nodes))):
        node = tree.nodes[index]
        below.setdefault(node.parent, []).insert(0, index)
        inner = below.get(index, [])
        children = tuple(found[child] for child in inner if not tree.nodes[child].branch)
        branches = {tree.nodes[child].branch: found[child] for child in inner if tree.nodes[child].branch}
        try:
            found[index] = node.type.possible_results(node.values, Below(children, branches))
        except (LookupError, TypeError, AttributeError):  # a sub-tree by itself lacks values and nodes
            found[index] = ANYTHING
    return found


def _plain(file: FileCoverage) -> dict[str, Any]:
    nodes = [
        {
            "line": node.line,
            "column": node.column,
            "name": node.name,
            "type": node.type,
            "possible": list(node.counted),
            "seen": [deed for deed in DEEDS if deed in node.seen],
            "ticked": node.ticked,
        }
        for node in file.ordered
    ]
    return {"digest": file.digest, "nodes": nodes}
