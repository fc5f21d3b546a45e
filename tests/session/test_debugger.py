"""Runs that are paused, stepped and continued: by a program, and as the keys do."""

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


# docs/debugging.md: "The world goes on, in lockstep at the pace of real time"
@pytest.mark.parametrize(("attended", "speed"), [(True, 1.0), (False, None)])
def test_time_goes_on_at_the_pace_of_real_time_in_a_pause_that_somebody_attends(
    monkeypatch: pytest.MonkeyPatch, attended: bool, speed: float | None
) -> None:
    made = list[float | None]()

    class Noted:
        def __init__(self, speed: float | None) -> None:
            self.speed = speed
            made.append(speed)

        def keep(self, now: float) -> None: ...

    monkeypatch.setattr("humanoid_bt.session.loop.Pace", Noted)
    with hbt.Session("limited") as session:
        session.step()
        session._drive.debugger.attended = attended
        session.pause()
        session.wait(0.1)
    assert made == [speed]
