from __future__ import annotations

import textwrap

import pytest
from py_trees.common import Status

from humanoid_bt.core.errors import HumanoidBtError, UserError
from humanoid_bt.core.messages import Mode
from humanoid_bt.decision.robot import Robot
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.executor import NodeError
from humanoid_bt.tree.ticking.forcing import force
from tests.tree.helpers import Run, load, run, seen

RAISE = "{raise_emergency_stop: {reason: too warm}}"


def ready(workspace: Workspace, root: str) -> tuple[Run, list[tuple[str, str]]]:
    """Return a tree whose robot has an emergency stop, and what is raised there."""
    tree, raised = run(workspace, root), []
    tree.robot = Robot(tree.robot.config, tree.clock, lambda source, reason: raised.append((source, reason)))
    tree.executor.robot = tree.robot
    tree.executor.setup()
    return tree, raised


def test_it_raises_once_with_its_path_as_the_source(workspace: Workspace) -> None:
    tree, raised = ready(workspace, RAISE)
    tree.tick()
    tree.tick()
    assert raised == [("t/raise_emergency_stop", "too warm")]
    assert tree.executor.status.name == "RUNNING"
    assert tree.feedback("raise_emergency_stop") == "raised the emergency stop: too warm"


def test_it_raises_nothing_where_its_result_is_forced(workspace: Workspace) -> None:
    tree, raised = ready(workspace, RAISE)
    force(tree.tree.root, Status.SUCCESS, "forced")
    assert tree.ticks(1) == "s"
    assert raised == []
    tree.tick()
    assert len(raised) == 1


def test_it_succeeds_when_the_stop_was_reset_and_raises_again_when_it_is_ticked_again(workspace: Workspace) -> None:
    tree, raised = ready(workspace, RAISE)
    tree.tick()
    for mode in (Mode.EMERGENCY_STOP, Mode.DAMP):  # it fell, too
        tree.tick(mode=mode, reason="too warm")
        assert tree.executor.status.name == "RUNNING"
    tree.tick()
    assert tree.executor.status.name == "SUCCESS"
    tree.tick()
    assert len(raised) == 2


def test_a_robot_without_an_emergency_stop_is_an_error(workspace: Workspace) -> None:
    tree = run(workspace, RAISE)
    try:
        tree.tick()
    except NodeError as error:
        assert isinstance(error.error, HumanoidBtError)
        assert "of a robot that has none: too warm" in str(error)
    else:
        raise AssertionError("no error")


def test_constant_leaves(workspace: Workspace) -> None:
    assert run(workspace, "{success: }").ticks(2) == "ss"
    assert run(workspace, "{failure: }").ticks(2) == "ff"
    assert run(workspace, "{running: }").ticks(2) == "rr"


# ---- log -----------------------------------------------------------------------------------------------------------


def test_log_tells_a_text_with_values(workspace: Workspace) -> None:
    log = run(workspace, '{log: "{{at}} {state.time + 1 s}, {state.standing}, {1 + 1} {state.gait}"}')
    assert log.ticks(1) == "s"
    assert log.events == [("t/log", "info", "{at} 1 s, true, 2 stand")]
    assert log.feedback("log") == "{at} 1 s, true, 2 stand"


def test_log_has_a_level_and_takes_parameters_and_keys(workspace: Workspace) -> None:
    text = """
        parameters: {who: Ada}
        blackboard: {k: {type: text}}
        root:
          sequence:
            - log: {text: $who, level: warning}
            - log: 'hello {$who}, k is {k}'
            - set_blackboard: {key: k, value: good}
            - log: $k
    """
    log = Run(load(workspace, textwrap.dedent(text)))
    log.tick()
    assert [event[1:] for event in log.events] == [
        ("warning", "Ada"),
        ("info", "hello Ada, k is (not set)"),
        ("info", "good"),
    ]


def test_log_needs_no_watchdog_for_a_percept(workspace: Workspace) -> None:
    log = run(workspace, "{log: 'seen {distance(target)} away'}")
    log.tick()
    log.halt()
    log.tick(seen(0.1, distance=0.75))
    assert [text for _, _, text in log.events] == ["seen (never seen) away", "seen 0.75 m away"]


@pytest.mark.parametrize(
    ("root", "ticks", "times"),
    [
        ("{log: hi}", 3, 3),
        ("{reactive_sequence: [{log: hi}, {act: {script: rrs}}]}", 3, 1),
        ("{reactive_sequence: [{log: hi}, {act: {script: rsrs}}]}", 4, 2),
        ("{sequence: [{log: hi}, {act: {script: rsrs}}]}", 4, 2),
        ("{reactive_sequence: [{inverter: {inverter: {sequence: [{log: hi}]}}}, running]}", 3, 1),
        ("{reactive_selector: [{sequence: [{act: {script: frf}}, {log: hi}]}, running]}", 3, 0),
        ("{reactive_selector: [{reactive_sequence: [{act: {script: sfs}}, {log: hi}, running]}, running]}", 3, 2),
        ("{repeat: {times: 3, log: hi}}", 3, 3),
        ("{retry: {attempts: 3, sequence: [{log: hi}, {act: {script: rrfrrf}}]}}", 6, 2),
    ],
)
def test_log_tells_once_for_each_start(workspace: Workspace, root: str, ticks: int, times: int) -> None:
    log = run(workspace, root)
    log.ticks(ticks)
    assert len(log.events) == times


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{distanc(target)}", "unknown function 'distanc'"),
        ("{nothing}", "unknown name 'nothing'"),
        ("{1 +}", "'1 \\+' is no expression"),
        ("{}", "'' is no expression"),
        ("open {1", "a brace of 'open {1' stands alone, at '{1'"),
        ("close }", "a brace of 'close }' stands alone, at '}'"),
    ],
)
def test_a_mistake_in_a_text_is_refused(workspace: Workspace, text: str, message: str) -> None:
    with pytest.raises(UserError, match=message):
        run(workspace, f"{{log: '{text}'}}")


def test_a_log_without_text_is_refused(workspace: Workspace) -> None:
    with pytest.raises(UserError, match="'text' must be text, not a list"):
        run(workspace, "{log: {text: [1]}}")
    with pytest.raises(UserError, match="'text' of 'log' is missing"):
        run(workspace, "{log: }")
