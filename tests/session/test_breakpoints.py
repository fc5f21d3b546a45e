"""Breakpoints: where a run pauses, what holds there, and what is none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from py_trees.common import Status

import humanoid_bt as hbt
from humanoid_bt.core.messages import Gait

LIMITED = "format: 1\nroot: {emergency_stop: {timeout: {duration: 0.4 s, walk: }}}\n"
COUNT = """\
format: 1
parameters: {goal: 3}
blackboard: {n: 0}
root:
  while:
    condition: n < goal
    sequence:
      - set_blackboard: {key: n, expression: n + 1}
      - pause: {name: one, duration: 20 ms}
      - retry: {attempts: 2, give_up: }
"""
REPEATED = """\
format: 1
root:
  repeat:
    times: 2
    sequence:
      - pause: {name: step (v1.2), duration: 20 ms}
      - force_success: {parallel: [{pause: {name: brief, duration: 1 s}}, failure]}
"""
FREE = """\
format: 1
parameters: {patience: {default: 2 s, unit: s}}
blackboard: {n: 1}
root:
  sequence:
    - wait: {name: first, duration: 0.1 s}
    - wait: {name: second, duration: $patience}
    - set_blackboard: {key: found, value: 1}
    - condition: found == n
"""

pytestmark = pytest.mark.usefixtures("in_project")


def stops(session: hbt.Session, until: float = 10.0) -> list[tuple[str, str]]:
    """Run to the end, or until a time [s]; return where it paused, and why."""
    found: list[tuple[str, str]] = []
    while session.time < until - 1e-6 and not session.outcome:
        session.run_until(until)
        if session.paused is not None:
            found.append((session.paused.source, session.paused.reason))
            session.resume()
    return found


@pytest.fixture
def count(project: Path) -> hbt.Session:
    (project / "trees" / "count.yaml").write_text(COUNT, encoding="utf-8")
    return hbt.Session("count")


@pytest.fixture
def free(project: Path) -> hbt.Session:
    (project / "trees" / "free.yaml").write_text(FREE, encoding="utf-8")
    return hbt.Session("free")


@pytest.mark.parametrize(
    ("where", "found"),
    [
        ("one", [("break at count/while/sequence/one", "RUNNING: waiting")]),
        ("sequence/one=success", [("break at count/while/sequence/one", "SUCCESS: waited")]),
        ("sequence=FAILURE", [("break at count/while/sequence", "FAILURE")]),
        ("give_up=RUNNING", []),
        ("n == goal - 2", [("break at n == goal - 2", "n 1 == 1")]),
        ("is_set(n) and state.standing and n > 7", []),
    ],
)
def test_a_run_pauses_at_its_breakpoints(count: hbt.Session, where: str, found: list[tuple[str, str]]) -> None:
    with count:
        count.break_at(where)
        assert count.breakpoints == (where,)
        assert stops(count) == found
    assert count.report.outcome == "failure"


def test_the_command_of_the_tick_at_a_breakpoint_is_withheld() -> None:
    with hbt.Session("walk") as session:
        session.break_at("walk")
        session.run_until(lambda s: s.paused)
        session.wait(0.5)
        assert session.node("walk").status is Status.RUNNING
        assert session.state.stance[0] == pytest.approx(0.0, abs=0.01)
        session.clear_breakpoints()
        session.resume()
        session.run_until(lambda s: s.state.gait is Gait.STEP, timeout=1.0)
        assert session.state.gait is Gait.STEP


def test_a_halt_is_a_breakpoint_but_not_that_of_the_end(project: Path) -> None:
    (project / "trees" / "limited.yaml").write_text(LIMITED, encoding="utf-8")
    with hbt.Session("limited") as session:
        session.break_at("walk=halted")
        assert stops(session) == [("break at limited/emergency_stop/timeout/walk", "halted: timed out after 0.4 s")]
    with hbt.Session("walk") as ends:
        ends.break_at("walk=HALTED")
        ends.step()
    assert ends.paused is None


@pytest.mark.parametrize(
    ("where", "found"),
    [
        ("step (v1.2)", ["RUNNING: waiting", "RUNNING: waiting"]),
        ("step (v1.2)=SUCCESS", ["SUCCESS: waited", "SUCCESS: waited"]),
        ("step (v1.2)=HALTED", []),  # that its parent starts anew halts nothing
        ("brief=HALTED", ["halted: 'parallel' failed"] * 2),  # in the tick in which it starts
    ],
)
def test_a_breakpoint_is_at_a_node_whatever_its_name(project: Path, where: str, found: list[str]) -> None:
    (project / "trees" / "repeated.yaml").write_text(REPEATED, encoding="utf-8")
    with hbt.Session("repeated") as session:
        session.break_at(where)
        assert [reason for _, reason in stops(session)] == found


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("wolk", "the tree 'walk' has no node 'wolk' [unknown-node]\n    did you mean 'walk'?"),
        ("wolk=FAILURE", "has no node 'wolk'"),
        ("walk=FAIL", "did you mean 'FAILURE'?"),
        ("distance(target < 1", "breakpoint:1:20: "),
        ("distanse(target) < 1", "breakpoint:1:1: error: in 'distanse(target) < 1': unknown function 'distanse'"),
        ("state.time", "it is a number in s, but must be true or false"),
        ("count > 3", "unknown name 'count'"),
        ("distance(cup) < 1 m", "no percept source publishes 'cup'"),
        ("", "a breakpoint is a node or an expression"),
    ],
)
def test_a_breakpoint_that_is_none_is_refused(where: str, said: str) -> None:
    session = hbt.Session("walk")
    with pytest.raises(hbt.UserError) as told:
        session.break_at(where)
    assert said in str(told.value)
    assert session.breakpoints == ()


def test_a_run_that_nobody_continues_does_not_begin() -> None:
    session = hbt.Session("walk")
    session.break_at("walk")
    with pytest.raises(hbt.HumanoidBtError, match=r"run_until\(\) returns there"):
        session.run()


# what runs already does not start
def test_a_breakpoint_at_a_node_that_runs_waits_until_it_starts_again(free: hbt.Session) -> None:
    with free:
        free.step()
        free.break_at("first")
        free.break_at("second")
        assert stops(free, 0.3) == [("break at free/sequence/second", "RUNNING: 2 s left")]


# an expression that cannot be worked out is not true, and ends no run
@pytest.mark.parametrize(("where", "value"), [("found > 3", "much"), ("1 / n > 2", 0)])
def test_a_breakpoint_that_cannot_be_worked_out_does_not_hold(free: hbt.Session, where: str, value: Any) -> None:
    with free:
        free.break_at(where)
        key = "n" if value == 0 else "found"
        free.blackboard[key] = value
        assert stops(free, 0.1) == []
        assert free.outcome == ""
        free.blackboard[key] = 0.25 if value == 0 else 4
        assert [source for source, _ in stops(free, 0.2)] == [f"break at {where}"]
