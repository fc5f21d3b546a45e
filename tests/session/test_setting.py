"""Keys and parameters that are set, and nodes that are forced, while a run goes on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from py_trees.common import Status

import humanoid_bt as hbt

SETTABLE = """\
format: 1
parameters: {patience: 1 s, goal: 3}
blackboard: {n: 0, far: 2 m}
root:
  emergency_stop:
    sequence:
      - timeout: {duration: $patience, walk: }
      - condition: n < goal and far < 9 m
      - wave: {hand: left}
      - retry: {attempts: 2, give_up: }
      - set_blackboard: {name: free, key: free, expression: n}
      - parallel: [success]
      - for_each: {item: [a, b], items: [[1, 2]], log: "{a} {b}"}
      - log: "{free}"
"""

pytestmark = pytest.mark.usefixtures("in_project")


@pytest.fixture
def settable(project: Path) -> hbt.Session:
    (project / "trees" / "settable.yaml").write_text(SETTABLE, encoding="utf-8")
    return hbt.Session("settable")


def test_keys_and_parameters_are_set_in_the_units_of_trees(settable: hbt.Session) -> None:
    with settable as session:
        session.step()
        session.set("n", "2", source="keyboard")
        session.set("far", "45 cm")
        session.set("timeout.duration", "400 ms")
        session.set("retry.attempts", 3)
        assert dict(session.blackboard) == {"n": 2, "far": 0.45}
        session.run_until(0.5)
        assert session.node("walk").feedback == "halted: timed out after 0.4 s"
    told = [event["text"] for event in session.report.events]
    assert told[:4] == [
        "set n = 2 by keyboard",
        "set far = 0.45 m by program",
        "set settable/emergency_stop/sequence/timeout.duration = 0.4 s by program",
        "set settable/emergency_stop/sequence/retry.attempts = 3 by program",
    ]


def test_a_parameter_of_the_tree_is_set_where_it_was_given(settable: hbt.Session) -> None:
    with settable as session:
        session.step()
        session.set("patience", "0.3 s")
        session.run_until(0.4)
    assert session.node("walk").feedback == "halted: timed out after 0.3 s"


SHARES = """\
format: 1
parameters: {patience: 40 ms}
blackboard: {n: 0}
root:
  sequence:
    - set_blackboard: {key: n, expression: n + 1}
    - timeout: {duration: $patience, force_success: {subtree: {tree: shared}}}
