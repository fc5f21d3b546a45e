from __future__ import annotations

import pytest

from humanoid_bt.core.errors import ControlLost, ResourceConflict
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.nodes.on_error import OnError
from humanoid_bt.tree.ticking.executor import NodeError
from humanoid_bt.tree.ticking.tick import RUNNING
from tests.tree.helpers import run

BROKEN = """
on_error:
  parallel:
    - act: {name: before}
    - sequence:
        - act: {name: done, script: s}
        - act: {name: bad, script: rx}
    - act: {name: after}
"""


def test_an_exception_becomes_a_failure_and_everything_below_is_halted(workspace: Workspace) -> None:
    caught = run(workspace, BROKEN.replace("\n", "\n  "))
    assert caught.ticks(2) == "rf"
    below = ["bad", "before", "done", "sequence", "after", "parallel"]
    assert caught.told() == [(name, "INVALID") for name in below] + [("on_error", "FAILURE")]
    assert sorted(caught.log) == sorted(
        [(event, name) for name in ("before", "bad", "after") for event in ("start", "INVALID")]
        + [("start", "done"), ("SUCCESS", "done")]
    )
    assert caught.feedback("on_error") == "'bad' raised RuntimeError: out of order"
    assert caught.feedback("before") == "halted: 'bad' raised RuntimeError: out of order"
    assert caught.ticks(1) == "f"  # it raises again at once: its script has come to its end


def test_it_is_told_as_a_warning_with_path_place_and_line(workspace: Workspace) -> None:
    caught = run(workspace, "{on_error: {inverter: {act: {name: bad, script: x}}}}")
    caught.tick()
    [(source, level, text)] = caught.events
    assert (source, level) == ("t/on_error", "warning")
    assert text.startswith("caught: ")
    assert "t.yaml:2:30: the node 't/on_error/inverter/bad' raised RuntimeError: out of order, raised at " in text
    assert "test_skills.py:" in text


def test_of_the_same_one_again_and_again_the_first_the_tenth_and_so_on_is_told(workspace: Workspace) -> None:
    caught = run(workspace, "{retry: {attempts: -1, on_error: {act: {script: " + "x" * 30 + "fx}}}}")
    caught.ticks(32)
    told = [text.split(": ")[0] for _, _, text in caught.events]
    assert told == ["caught", "caught for the 10th time"]
    other = run(
        workspace, "{repeat: {force_success: {on_error: {sequence: [{act: {script: sx}}, {act: {script: x}}]}}}}"
    )
    other.ticks(4)
    assert [text.split(": ")[0] for _, _, text in other.events] == ["caught", "caught"]


def test_one_that_comes_after_another_is_counted_anew(workspace: Workspace) -> None:
    caught = run(workspace, "{retry: {attempts: -1, on_error: {act: {script: " + "xn" * 3 + "x" * 10 + "}}}}")
    caught.ticks(16)
    told = [text.split(": ")[0] for _, _, text in caught.events]
    assert told == ["caught"] * 7 + ["caught for the 10th time"]


def test_of_two_that_come_together_again_and_again_each_is_counted(workspace: Workspace) -> None:
    pair = "{parallel: [{bad_end: {script: r}}, {act: {script: rx}}]}"
    caught = run(workspace, f"{{repeat: {{force_success: {{on_error: {pair}}}}}}}")
    caught.ticks(24)
    told = [text.split(": ")[0] for _, _, text in caught.events]
    assert told == ["caught"] * 2 + ["caught for the 10th time"] * 2


def test_what_is_below_starts_afresh_the_next_time(workspace: Workspace) -> None:
    caught = run(workspace, "{on_error: {sequence: [{act: {name: a, script: s}}, {act: {name: b, script: xrs}}]}}")
    assert caught.ticks(3) == "frs"
    assert [name for event, name in caught.log if event == "start"] == ["a", "b", "a", "b"]


def test_a_failed_node_that_raises_the_next_time_is_told(workspace: Workspace) -> None:
    caught = run(workspace, "{retry: {attempts: -1, on_error: {act: {script: fxf}}}}")
    caught.tick()
    assert caught.told() == [("act", "FAILURE"), ("on_error", "FAILURE"), ("retry", "RUNNING")]
    caught.tick()
    assert caught.told() == [("act", "INVALID")]
    caught.tick()
    assert caught.told() == [("act", "FAILURE")]


def test_what_runs_below_a_branch_that_raises_is_told_too(workspace: Workspace) -> None:
    write = (
        "{if: {condition: state.time < 0.15, then: {set_blackboard: {key: k, value: a}}, else: {clear_blackboard: k}}}"
    )
    root = f"{{on_error: {{reactive_sequence: [{write}, {{reactive_switch: {{value: k, cases: {{a: {{act: }}}}}}}}]}}}}"
    caught = run(workspace, root)
    assert caught.ticks(3) == "rrf"
    assert ("act", "INVALID") in caught.told()
    assert {status for _, status in caught.told()} == {"INVALID", "FAILURE"}
    assert caught.log == [("start", "act"), ("INVALID", "act")]


