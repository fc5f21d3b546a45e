"""The debugger: breakpoints that wait or cannot be worked out, values as they are now, time in a pause."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import humanoid_bt as hbt
from humanoid_bt.cli.commands import answer

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


@pytest.fixture
def session(project: Path) -> hbt.Session:
    (project / "trees" / "free.yaml").write_text(FREE, encoding="utf-8")
    return hbt.Session("free", workspace=project)


def stops(session: hbt.Session, until: float) -> list[str]:
    found = list[str]()
    while session.time < until - 1e-6 and not session.outcome:
        session.run_until(until)
        if session.paused is not None:
            found.append(session.paused.source)
            session.resume()
    return found


# what runs already does not start
def test_a_breakpoint_at_a_node_that_runs_waits_until_it_starts_again(session: hbt.Session) -> None:
    with session:
        session.step()
        session.break_at("first")
        session.break_at("second")
        assert stops(session, 0.3) == ["break at free/sequence/second"]


# an expression that cannot be worked out is not true, and ends no run
@pytest.mark.parametrize(("where", "value"), [("found > 3", "much"), ("1 / n > 2", 0)])
def test_a_breakpoint_that_cannot_be_worked_out_does_not_hold(session: hbt.Session, where: str, value: Any) -> None:
    with session:
        session.break_at(where)
        key = "n" if value == 0 else "found"
        session.blackboard[key] = value
        assert stops(session, 0.1) == []
        assert session.outcome == ""
        session.blackboard[key] = 0.25 if value == 0 else 4
        assert stops(session, 0.2) == [f"break at {where}"]


def test_parameters_are_shown_as_they_are_now_with_their_unit(session: hbt.Session) -> None:
    with session:
        session.step()
        assert answer(session, "parameters", "keyboard") == "patience = 2 s"
        answer(session, "set patience = 5 s", "keyboard")
        assert answer(session, "parameters second", "keyboard") == "duration = 5 s"
        assert answer(session, "parameters", "keyboard") == "patience = 5 s"


# docs/debugging.md: "The world goes on, in lockstep at the pace of real time"
@pytest.mark.parametrize(("attended", "speed"), [(True, 1.0), (False, None)])
def test_time_goes_on_at_the_pace_of_real_time_in_a_pause_that_somebody_attends(
    session: hbt.Session, monkeypatch: pytest.MonkeyPatch, attended: bool, speed: float | None
) -> None:
    made = list[float | None]()

    class Noted:
        def __init__(self, speed: float | None) -> None:
            self.speed = speed
            made.append(speed)

        def keep(self, now: float) -> None: ...

    monkeypatch.setattr("humanoid_bt.session.loop.Pace", Noted)
    with session:
        session.step()
        session._drive.debugger.attended = attended
        session.pause()
        session.wait(0.1)
    assert made == [speed]
