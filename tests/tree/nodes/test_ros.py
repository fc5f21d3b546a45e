"""What is said before the run about leaves that ask other programs; tests/semantics has what they do."""

from __future__ import annotations

import pytest

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.nodes import RosService, Sequence
from humanoid_bt.tree.source.compose import make_tree
from tests.tree.helpers import Run, found, load


def test_what_is_known_before_the_run_is_checked_with_its_places(workspace: Workspace) -> None:
    text = (
        "root:\n  ros_action:\n    action: /a\n    type: x/A\n    timeout: 1 s\n"
        "    goal:\n      a: '{state.time}'\n      b: {c: text}\n"
    )
    (checked,) = Run(load(workspace, text)).calls.checked
    call, places = checked
    assert call.request == {"a": 0, "b": {"c": "text"}}
    assert {path: (place.line, place.column) for path, place in places.items() if path} == {
        "a": (8, 7),
        "b": (9, 7),
        "b.c": (9, 11),
    }


def test_it_commands_nothing_and_needs_no_emergency_stop_and_no_timeout(workspace: Workspace) -> None:
    assert found(workspace, "root: {ros_service: {service: /a, type: x/A}}") == []


@pytest.mark.parametrize(
    ("parameters", "problem"),
    [
        ("request: 3", "2:63 wrong-type 'request' must be a mapping of fields, not a number"),
        ("request: {a: }", "2:66 wrong-type the field 'a' has no value"),
        ("request: {a: '{nobody}'}", "2:67 expression in 'nobody': unknown name 'nobody'"),
        ("response: {a: 3}", "2:68 bad-name 'a' must name a key of the blackboard, not a number"),
    ],
)
def test_mistakes_have_their_place(workspace: Workspace, parameters: str, problem: str) -> None:
    text = f"root: {{ros_service: {{service: /success_0, type: x/A, {parameters}}}}}"
    assert [one[:40] for one in found(workspace, text)] == [problem[:40]]


def test_it_can_be_made_in_python(workspace: Workspace) -> None:
    leaf = RosService("ask", service="/success_0", type="x/A", request={"a": "{1 + 1}"}, response={"b": "n"})
    tree = Run(make_tree(Sequence("s", [leaf]), workspace))
    tree.tick()
    assert tree.calls.asked[0].request == {"a": 2}
    assert [(key.name, key.value) for key in tree.tree.keys] == [("n", 5)]
    assert "request: {a: '{1 + 1}'}" in tree.tree.source