def test_its_skills_command_nothing_any_more(workspace: Workspace) -> None:
    broken = "{on_error: {parallel: [idle, {act: {script: rx}}]}}"
    caught = run(workspace, f"{{emergency_stop: {{selector: [{broken}, {{act: {{name: instead}}}}]}}}}")
    assert caught.tick().targets
    assert not caught.tick().targets
    assert caught.executor.status.name == "RUNNING"


@pytest.mark.parametrize("leaf", ["act: {script: n}", "bad_start: ", "act: {script: x}"])
def test_what_counts_as_an_error(workspace: Workspace, leaf: str) -> None:
    caught = run(workspace, f"{{selector: [{{on_error: {{{leaf}}}}}, {{act: {{name: instead}}}}]}}")
    assert caught.ticks(1) == "r"
    assert len(caught.events) == 1


@pytest.mark.parametrize("error", [ResourceConflict("two"), ControlLost("gone")])
def test_what_is_not_caught_ends_the_run(workspace: Workspace, error: Exception) -> None:
    caught = run(workspace, "{on_error: {parallel: [{act: {name: other}}, {act: {name: bad}}]}}")

    def update() -> None:
        raise error

    caught.tree.nodes[-1].behaviour.update = update
    with pytest.raises(NodeError):
        caught.tick()
    assert caught.events == []
    assert caught.log[-1] == ("INVALID", "other")


def test_a_keyboard_interrupt_is_never_caught(workspace: Workspace) -> None:
    caught = run(workspace, "{on_error: {act: }}")

    def update() -> None:
        raise KeyboardInterrupt

    caught.tree.nodes[-1].behaviour.update = update
    with pytest.raises(KeyboardInterrupt):
        caught.tick()


def test_two_owners_of_a_resource_end_the_run(workspace: Workspace) -> None:
    pair = "{parallel: [{idle: {name: one}}, {act: {name: two}}]}"
    two = run(workspace, f"{{emergency_stop: {{on_error: {pair}}}}}")
    behaviour = two.tree.nodes[-1].behaviour
    behaviour.robot = RobotHandle(two.robot, "two", ("gaze",))
    behaviour.update = lambda: behaviour.robot.look_at([1, 0, 0]) or RUNNING
    with pytest.raises(ResourceConflict):
        two.tick()
    assert two.events == []


# ---- errors while something is halted ------------------------------------------------------------------------------

BAD_ENDS = "{parallel: [{bad_end: {name: one}}, {act: {name: good}}, {bad_end: {name: two}}]}"


def test_an_error_of_a_preempted_node_is_caught(workspace: Workspace) -> None:
    root = "{on_error: {reactive_selector: [{act: {name: first, script: fr}}, {bad_end: {name: second}}]}}"
    caught = run(workspace, root)
    assert caught.ticks(2) == "rf"
    assert caught.log[-2:] == [("INVALID", "second"), ("INVALID", "first")]
    assert "cannot stop" in caught.feedback("on_error")


def test_errors_while_it_is_halted_from_above_are_caught(workspace: Workspace) -> None:
    caught = run(workspace, f"{{timeout: {{duration: 0.1 s, on_error: {BAD_ENDS}}}}}")
    assert caught.ticks(2) == "rf"
    assert caught.log[-3:] == [("INVALID", "one"), ("INVALID", "good"), ("INVALID", "two")]
    assert caught.told()[-3:] == [("parallel", "INVALID"), ("on_error", "INVALID"), ("timeout", "FAILURE")]
    assert ["cannot stop" in text for _, _, text in caught.events] == [True, True]


def test_errors_while_the_whole_tree_is_halted_are_caught(workspace: Workspace) -> None:
    caught = run(workspace, f"{{on_error: {BAD_ENDS}}}")
    caught.tick()
    caught.halt()
    assert caught.log[-3:] == [("INVALID", "one"), ("INVALID", "good"), ("INVALID", "two")]
    assert len(caught.events) == 2


def test_errors_beside_it_are_not_caught(workspace: Workspace) -> None:
    caught = run(workspace, "{parallel: [{on_error: {bad_end: {name: below}}}, {bad_end: {name: beside}}]}")
    caught.tick()
    with pytest.raises(NodeError, match="/beside' raised"):
        caught.halt()
    assert len(caught.events) == 1
    assert caught.log[-2:] == [("INVALID", "below"), ("INVALID", "beside")]


def test_the_inner_of_two_acts(workspace: Workspace) -> None:
    root = "{on_error: {name: outer, parallel: [{on_error: {name: inner, bad_end: }}, {act: {script: rx}}]}}"
    caught = run(workspace, root)
    assert caught.ticks(2) == "rf"
    assert [source.rpartition("/")[2] for source, _, _ in caught.events] == ["inner", "outer"]


def test_without_an_executor_it_goes_to_the_log(workspace: Workspace, caplog: pytest.LogCaptureFixture) -> None:
    child = run(workspace, "{act: {script: x}}").tree.root
    root = OnError("on_error", child)
    root.tick_once()
    assert root.status.name == "FAILURE"
    assert "on_error caught what act raised" in caplog.text
