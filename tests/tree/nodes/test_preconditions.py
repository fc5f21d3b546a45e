from __future__ import annotations

import pytest
from py_trees.display import unicode_tree

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import run


@pytest.mark.parametrize(
    ("root", "statuses"),
    [
        # the condition holds for two ticks
        ("{while: {condition: state.time < 0.15, act: {script: s}}}", "rrs"),
        ("{while: {condition: state.time < 0.15, act: {script: r}}}", "rrs"),
        ("{while: {condition: state.time < 0.15, act: {script: sf}}}", "rf"),
        ("{while: {condition: state.time < 0, act: {script: f}}}", "s"),
        ("{guard: {condition: state.time < 0.15, act: {script: rrs}}}", "rrf"),
        ("{guard: {condition: state.time < 0.15, act: {script: rs}}}", "rs"),
        ("{guard: {condition: state.time < 0.15, act: {script: rf}}}", "rf"),
        ("{precondition: {condition: state.time < 0.15, act: {script: rrrs}}}", "rrrs"),
        ("{precondition: {condition: state.time < 0.15, act: {script: ss}}}", "ssf"),
        ("{precondition: {condition: state.time < 0, act: {script: s}}}", "f"),
        # a condition that is a node, and may run
        ("{while: {condition: {act: {name: c, script: ssf}}, act: {script: s}}}", "rrs"),
        ("{while: {condition: {act: {name: c, script: rf}}, act: {script: s}}}", "rs"),
        ("{guard: {condition: {act: {name: c, script: srsf}}, act: {script: rrrrs}}}", "rrrf"),
        ("{precondition: {condition: {act: {name: c, script: rrsf}}, act: {script: rrs}}}", "rrrrs"),
    ],
)
def test_status_of_a_conditional(workspace: Workspace, root: str, statuses: str) -> None:
    assert run(workspace, root).ticks(len(statuses)) == statuses


@pytest.mark.parametrize(("kind", "end"), [("while", "SUCCESS"), ("guard", "FAILURE")])
def test_the_child_is_halted_when_the_condition_no_longer_holds(workspace: Workspace, kind: str, end: str) -> None:
    held = run(workspace, f"{{{kind}: {{condition: state.time < 0.15, act: }}}}")
    held.ticks(3)
    assert held.told() == [("condition", "FAILURE"), ("act", "INVALID"), (kind, end)]
    assert held.log == [("start", "act"), ("INVALID", "act")]
    assert held.feedback(kind) == "its condition does not hold: state.time 0.2 s < 0.15 s"
    assert held.feedback("act") == "halted: its condition does not hold: state.time 0.2 s < 0.15 s"


@pytest.mark.parametrize("kind", ["while", "guard"])
def test_the_child_does_not_run_while_the_condition_runs(workspace: Workspace, kind: str) -> None:
    held = run(workspace, f"{{{kind}: {{condition: {{act: {{name: c, script: srs}}}}, act: }}}}")
    held.ticks(2)
    assert held.log == [("start", "c"), ("SUCCESS", "c"), ("start", "act"), ("start", "c"), ("INVALID", "act")]
    held.tick()
    assert held.log[-1] == ("start", "act")


def test_a_precondition_is_asked_only_before_its_child_starts(workspace: Workspace) -> None:
    asked = run(workspace, "{precondition: {condition: {act: {name: c, script: ssf}}, act: {script: rsrs}}}")
    assert asked.ticks(5) == "rsrsf"
    assert [event for event, name in asked.log if name == "c"] == ["start", "SUCCESS"] * 2 + ["start", "FAILURE"]
    assert asked.told() == [("c", "FAILURE"), ("act", "INVALID"), ("precondition", "FAILURE")]


@pytest.mark.parametrize("kind", ["while", "guard", "precondition"])
def test_a_halt_reaches_child_or_condition(workspace: Workspace, kind: str) -> None:
    halted = run(workspace, f"{{{kind}: {{condition: {{act: {{name: c, script: srr}}}}, act: }}}}")
    halted.tick()
    halted.halt()
    assert halted.told() == [("c", "INVALID"), ("act", "INVALID"), (kind, "INVALID")]
    halted.tick()
    assert halted.told() == [("c", "RUNNING"), (kind, "RUNNING")]
    halted.halt()
    assert halted.told() == [("c", "INVALID"), (kind, "INVALID")]
    assert halted.log[-2:] == [("start", "c"), ("INVALID", "c")]


def test_the_tip_is_the_condition_while_it_decides(workspace: Workspace) -> None:
    held = run(workspace, "{guard: {condition: {act: {name: c, script: srf}}, act: }}")
    tips = []
    for _ in range(3):
        held.tick()
        tips.append(held.tree.root.tip().name)
    assert tips == ["act", "c", "c"]


def test_py_trees_draws_them(workspace: Workspace) -> None:
    drawn = unicode_tree(run(workspace, "{guard: {condition: {act: {name: c}}, act: }}").tree.root)
    assert [line.split()[-1] for line in drawn.splitlines()] == ["guard", "c", "act"]


def test_a_condition_is_required(workspace: Workspace) -> None:
    with pytest.raises(UserError, match="'condition' of 'guard' is missing"):
        run(workspace, "{guard: {act: }}")
