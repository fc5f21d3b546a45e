"""Ticks and halts, the same for every kind of node."""

from __future__ import annotations

import py_trees

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.tick import INVALID, Seen, halt
from tests.tree.helpers import make_state, run

NESTED = """
emergency_stop:
  reactive_selector:
    - inverter: {act: {name: switch, script: ssf}}
    - retry:
        attempts: 3
        reactive_sequence:
          - act: {name: done, script: s}
          - parallel: [{act: {name: left}}, {timeout: {duration: 9, act: {name: right}}}]
          - act: {name: never}
"""


def test_halt_reaches_each_running_node_once_children_first_and_no_other(workspace: Workspace) -> None:
    nested = run(workspace, f"\n{_indented(NESTED)}")
    nested.tick()
    nested.log.clear()
    nested.tick()
    assert nested.log == [("start", "switch"), ("SUCCESS", "switch"), ("start", "done"), ("SUCCESS", "done")]
    nested.log.clear()
    nested.tick()  # the switch fails, so its inverter succeeds and preempts the rest
    assert nested.log == [("start", "switch"), ("FAILURE", "switch"), ("INVALID", "left"), ("INVALID", "right")]
    told = [name for name, status in nested.told() if status == "INVALID"]
    assert told == ["done", "left", "right", "timeout", "parallel", "reactive_sequence", "retry"]


def test_the_reason_of_a_halt_is_known_to_the_skill_and_told(workspace: Workspace) -> None:
    nested = run(workspace, f"\n{_indented(NESTED)}")
    nested.ticks(3)
    left = next(node.behaviour for node in nested.tree.nodes if node.name == "left")
    assert vars(left)["halt_reason"] == "preempted by 'inverter', which succeeded"
    assert "preempted by 'inverter'" in next(c.feedback for c in nested.changes if c.path.endswith("/left"))


def test_py_trees_visitors_see_every_ticked_node_children_first(workspace: Workspace) -> None:
    nested = run(workspace, "{emergency_stop: {sequence: [{act: {name: a, script: s}}, {act: {name: b}}, idle]}}")
    visitor = py_trees.visitors.SnapshotVisitor()
    managed = py_trees.trees.BehaviourTree(nested.tree.root)
    managed.add_visitor(visitor)
    nested.robot.begin_tick(make_state(), {})
    managed.tick()
    names = [node.name for node in nested.tree.root.iterate() if node.id in visitor.visited]
    assert names == ["a", "b", "sequence", "emergency_stop"]
    assert managed.tip() is not None and managed.tip().name == "b"  # type: ignore[union-attr]  # the same as before
    managed.root.stop(INVALID)
    assert nested.log[-1] == ("INVALID", "b")
    assert all(node.status is INVALID for node in nested.tree.root.iterate())


def test_py_trees_own_way_to_tick_raises_what_a_node_raises(workspace: Workspace) -> None:
    broken = run(workspace, "{sequence: [{act: {script: x}}]}")
    broken.robot.begin_tick(make_state(), {})
    try:
        broken.tree.root.tick_once()
    except RuntimeError as error:
        assert str(error) == "out of order"
    else:
        raise AssertionError("nothing was raised")


def test_a_plain_behaviour_with_its_own_children_is_ticked_and_halted_whole(workspace: Workspace) -> None:
    (workspace.root / "skills" / "opaque.py").write_text(
        "import py_trees\n"
        "class Opaque(py_trees.composites.Sequence):\n"
        "    def __init__(self, name):\n"
        "        inner = py_trees.behaviours.StatusQueue('inner', [py_trees.common.Status.RUNNING], None)\n"
        "        super().__init__(name, True, [inner])\n"
    )
    opaque = run(workspace, "{sequence: [opaque]}")
    assert [node.name for node in opaque.tree.nodes] == ["sequence", "opaque"]
    opaque.tick()
    halt(opaque.tree.root, "test", Seen())
    assert [node.status for node in opaque.tree.root.iterate()] == [INVALID] * 3


def _indented(text: str) -> str:
    return "\n".join(f"  {line}" for line in text.strip().splitlines())