"""
SHARED = "format: 1\nsubtree: true\nparameters: {patience: 60 ms}\nroot: {wait: {duration: $patience}}\n"


@pytest.fixture
def shares(project: Path) -> hbt.Session:
    for name, text in {"shares": SHARES, "shared": SHARED}.items():
        (project / "trees" / f"{name}.yaml").write_text(text, encoding="utf-8")
    return hbt.Session("shares")


def test_a_parameter_of_the_tree_is_none_of_its_sub_trees_that_is_called_so(shares: hbt.Session) -> None:
    with shares as session:
        session.step()
        session.set("patience", "5 s")
        session.run_until(1.0)
    assert (session.outcome, session.node("wait").feedback) == ("success", "waited 0.06 s")


def test_a_tree_begins_with_what_was_set_before_it_and_not_with_what_was_set_since(shares: hbt.Session) -> None:
    shares.set("n", 5)
    (key,) = shares.tree.keys
    with shares as session:
        session.step()
        assert session.blackboard["n"] == 6
        session.set("n", 9)
        assert (session.blackboard["n"], key.initial) == (9, 5)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("m", 1, "the tree has no key or parameter 'm'"),
        ("far", "2 s", "m, cm, mm"),
        ("far", ".inf", "'far' must be finite"),
        ("free", ".inf", "'free' must be finite, not inf"),
        ("wave.times", "0", "'times'"),
        ("retry.attempts", 0, "attempts = 0: error: 'attempts' must be at least 1, or -1 for ever"),
        ("parallel.failure", 2, "'failure' needs 2 of 1 children"),
        ("for_each.items", [[1, 2], []], "item 2 must be a list with at most 2 parts (a, b): []"),
        ("free.value", 3, "it needs either 'value' or 'expression'"),
        ("retry.attempt", 2, "did you mean 'attempts'?"),
        ("rety.attempts", 2, "did you mean 'retry'?"),
        ("goal", 7, "the parameter 'goal' must be known before the run: 'settable/emergency_stop/sequence/condition'"),
        ("condition.expression", "n < 1", "must be known before the run"),
        ("wave.hand", "right", "it decides what the node commands"),
    ],
)
def test_what_cannot_be_set_is_refused(settable: hbt.Session, name: str, value: Any, said: str) -> None:
    with settable as session:
        session.step()
        with pytest.raises(hbt.UserError) as told:
            session.set(name, value)
        assert said in str(told.value)
        session.step()
    assert not [event for event in session.report.events if event["text"].startswith("set ")]


@pytest.mark.parametrize(
    ("root", "parameter", "value", "ends"),
    [
        ("retry: {attempts: 5, give_up: }", "retry.attempts", 2, "failure"),
        ("repeat: {times: 5, name: retry, success: }", "retry.times", 2, "success"),
        ("parallel: {success: 2, children: [success, running]}", "parallel.success", "one", "success"),
        ("parallel: {failure: 2, children: [failure, running]}", "parallel.failure", 1, "failure"),
        ("for_each: {item: n, items: [a, b, c, d], log: '{n}'}", "for_each.items", "[x]", "success"),
    ],
)
def test_a_limit_is_set_behind_what_was_counted(
    project: Path, root: str, parameter: str, value: Any, ends: str
) -> None:
    (project / "trees" / "limit.yaml").write_text(f"format: 1\nroot: {{{root}}}\n", encoding="utf-8")
    with hbt.Session("limit") as session:
        for _ in range(3):
            session.step()
        session.set(parameter, value)
        session.run_until(0.2)
        assert session.outcome == ends


def test_a_leaf_is_forced_once(settable: hbt.Session) -> None:
    with settable as session:
        session.run_until(0.1)
        session.force("walk", "failure")
        session.step()
        walk = session.node("walk")
        assert (walk.status, walk.feedback) == (Status.FAILURE, "forced to FAILURE by program")
    assert session.outcome == "failure"
    told = [event["text"] for event in session.report.events]
    assert "forced settable/emergency_stop/sequence/timeout/walk to FAILURE by program" in told


def test_a_branch_is_forced_and_what_runs_below_it_is_halted(settable: hbt.Session) -> None:
    with settable as session:
        session.run_until(0.1)
        session.pause()
        session.force("timeout", Status.SUCCESS, source="keyboard")
        session.wait(0.1)
        assert session.node("walk").status is Status.RUNNING  # its next tick, not before
        session.step()
        assert session.node("timeout").status is Status.SUCCESS
        assert session.node("walk").feedback == "halted: forced to SUCCESS by keyboard"
        assert session.node("wave").status is Status.RUNNING


@pytest.mark.parametrize("before", [[], [Status.FAILURE, Status.FAILURE]])
def test_it_is_forced_once_whatever_was_forced_before_in_its_place(project: Path, before: list[Status]) -> None:
    (project / "trees" / "again.yaml").write_text("format: 1\nroot: {repeat: {pause: }}\n", encoding="utf-8")
    with hbt.Session("again") as session:
        for status in (*before, Status.SUCCESS):
            session.force("pause", status)  # before it ever ran
        session.step()
        assert session.node("pause").status is Status.SUCCESS
        session.step()
        assert (session.node("pause").status, session.node("pause").feedback) == (Status.RUNNING, "waiting")


@pytest.mark.parametrize(("path", "status", "said"), [("walc", "FAILURE", "'walk'"), ("walk", "RUNNING", "SUCCESS, ")])
def test_what_cannot_be_forced_is_refused(path: str, status: str, said: str) -> None:
    with hbt.Session("walk") as session:
        session.step()
        with pytest.raises(hbt.UserError, match=said):
            session.force(path, status)
