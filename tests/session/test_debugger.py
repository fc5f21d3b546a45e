"""Runs that are paused, stepped and continued: by a program, as the keys do, and by breakpoints."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, cast

import pytest
from py_trees.common import Status

import humanoid_bt as hbt
from humanoid_bt.core.messages import Gait, Mode
from humanoid_bt.session.debugger import Debugger
from humanoid_bt.session.listener import Listener
from humanoid_bt.session.teller import Teller

WALK = "format: 1\nroot: {emergency_stop: walk}\n"
LIMITED = "format: 1\nroot: {emergency_stop: {timeout: {duration: 0.4 s, walk: }}}\n"
SEES = "format: 1\nscene: ball_on_stand\nroot: {emergency_stop: walk}\n"


@pytest.fixture(autouse=True)
def in_project(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)
    for name, text in {"walks": WALK, "limited": LIMITED, "sees": SEES}.items():
        (project / "trees" / f"{name}.yaml").write_text(text, encoding="utf-8")


def events(session: hbt.Session) -> list[str]:
    return [event["text"] for event in session.report.events]


# ---- pausing -------------------------------------------------------------------------------------------------------


@pytest.mark.trials
def test_a_walking_robot_comes_to_a_stand_and_the_tree_goes_on() -> None:
    with hbt.Session("walks") as session:
        session.run_until(0.8)
        assert session.state.gait is Gait.STEP
        commanded = session.state.command_sources
        session.pause("to look at it")
        assert str(session.paused) == "paused by program: to look at it"
        assert session.wait(2.5)
        state = session.state
        assert (state.mode, state.stop_reason, state.stop_source) == (Mode.PAUSED, "to look at it", "program")
        assert state.base_settled
        assert not state.command_sources
        assert session.node("walk").status is Status.RUNNING  # nobody has told it anything
        stood = state.stance[0]
        session.resume()
        assert session.paused is None
        assert session.step()
        assert (session.state.mode, session.state.command_sources) == (Mode.RUN, commanded)
        session.run_until(lambda s: s.state.stance[0] > stood + 0.05, timeout=2.0)
        assert session.state.stance[0] > stood + 0.05
    assert session.report.stops == []
    assert not session.report.fell
    walks = [change["status"] for change in session.report.timeline if change["path"].endswith("/walk")]
    assert walks == ["RUNNING", "INVALID"]  # halted by the end of the run alone
    told = [event for event in session.report.events if "program" in event["text"]]
    assert [(event["time"], event["text"]) for event in told] == [
        (pytest.approx(0.82), "paused by program: to look at it"),
        (pytest.approx(3.32), "continued by program"),
    ]


def test_a_step_is_a_tick_of_the_run_and_the_robot_is_held_between_two() -> None:
    ticks: list[float] = []
    with hbt.Session("limited") as session:
        session.run_until(0.1)
        session.pause()
        for _ in range(3):
            assert session.wait(0.1)
            assert session.state.mode is Mode.PAUSED
            session.step()
            assert session.state.mode is Mode.RUN  # what a tick sees is never the pause
            assert session.node("walk").status is Status.RUNNING
            ticks.append(session.time)
        session.wait(0.02)
        assert session.state.mode is Mode.PAUSED
    assert ticks == pytest.approx([0.22, 0.34, 0.46])


def test_the_clock_of_the_tree_stands_still() -> None:
    with hbt.Session("limited", duration=0.5) as session:
        session.run_until(0.1)
        session.pause()
        session.wait(0.7)  # longer than the time-out, and than the run may last
        assert session.time == pytest.approx(0.8)
        assert session.outcome == ""
        session.resume()
        report = session.run()
    assert report.outcome == "failure"
    (ended,) = (change for change in report.timeline if change["path"] == "limited/emergency_stop/timeout" and
                change["status"] == "FAILURE")  # fmt: skip
    assert ended["time"] == pytest.approx(0.4 + 0.7)


def test_percepts_go_on() -> None:
    with hbt.Session("sees") as session:
        session.run_until(0.18)
        session.pause()
        session.wait(0.14)
        seen = session.percepts["target"]
        assert (seen.stamp, seen.age) == (pytest.approx(0.3), pytest.approx(0.02))
        assert session.state.mode is Mode.PAUSED


def test_what_stops_a_robot_stops_a_paused_one() -> None:
    with hbt.Session("walks", on_estop="wait") as session:
        session.run_until(0.1)
        session.pause()
        session.wait(0.1)
        session.raise_estop("enough")
        session.wait(0.1)
        assert session.state.mode is Mode.EMERGENCY_STOP
        assert session.node("walk").status is Status.RUNNING
        session.request_reset()
        session.wait(0.1)
        assert session.state.mode is Mode.PAUSED
    with hbt.Session("walks") as ends:
        ends.step()
        ends.pause()
        ends.raise_estop("enough")
        assert not ends.wait(1.0)
        assert ends.outcome == "stopped"


def test_a_fall_ends_a_paused_run() -> None:
    with hbt.Session("walks") as session:
        session.run_until(0.2)
        session.pause()
        session.wait(0.1)
        session.push([600, 0, 0], 0.3)
        assert not session.wait(5.0)
    assert (session.report.outcome, session.report.fell) == ("stopped", True)


def test_it_can_be_paused_before_the_first_tick_and_left() -> None:
    with hbt.Session("walks") as session:
        session.pause()
        session.wait(0.1)
        assert session.node("walk").status is Status.INVALID
        assert session.state.mode is Mode.PAUSED
        session.step()
        assert session.node("walk").status is Status.RUNNING
    assert session.report.outcome == "unfinished"
    assert session.report.stops == []


@pytest.mark.parametrize("status", ["SUCCESS", "FAILURE"])
def test_a_run_that_is_left_in_the_pause_at_the_end_of_its_tree_ends_as_that_did(status: str) -> None:
    with hbt.Session("limited") as session:
        session.step()
        session.force("timeout", status)
        session.break_at(f"emergency_stop={status}")
        session.run_until(lambda now: now.paused)
    assert session.report.outcome == status.lower()
    assert session.report.reason.startswith("timeout: forced to ")


def test_a_mistake_in_what_is_done_between_ticks_is_told_and_the_run_goes_on() -> None:
    with hbt.Session("walks") as session:
        session.between_ticks(lambda: session.set("nope", 1))
        session.between_ticks(lambda: session.force("walk", "FAILURE"))
        assert session.run().outcome == "failure"
    mistakes = [event["text"] for event in session.report.events if event["level"] == "error"]
    assert mistakes == ["the tree has no key or parameter 'nope'"]


def test_who_pauses_first_is_told_once() -> None:
    with hbt.Session("walks") as session:
        session.resume()  # nothing to continue
        session.pause("first", source="keyboard")
        session.pause("second")
        session.step()
        session.resume(source="keyboard")
        session.step()
    assert events(session)[:3] == ["paused by keyboard: first", "one tick by program", "continued by keyboard"]


def test_a_step_that_came_too_late_is_none_of_the_next_pause() -> None:
    debugger = Debugger(cast(Teller, None))  # who is told of nothing here
    debugger.ask_pause("keyboard", "first")
    debugger.ask_step("keyboard")
    debugger.resume("program")
    debugger.ask_pause("keyboard", "second")
    assert debugger.standing() is debugger.pause


@pytest.mark.trials
def test_the_run_is_the_same_each_time() -> None:
    def trace() -> str:
        with hbt.Session("walks") as session:
            session.run_until(0.2)
            session.pause()
            session.wait(0.1)
            session.step()
            session.resume()
            session.run_until(0.5)
        return session.report.trace_hash

    assert trace() == trace()


def test_mistakes_are_told() -> None:
    with hbt.Session("walks") as session:
        session.step()
        with pytest.raises(hbt.HumanoidBtError, match="the run is not paused"):
            session.wait(1.0)
        session.pause()
        with pytest.raises(hbt.UserError, match="duration"):
            session.wait(-1.0)
        assert not session.run_until(5.0)
        assert session.time == 0.0
        with pytest.raises(hbt.HumanoidBtError, match=r"paused by program: .*, and nobody continues it"):
            session.run()
    with pytest.raises(hbt.HumanoidBtError, match="nothing can be paused any more"):
        session.pause()


# ---- from another thread, as the keys do ----------------------------------------------------------------------------


class Keyboard(Listener):
    """Presses keys at given times, in another thread, and waits until they have been heard."""

    def __init__(self, *keys: tuple[float, str, dict[str, Any]]) -> None:
        self.session: hbt.Session
        self._keys = list(keys)

    def progress(self, time: float, running: str) -> None:
        while self._keys and time >= self._keys[0][0] - 1e-9:
            _, name, arguments = self._keys.pop(0)
            thread = threading.Thread(target=getattr(self.session, name), kwargs=arguments)
            thread.start()
            thread.join()


def test_an_attended_run_waits_until_another_thread_continues_it() -> None:
    by: dict[str, Any] = {"source": "keyboard"}
    keyboard = Keyboard((0.1, "request_step", by), (0.2, "request_step", by), (0.3, "resume", by))
    session = keyboard.session = hbt.Session("limited", listener=keyboard)
    report = session.run(attended=True)
    assert report.outcome == "failure"
    assert [event["text"] for event in report.events][:3] == [
        "paused by keyboard: to go on step by step; c continues, n is one tick, : takes commands",
        "one tick by keyboard",
        "continued by keyboard",
    ]
    assert report.sim_time == pytest.approx(0.4 + 0.2 - 0.02)


# ---- breakpoints ----------------------------------------------------------------------------------------------------

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


def stops(session: hbt.Session) -> list[tuple[str, str]]:
    """Run to the end; return where it paused, and why."""
    found: list[tuple[str, str]] = []
    while not session.outcome:
        if session.run_until(lambda s: False):
            break
        if session.paused is not None:
            found.append((session.paused.source, session.paused.reason))
            session.resume()
    return found


@pytest.fixture
def count(project: Path) -> hbt.Session:
    (project / "trees" / "count.yaml").write_text(COUNT, encoding="utf-8")
    return hbt.Session("count")


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
    with hbt.Session("walks") as session:
        session.break_at("walk")
        session.run_until(lambda s: s.paused)
        session.wait(0.5)
        assert session.node("walk").status is Status.RUNNING
        assert session.state.stance[0] == pytest.approx(0.0, abs=0.01)
        session.clear_breakpoints()
        session.resume()
        session.run_until(lambda s: s.state.gait is Gait.STEP, timeout=1.0)
        assert session.state.gait is Gait.STEP


def test_a_halt_is_a_breakpoint_but_not_that_of_the_end() -> None:
    with hbt.Session("limited") as session:
        session.break_at("walk=halted")
        assert stops(session) == [("break at limited/emergency_stop/timeout/walk", "halted: timed out after 0.4 s")]
    with hbt.Session("walks") as ends:
        ends.break_at("walk=HALTED")
        ends.step()
    assert ends.paused is None


REPEATED = """\
format: 1
root:
  repeat:
    times: 2
    sequence:
      - pause: {name: step (v1.2), duration: 20 ms}
      - force_success: {parallel: [{pause: {name: brief, duration: 1 s}}, failure]}
"""


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
        ("wolk", "the tree 'walks' has no node 'wolk' [unknown-node]\n    did you mean 'walk'?"),
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
    session = hbt.Session("walks")
    with pytest.raises(hbt.UserError) as told:
        session.break_at(where)
    assert said in str(told.value)
    assert session.breakpoints == ()


def test_a_run_that_nobody_continues_does_not_begin() -> None:
    session = hbt.Session("walks")
    session.break_at("walk")
    with pytest.raises(hbt.HumanoidBtError, match=r"run_until\(\) returns there"):
        session.run()


# ---- setting and forcing --------------------------------------------------------------------------------------------

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
    assert "forced settable/emergency_stop/sequence/timeout/walk to FAILURE by program" in events(session)


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
    with hbt.Session("walks") as session:
        session.step()
        with pytest.raises(hbt.UserError, match=said):
            session.force(path, status)
