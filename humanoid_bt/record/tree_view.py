"""The tree: a graph with live colours, and one lane per node in a state timeline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import rerun as rr

from humanoid_bt.core.errors import HumanoidBtError, nearest
from humanoid_bt.record.columns import lane, send, send_sets
from humanoid_bt.tree.show.layout import fan
from humanoid_bt.tree.show.looks import STATUS_COLORS, STATUS_GLYPHS

GRAPH = "tree/graph"

_GLYPHS = frozenset("✓✗▶●○→")  # beyond ASCII the viewer's font has few glyphs, and some missing ones crash it
_CHARACTER = 7.2  # width of a label's character in the graph's units
_ROW = 44.0  # distance of labels below each other
_GAP = 46.0  # free space between a label and its children


class NodeView(Protocol):
    """What is shown of a tree's node; the nodes come parents first."""

    @property
    def path(self) -> str:
        """Unique in the tree."""

    @property
    def name(self) -> str:
        """As its author called it."""

    @property
    def type_name(self) -> str:
        """As tree files call its type."""

    @property
    def kind(self) -> str:
        """One of composite, decorator, condition, action, skill."""

    @property
    def parent(self) -> int | None:
        """Index of its parent, None or negative for the root."""


@dataclass(frozen=True)
class TreeView:
    """What is shown of a tree.

    Attributes:
        nodes: all nodes, each after its parent, children in their order.
        source: text of the tree file.
        file: its name.
    """

    nodes: Sequence[NodeView]
    source: str = ""
    file: str = ""


def printable(text: str) -> str:
    """Return a text with only the characters that the viewer can draw."""
    return "".join(c if c in _GLYPHS or " " <= c <= "~" or c == "\n" else "?" for c in text)


class TreeStatus:
    """Draws a tree and its nodes' status; another tree may take its place.

    Args:
        nodes: all nodes, each after its parent.
        first_lane: number of the first node's lane in the state timeline.

    Attributes:
        size: width and height of the largest graph so far, whose corner is at the origin.
    """

    def __init__(self, nodes: Sequence[NodeView], first_lane: int = 0) -> None:
        self._first_lane = first_lane
        self._lanes: dict[str, str] = {}  # node path -> entity, of all trees so far
        self.size = (0.0, 0.0)
        self._take(nodes)

    def _take(self, nodes: Sequence[NodeView]) -> None:
        self._index = {node.path: index for index, node in enumerate(nodes)}
        self._parents = [_parent(node) for node in nodes]
        self._labels = [_label(node) for node in nodes]
        sizes = [(_CHARACTER * (2 + max(map(len, label.split("\n")))), _ROW) for label in self._labels]
        boxes = fan([-1 if parent is None else parent for parent in self._parents], sizes, (_GAP, 0.0))
        self._positions = [(box.x + box.width / 2, box.y + box.height / 2) for box in boxes]
        self.size = (
            max(self.size[0], *(box.right for box in boxes)),
            max(self.size[1], *(box.bottom for box in boxes)),
        )
        for node in _lane_order(nodes, self._parents):
            self._lanes.setdefault(node.path, lane(self._first_lane + len(self._lanes), node.name))
        self._paths = [node.path for node in nodes]
        self._status = ["INVALID"] * len(nodes)
        self._changes: list[tuple[float, int, str]] = []

    def log_static(self, stream: Any) -> None:
        """Write the graph as it is at the start, and the looks of the states."""
        self._send_tree(stream, 0.0, self._paths)

    def show(self, stream: Any, time: float, nodes: Sequence[NodeView]) -> None:
        """Write that other nodes take the place of those so far; nodes of the same path keep their lanes.

        Args:
            stream: the rerun recording stream.
            time: engine time [s].
            nodes: all nodes of the tree, each after its parent.
        """
        self.flush(stream)
        for path, status in zip(self._paths, self._status, strict=True):
            if status != "INVALID":
                self.change(time, path, "INVALID")
        self.flush(stream)
        known = set(self._lanes)
        self._take(nodes)
        self._send_tree(stream, time, [path for path in self._paths if path not in known])

    def _send_tree(self, stream: Any, time: float, new: Sequence[str]) -> None:
        """Write the graph's shape from a time on, and begin the lanes of nodes that are new."""
        count = [len(self._labels)]
        edges = [(str(parent), str(index)) for index, parent in enumerate(self._parents) if parent is not None]
        ids = [str(index) for index in range(len(self._labels))]
        shape = rr.GraphNodes.columns(node_ids=ids, positions=self._positions)
        send_sets(stream, GRAPH, [time], shape, count)
        send_sets(stream, GRAPH, [time], rr.GraphEdges.columns(edges=edges), [len(edges)])
        self._send_graph(stream, [time], [list(self._status)])
        stream.log(GRAPH, rr.GraphNodes.from_fields(show_labels=True), static=True)
        stream.log(GRAPH, rr.GraphEdges.from_fields(graph_type="directed"), static=True)
        states = list(STATUS_COLORS)
        look = rr.StateConfiguration(
            values=states,
            labels=[state.lower() for state in states],
            colors=list(STATUS_COLORS.values()),
            visible=[state != "INVALID" for state in states],
        )
        for path in new:
            stream.log(self._lanes[path], look, static=True)
            send(stream, self._lanes[path], [time], rr.StateChange.columns(state=["INVALID"]))

    def change(self, time: float, path: str, status: str) -> None:
        """Take a node's change of status.

        Raises:
            HumanoidBtError: there is no such node or status.
        """
        if path not in self._index:
            raise HumanoidBtError(f"the tree has no node {path!r}; {nearest(path, self._index)}")
        if status not in STATUS_COLORS:
            raise HumanoidBtError(f"no status {status!r}; {nearest(status, STATUS_COLORS)}")
        self._changes.append((time, self._index[path], status))

    def flush(self, stream: Any) -> None:
        """Write the changes since the last flush."""
        frames: dict[float, list[str]] = {}
        lanes: dict[int, list[tuple[float, str]]] = {}
        for time, index, status in self._changes:
            self._status[index] = status
            frames[time] = list(self._status)
            lanes.setdefault(index, []).append((time, status))
        if frames:
            self._send_graph(stream, list(frames), list(frames.values()))
        for index, changes in lanes.items():
            columns = rr.StateChange.columns(state=[status for _, status in changes])
            send(stream, self._lanes[self._paths[index]], [time for time, _ in changes], columns)
        self._changes = []

    def _send_graph(self, stream: Any, times: Sequence[float], frames: Sequence[Sequence[str]]) -> None:
        columns = rr.GraphNodes.columns(
            colors=[STATUS_COLORS[status] for frame in frames for status in frame],
            labels=[
                f"{STATUS_GLYPHS[status]} {label}"
                for frame in frames
                for status, label in zip(frame, self._labels, strict=True)
            ],
        )
        send_sets(stream, GRAPH, times, columns, [len(frame) for frame in frames])


def _parent(node: NodeView) -> int | None:
    return None if node.parent is None or node.parent < 0 else node.parent


def _label(node: NodeView) -> str:
    name = node.name if node.name == node.type_name else f"{node.name}\n({node.type_name})"
    return printable(name)


def _lane_order(nodes: Sequence[NodeView], parents: Sequence[int | None]) -> list[NodeView]:
    """Return the nodes in the order of their lanes: leaves first, for what they do is the story of a run."""
    inner = set(parents)
    return [nodes[index] for index in sorted(range(len(nodes)), key=lambda index: (index in inner, index))]
