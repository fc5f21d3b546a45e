"""A tree in plain py_trees ticks the nodes that the tree itself ticks."""

from __future__ import annotations

from pathlib import Path

import py_trees
import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.bench.plain import empty_leaves, plain_copy
from humanoid_bt.core.errors import Place
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.node_type import NodeType
from humanoid_bt.tree.ticking.tick import Branch, Seen, tick
from humanoid_bt.tree.tree import Tree
from tests.tree.helpers import Run, make_workspace, run, seen

SHAPES = {
    "fetch-like": "{emergency_stop: {watchdog: {percept: target, max_age: 1, on_stale: idle, "
    "reactive_selector: [{reactive_sequence: "
    "[{confident: {percept: target, above: 0.6}}, {approach: {target: target}}]}, idle]}}}",
    "stale": "{emergency_stop: {watchdog: {percept: nothing, max_age: 1, on_stale: idle, act: {}}}}",
    "memory": "{sequence: [{act: {name: a, script: s}}, {act: {name: b}}]}",
    "decorators": "{retry: {attempts: 3, timeout: {duration: 9, inverter: {act: {script: s}}}}}",
    "inverted": "{reactive_sequence: [{inverter: {act: {name: a, script: f}}}, {act: {name: b}}]}",
    "parallel": "{parallel: [{act: {name: a}}, {act: {name: b}}]}",
}


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    return make_workspace(tmp_path / "project")


def ticked(root: Behaviour) -> list[str]:
    """Tick with py_trees' own means and return the nodes it visits."""
    return [node.name for node in root.tick()]


@pytest.mark.parametrize("shape", SHAPES)
def test_it_ticks_the_same_nodes(workspace: Workspace, shape: str) -> None:
    under_test = run(workspace, SHAPES[shape])
    under_test.tick(seen(0.0))
    under_test.tick(seen(0.0))
    empty_leaves(under_test.tree)
    copy = plain_copy(under_test.tree)
    assert all(type(node).__module__.startswith("py_trees.") for node in copy.iterate())
    copy.tick_once()  # with memory, it goes on from here
    for _ in range(3):
        expected = Seen()
        tick(under_test.tree.root, expected)
        assert ticked(copy) == [node.name for node in expected]


def test_it_can_take_the_leaves_themselves(workspace: Workspace) -> None:
    under_test = run(workspace, "{reactive_sequence: [{inverter: {act: {name: a, script: f}}}, {act: {name: b}}]}")
    under_test.tick()
    copy = plain_copy(under_test.tree, same_leaves=True)
    under_test.log.clear()
    assert ticked(copy) == ["a", "inverter", "b", "reactive_sequence"]
    assert ("start", "a") in under_test.log and ("FAILURE", "a") in under_test.log


class Pick(Branch, py_trees.composites.Composite):
    """A composite of a kind that py_trees does not have: it ticks some of its children."""

    def __init__(self, children: list[Behaviour], picked: list[int]) -> None:
        super().__init__("pick", children)  # type: ignore[call-arg]  # py_trees' own composite
        self.picked = picked

    def advance(self, seen: Seen) -> Status:
        return [tick(self.children[index], seen) for index in self.picked][-1]


@pytest.mark.parametrize("letters, picked", [("srs", [1]), ("ssr", [0, 2]), ("ffr", [0, 1, 2]), ("fsr", [0, 1])])
def test_of_a_strange_composite_it_ticks_what_was_ticked(workspace: Workspace, letters: str, picked: list[int]) -> None:
    inner = run(workspace, f"{{parallel: [{', '.join(f'{{act: {{script: {letter}}}}}' for letter in letters)}]}}")
    acts = [node.behaviour for node in inner.tree.nodes[1:]]
    for act in acts:
        act.parent = None
    pick = Pick(acts, picked)
    tick(pick, Seen())
    copy = plain_copy(_with_root(inner, pick))
    assert ticked(copy) == [acts[index].name for index in picked] + ["pick"]


def _with_root(inner: Run, root: Behaviour) -> Tree:
    node_type = NodeType("pick", "composite", type(root), "", {})
    first = Node("t/pick", "pick", node_type, {}, Place("t.yaml"), root, -1)
    return Tree("t", "", Path("t.yaml"), None, None, {}, "", (first, *inner.tree.nodes[1:]))
