"""The first line of an explanation, for each thing that stops a robot, staged."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.errors import ControlLost
from humanoid_bt.core.messages import Command, Estimate, Mode
from humanoid_bt.record.reading import read_flight
from humanoid_bt.review.cause import Cause
from humanoid_bt.review.causes import _and_raised, first_stop
from humanoid_bt.review.explain import explain
from humanoid_bt.review.history import Happened, Span, Stopped
from humanoid_bt.review.staged import staged_before
from humanoid_bt.session.session import Session
from humanoid_bt.testing.scripted_perception import ScriptedPerception
from humanoid_bt.testing.stage import Stage
from tests.review.direct import recorded_directly
from tests.safety.rows import Contradiction

Play = Callable[..., Path]


def pressed(session: Session) -> None:
    session.raise_estop("too near", source="humanoid-bt estop (me@pts/3, pid 4711)")


def pushed(session: Session) -> None:
    session.push((0.0, -400.0, 0.0), 0.2)


def leant_on(session: Session) -> None:
    session.push((0.0, -110.0, 0.0), 1.0)


def pushed_without_harm_then_weakened(session: Session) -> None:
    """Push too little for a fall, and when the robot has walked on for a while let its left knee hold it no more."""
    session.push((0.0, 60.0, 0.0), 0.1)
    session.run_until(1.7)
    plant: Any = session.engine.plant  # type: ignore[attr-defined]  # what its Protocol does not name
    strength = np.ones(len(plant.robot.joint_names))
    strength[plant.robot.joint_names.index("left_knee")] = 0.05
    plant.set_strength(strength)


def blinded(session: Session) -> None:
    session.engine.perception = ScriptedPerception()  # type: ignore[attr-defined]  # what its Protocol does not name


def blinded_by_a_death(session: Session) -> None:
    session._drive._teller.event("error", "the perception process ended (signal SIGKILL)")
    blinded(session)


def blinded_and_then_silent(session: Session) -> None:
    """Let nothing be seen any more, and then decision be silent for a moment."""
    blinded(session)
    session.run_until(0.9)
    controller = session.engine.controller  # type: ignore[attr-defined]  # what its Protocol does not name
    submit, controller.submit = controller.submit, lambda _: None
    session.run_until(1.1)
    controller.submit = submit


def pressed_then_pushed(session: Session) -> None:
    pressed(session)
    session.run_until(0.92)
    session.push((0.0, 600.0, 0.0), 0.2)


def unsolvable(session: Session) -> None:
    limits = session.engine.controller.body.kinematics.limits  # type: ignore[attr-defined]  # what its Protocol does not name
    limits.append(Contradiction())
    session.run_until(0.7)
    del limits[-1]


def interrupted_in_a_stop(session: Session) -> None:
    session.run_until(lambda now: now.state.mode is not Mode.RUN, timeout=2.0)
    session.interrupt("enough")


def held_up(session: Session) -> None:
    """Let a command arrive too late, as one of a decision without a processor, then none, then one far too late."""
    controller = session.engine.controller  # type: ignore[attr-defined]  # what its Protocol does not name
    submit, sent = controller.submit, []

    def later(command: Command) -> None:
        sent.append(command)
        if len(sent) == 1:
            submit(replace(command, stamp=command.stamp - 0.15))
            submit(command)
        elif len(sent) > 10:
            controller.submit = submit
            submit(sent[1])
            submit(command)

    controller.submit = later


def silent_then_pressed(session: Session) -> None:
    """Let no command arrive any more, and the e-stop be raised when that has stopped the robot."""
    session.engine.controller.submit = lambda _: None  # type: ignore[attr-defined]  # what its Protocol does not name
    session.run_until(0.6)
    pressed(session)


def deluded(session: Session) -> None:
    """Let the supervisor be given a velocity that is no number."""
    supervisor = session.engine.controller.supervisor  # type: ignore[attr-defined]  # what its Protocol does not name
    check = supervisor.check

    def deluded_check(cycle: int, estimate: Estimate, *faults: str) -> None:
        check(cycle, replace(estimate, qvel=np.full_like(estimate.qvel, np.nan)), *faults)

    supervisor.check = deluded_check


def lost(session: Session) -> None:
    """Let control be gone 5 ms after the last tick."""

    def advance() -> None:
        for _ in range(5):
            session.engine.clock.cycle += 1  # type: ignore[attr-defined]  # what its Protocol does not name
        raise ControlLost("the control process has ended (signal SIGKILL)")

    session.engine.advance = advance  # type: ignore[method-assign]  # of this run alone


BLOCKED = "something is in the way of the torso: 60 N, 3 times within 20 s"


CASES: dict[str, tuple[str, str, dict[str, Any], str]] = {
    "estop by hand": (
        "walk",
        "estop",
        {"at": 0.3, "do": pressed, "on_estop": "end"},
        r"the emergency stop was raised at 0\.300 s by humanoid-bt estop \(me@pts/3, pid 4711\): too near",
    ),
    "estop by hand in a protective stop": (
        "walk",
        "estop",
        {"at": 0.3, "do": silent_then_pressed, "on_estop": "end"},
        r"the emergency stop was raised at 0\.600 s by humanoid-bt estop \(me@pts/3, pid 4711\): too near, "
        r"in the protective stop since 0\.\d+ s",
    ),
    "estop by a node": (
        "alarm",
        "estop_node",
        {"on_estop": "end"},
        r"'alarm' raised the emergency stop at 0\.300 s: somebody is too near",
    ),
    "push and fall": (
        "walk",
        "push",
        {"at": 1.0, "do": pushed, "duration": 4.0},
        r"the robot fell at 1\.[34]\d\d s: it was pushed to the right with 400 N at 1\.000 s "
        r"while 'walk' commanded the base",
    ),
    "push that is no jolt, and fall": (
        "walk",
        "push",
        {"at": 1.0, "do": leant_on, "duration": 4.0},
        r"the robot fell at \d\.\d\d\d s: it was pushed to the right with 110 N at 1\.000 s "
        r"while 'walk' commanded the base",
    ),
    "a knee gives way, long after a push and joints at their limits that did no harm": (
        "walk",
        "fall",
        {"at": 0.3, "do": pushed_without_harm_then_weakened, "duration": 6.0},
        r"the robot fell at \d\.\d+ s: left_knee left its setpoint at \d\.\d\d s while 'walk' commanded the base",
    ),
    "push by something in the scene, and fall": (
        "bumped",
        "push",
        {"duration": 6.0},
        r"the robot fell at \d\.\d+ s: something pushed it forward at 4\.[34]\d s",
    ),
    "fall in an emergency stop": (
        "walk",
        "push",
        {"at": 0.3, "do": pressed_then_pushed, "duration": 4.0, "on_estop": "wait"},
        r"the robot fell at \d\.\d+ s: it was pushed to the left with 600 N at 0\.9\d0 s, "
        r"in the emergency stop since 0\.300 s",
    ),
    "no finite state": (
        "walk",
        "state",
        {"at": 0.3, "do": deluded},
        r"the drives were let go at 0\.30\d s: the estimated state is not finite",
    ),
    "no solution": (
        "walk",
        "ik",
        {"at": 0.3, "do": unsolvable, "duration": 1.0},
        r"the robot was stopped at 0\.50\d s: inverse kinematics without a solution for more than 200 ms; .*",
    ),
    "exception": (
        "raise",
        "exception",
        {"duration": 2.0},
        r"'walk' raised KeyError: 'missing' at 1\.000 s, in .*mine\.py:\d+",
    ),
    "not finite": (
        "nan",
        "not_finite",
        {},
        r"'wild' raised ValueError: a target's position must be finite, not \[nan, 0\.0, 0\.0\] at 0\.300 s, in .*",
    ),
    "refused": (
        "refused",
        "refused",
        {"duration": 3.0},
        r"commands were refused from 0\.320 s on: the target of 'left_hand' is out of range .*; "
        r"the robot was stopped at 0\.380 s, the first of 7 times; .*",
    ),
    "refused for seconds": (
        "refused",
        "refused",
        {"at": 2.0, "do": interrupted_in_a_stop, "duration": 5.0},
        r"commands were refused from 0\.320 s on: the target of 'left_hand' .*; the robot was stopped at 2\.060 s",
    ),
    "silent between commands that are refused as too old": (
        "walk",
        "silent",
        {"at": 0.3, "do": held_up},
        r"the robot was stopped at 0\.400 s: decision silent for more than 100 ms; "
        r"the last tick before it is of 0\.400 s; the robot went on at 0\.500 s; the run was ended at 1\.000 s, .*",
    ),
    "refused from the start": (
        "nowhere",
        "refused",
        {"duration": 0.2},
        r"every command was refused from 0\.020 s on, so that the robot did nothing: the target of 'left_hand' .*",
    ),
    "two owners": (
        "thieves",
        "conflict",
        {},
        r"'base' is commanded by two nodes at once: 'walk' and 'thief', at 0\.000 s",
    ),
    "time-out": (
        "late",
        "timeout",
        {},
        r"'timeout' ran out of time after 0\.5 s \(limit 0\.5 s\) at 0\.500 s "
        r"while 'walk' still ran \(at first: walking\)",
    ),
    "percept lost": (
        "fails_when_lost",
        "percept_lost",
        {"at": 0.4, "do": blinded},
        r"'target' was last seen at 0\.40 s: 'watchdog' failed at 0\.720 s",
    ),
    "percept lost, something else runs": (
        "waits_when_lost",
        "percept_lost",
        {"at": 0.4, "do": blinded, "duration": 1.0},
        r"'target' was last seen at 0\.40 s: 'blind' ran instead from 0\.720 s on; the run ended at 1\.000 s",
    ),
    "percept lost, perception died, and a selector turns to something else": (
        "looks_when_lost",
        "percept_lost",
        {"at": 0.4, "do": blinded_by_a_death, "duration": 1.0},
        r"'target' was last seen at 0\.40 s, the perception process ended \(signal SIGKILL\) at 0\.40 s: "
        r"'watchdog' failed at 0\.720 s; 'idle' ran to the end, 1\.000 s",
    ),
    "percept lost, and a stop from which the robot recovered": (
        "looks_when_lost",
        "percept_lost",
        {"at": 0.4, "do": blinded_and_then_silent, "duration": 1.6},
        r"'target' was last seen at 0\.40 s: 'watchdog' failed at 1\.\d+ s; 'idle' ran to the end, 1\.600 s",
    ),
    "percept doubtful, and a selector turns to something else": (
        "looks_when_doubtful",
        "percept_doubtful",
        {"duration": 1.0},
        r"'confident' failed at 0\.400 s: the percept was doubtful, confidence 0\.\d+ < 0\.5 "
        r"\(ball hidden at 0\.40 s \(the scene's script\)\); 'idle' ran to the end, 1\.000 s",
    ),
    "percept doubtful, then lost too": (
        "looks_when_doubtful",
        "percept_lost",
        {"at": 0.6, "do": blinded, "duration": 1.4},
        r"'target' was last seen at 0\.60 s, ball hidden .*: 'watchdog' failed at 0\.9\d\d s; "
        r"'idle' ran to the end, 1\.400 s",
    ),
    "percept never seen": (
        "unseen",
        "percept_lost",
        {},
        r"'target' was never seen: hidden: 'watchdog' failed at 0\.000 s",
    ),
    "hidden by the scene": (
        "doubtful",
        "percept_doubtful",
        {},
        r"'confident' failed at 0\.400 s: the percept was doubtful, confidence 0\.\d+ < 0\.5 "
        r"\(ball hidden at 0\.40 s \(the scene's script\)\)",
    ),
    "flapping": (
        "flapping",
        "percept_doubtful",
        {"duration": 2.6},
        r"'confident' changed its mind 8 times from 0\.00 to 2\.40 s: confidence 0\.\d+ < 0\.5, then .*",
    ),
    "out of reach": (
        "far",
        "out_of_reach",
        {"duration": 6.0},
        r"'reach' failed at 4\.\d+ s: left hand comes no nearer than 1\d\d cm",
    ),
    "torque limit": (
        "far",
        "torque_limit",
        {"duration": 6.0, "robot": "weak"},
        r"'reach' failed at \d\.\d+ s: left hand comes no nearer than \d+ cm; "
        r"left_shoulder_roll was at its torque limit, 2 Nm",
    ),
    "failure": ("give_up", "failed", {}, r"'give_up' failed at 0\.000 s: the thing is not there"),
    "failure behind one that did no harm": (
        "behind",
        "failed",
        {},
        r"'culprit' failed at 0\.100 s: state\.x .* > 5 m",
    ),
    "time is up": (
        "wait",
        "unfinished",
        {"duration": 0.1},
        r"the run was ended at 0\.100 s, its 0\.1 s were up while 'pause' ran \(waiting\)",
    ),
    "the session is left": (
        "wait",
        "unfinished",
        {"do": Session.close},
        r"the run was ended at 0\.000 s while 'pause' ran: the session was left while the tree was running",
    ),
    "time is up long after a branch was halted": (
        "gives_way",
        "unfinished",
        {"duration": 0.6},
        r"the run was ended at 0\.600 s, its 0\.6 s were up while 'wait' ran \(59\.8 s left\)",
    ),
    "time is up in the tick that halts a branch": (
        "gives_way",
        "unfinished",
        {"duration": 0.4},
        r"the run was ended at 0\.400 s, its 0\.4 s were up while 'wait' ran \(60 s left\)",
    ),
    "control lost right after the first tick": (
        "walk",
        "control",
        {"do": lost},
        r"control was lost at 0\.00\d s: the control process has ended \(signal SIGKILL\)",
    ),
    "interrupted": (
        "walk",
        "interrupted",
        {"at": 0.2, "do": lambda session: session.interrupt("enough")},
        r"the run was ended at 0\.200 s while 'walk' ran: enough",
    ),
    "a sensor fails": (
        "walk",
        "sensor",
        {"at": 0.6, "do": lambda session: session.engine.plant.fail_sensor("left_knee", "frozen")},
        r"a sensor failed, the sensors of left_knee are frozen: the robot was stopped at 0\.63\d s",
    ),
    "a plant that is not heard": (
        "walk",
        "plant",
        {"at": 0.6, "do": lambda session: setattr(session.engine.plant, "fault", "the plant is silent")},
        r"the plant is silent: the robot was stopped at 0\.6\d\d s",
    ),
    "something in its way": (
        "walk",
        "way",
        {
            "at": 0.6,
            "do": lambda session: session.engine.plant.push("left_hand", np.array([-40.0, 0.0, 0.0]), 0.8),
            "duration": 2.0,
        },
        r"something is in the way of the left arm: \d\d N: the robot was stopped at 1\.1\d\d s",
    ),
    "something in its way again and again": (
        "walk",
        "way",
        {"at": 0.6, "do": lambda session: setattr(session.engine.supervisor.touch, "blocked", BLOCKED)},
        r"something is in the way of the torso: 60 N, 3 times within 20 s: the emergency stop was raised at 0\.6\d\d s",
    ),
    "interrupted in its first tick": (
        "walk",
        "interrupted",
        {"at": 0.0, "do": lambda session: session.interrupt("enough")},
        r"the run was ended at 0\.000 s while 'walk' ran: enough",
    ),
    "success": ("wait", "success", {}, r"nothing stopped it: the run succeeded at 0\.200 s: pause: waited"),
}

TELLING = (
    "estop by hand",
    "push and fall",
    "a knee gives way, long after a push and joints at their limits that did no harm",
    "exception",
    "refused for seconds",
    "two owners",
    "time-out",
    "the session is left",
    "time is up long after a branch was halted",
    "percept lost",
    "failure behind one that did no harm",
    "percept lost, perception died, and a selector turns to something else",
    "a sensor fails",
    "a plant that is not heard",
    "control lost right after the first tick",
    "interrupted in its first tick",
    "success",
)
"""Those that ``make test`` tries; the others are in ``make test-trials``."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in TELLING else pytest.mark.trials) for name in CASES]
)
def test_the_first_line_says_what_stopped_the_robot(play: Play, name: str) -> None:
    tree, kind, how, headline = CASES[name]
    found = explain(play(tree, **how))
    assert re.fullmatch(headline, found.headline), found.headline
    assert found.kind == kind
    assert found.node or kind != "control"
    assert " after -" not in dict(found.rows).get("run", "")
    assert (("", "and 3 more") in found.after) == (len(found.data["stops"]) == 7)  # of which four are listed
    assert (("", "0.800 s the same for 0.02 s") in found.after) == (name in {"refused", "refused for seconds"})
    assert not any("NAME" in text for _, text in found.after)
    for more in (text for name, text in found.after if name == "more"):
        at = float(more.split()[3])
        assert at == pytest.approx(found.time, abs=6e-4)
        assert explain(found.recording, at=at).kind == "moment"
    for width in (60, 80):
        lines = found.text(width).splitlines()
        assert len(lines) <= (30 if width == 80 else 45), found.text(width)
        assert "\x1b" not in found.text(width)


@pytest.mark.trials
@pytest.mark.parametrize("conditions", [{"slope": 0.35, "uphill": 1.57}, {"friction": 0.05}])
def test_who_loses_the_footing_was_not_pushed(stage: Path, tmp_path: Path, conditions: dict[str, float]) -> None:
    with recorded_directly():
        run = Stage(stage).run("walk", conditions=conditions, duration=2.0, record=tmp_path / "run.rrd")
    found = explain(run.recording)
    assert found.kind == "fall"
    assert "no push and no joint that gave way is seen before it lost its balance" in found.headline


@pytest.mark.trials
def test_a_load_that_the_model_does_not_know_is_told_beside_what_may_be_in_the_way(stage: Path, tmp_path: Path) -> None:
    with recorded_directly():
        run = Stage(stage).run("walk", conditions={"payload": 60.0}, duration=1.3, record=tmp_path / "run.rrd")
    assert re.match(
        r"something is in the way of the torso: \d+ N, or it carries more than its model says, "
        r"for left_knee was at its torque limit: the robot was stopped at \d\.\d+ s",
        explain(run.recording).headline,
    )


@pytest.mark.trials
def test_a_recording_that_is_still_written_is_explained(stage: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.rrd"
    with Session("walk", workspace=stage, record=file, camera=False) as session:
        session.run_until(1.5)
        recorder = session._drive._recorder
        assert recorder is not None
        while recorder._written < 1.0:
            recorder._follow()
        found = explain(file)
    assert found.headline.endswith(
        "s, and does not say how the run ended: it is still being written, or the recorder was killed"
    )


COLOURS = """\
format: 1
root:
  emergency_stop:
    sequence:
      - for_each:
          items: [red, blue, red, blue, red, blue]
          item: colour
          selector:
            - sequence: [{condition: {name: is red, expression: colour == 'red'}}, {wait: 0.06 s}]
            - wait: 0.06 s
      - give_up
"""


@pytest.mark.parametrize(("duration", "kind"), [(2.0, "failed"), (0.44, "unfinished")])
def test_a_condition_that_a_loop_asks_in_each_round_does_not_change_its_mind(
    play: Play, stage: Path, duration: float, kind: str
) -> None:
    (stage / "trees/colours.yaml").write_text(COLOURS, encoding="utf-8")
    assert explain(play("colours", duration)).kind == kind


def test_the_joint_at_its_limit_is_of_the_arm_that_was_to_reach(play: Play) -> None:
    def lifted(session: Session) -> None:
        """Relieve the left arm a little: the right one, which nobody asks for anything, is at its limit longer."""
        session.push([0.0, 0.0, 6.0], 4.0, "left_hand")

    found = explain(play("far", duration=6.0, robot="weak", at=0.3, do=lifted))
    assert found.kind == "torque_limit"
    assert "left hand comes no nearer" in found.headline
    assert re.search(r"left_shoulder_\w+ was at its torque limit", found.headline), found.headline


_KILLED = """
import os, signal, sys
from humanoid_bt import Session

with Session("walk", workspace=sys.argv[1], record=sys.argv[2], camera=False) as session:
    session.run_until(0.5)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.trials
def test_a_program_that_was_killed_is_told(stage: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.rrd"
    subprocess.run([sys.executable, "-c", _KILLED, stage, file], capture_output=True, check=False, timeout=60)
    found = explain(file)
    assert found.headline == "the program that runs the tree was killed after its tick of 0.500 s while 'walk' ran"
    assert found.node == "walk/emergency_stop/walk"


@pytest.mark.trials
def test_a_recorder_that_was_killed_leaves_a_recording_that_ends_early(stage: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.rrd"
    with Session("walk", workspace=stage, record=file, camera=False, duration=2.0) as session:
        session.run_until(1.5)
        recorder = session._drive._recorder
        assert recorder is not None
        os.kill(recorder._process.pid, signal.SIGKILL)
        session.run_until(1.8)
    found = explain(file)
    assert re.match(r"the recording ends at [01]\.\d+ s, ", found.headline)
    assert found.kind == "cut"


def test_a_recording_on_a_full_disk_ends_in_the_midst_of_a_message(play: Play, tmp_path: Path) -> None:
    whole, cut = play("walk", duration=0.5), tmp_path / "cut.rrd"
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    found = explain(cut)
    assert "in the midst of a message: its disk was full" in found.headline
    (helps,) = (text for name, text in found.after if name == "helps")
    assert helps.startswith("look whether the recorder was killed")
    assert ".control.log" not in found.text()
    cut.with_suffix(".control.log").write_text("", encoding="utf-8")
    assert "cut.control.log" in explain(cut).text(200)
    assert found.data["cut"]


def test_a_stop_is_told_of_a_recording_that_was_cut_after_it(play: Play, monkeypatch: pytest.MonkeyPatch) -> None:
    log = read_flight(play("walk", at=0.3, do=pressed, duration=0.6, on_estop="wait"))
    monkeypatch.setattr("humanoid_bt.review.explain.read_flight", lambda _: log)
    del log.blocks["news"][-1], log.until["news"][-1]
    log.cut = "it ends within a message"
    found = explain(log.path)
    assert found.kind == "estop"
    assert re.fullmatch(
        r"the emergency stop was raised at 0\.300 s by humanoid-bt estop .*: too near; "
        r"the recording ends at 0\.\d+ s, in the midst of a message: .*",
        found.headline,
    )


@pytest.mark.parametrize(
    ("mode", "raised_at", "outlasts"),
    [
        ("protective_stop", 2.0, True),
        ("protective_stop", 3.0, True),  # as the run ended
        ("protective_stop", 3.1, False),  # after that
        ("protective_stop", 0.5, False),  # before: it was reset
        ("damp", 2.0, False),  # a robot that lies is not stopped once more
    ],
)
def test_an_estop_outlasts_the_protective_stop_in_which_it_was_raised(
    mode: str, raised_at: float, outlasts: bool
) -> None:
    stop = Stopped(1.0, mode, "why", "supervisor", {"gaze": "t/look"})
    estop = Stopped(raised_at, "emergency_stop", "too near", "a button", {"gaze": "t/look"})
    history: Any = SimpleNamespace(stops=sorted([stop, estop]), acting=lambda _time: [], nodes=lambda _time: ["t/look"])
    cause = Cause("silent", "decision was silent", 1.0)
    found, why = _and_raised(history, stop, cause, until=3.0)
    assert found is (estop if outlasts else stop)
    if outlasts:
        assert (why.kind, why.time) == ("estop", raised_at)
        assert why.headline.endswith("'a button': too near, in the protective stop since 1.000 s")
    else:
        assert why is cause


@pytest.mark.parametrize("recovered", ["run", "paused"])
def test_a_fall_in_the_servo_cycle_that_the_last_tick_saw_is_what_ended_the_run(recovered: str) -> None:
    silent, fall = (
        Stopped(time, mode, "why", "supervisor", {}) for time, mode in ((1.0, "protective_stop"), (2.0, "damp"))
    )
    spans = [Span(1.0, 1.5, "protective_stop"), Span(1.5, 2.0, recovered), Span(2.0, 9.0, "damp")]
    history: Any = SimpleNamespace(
        stops=[silent, fall],
        end={"outcome": "stopped"},
        modes=lambda begin, end: [span for span in spans if span.begin < end and span.until > begin],
    )
    assert first_stop(history, 2.0) is fall
    history.end = {"outcome": "unfinished"}
    assert first_stop(history, 2.0) is None


@pytest.mark.parametrize(
    ("staged", "told"),
    [
        (
            [(0.0, "payload 2 kg"), (0.0, "walk is replaced: failure"), (9.0, "push")],
            "changed by a test from the beginning: payload 2 kg; walk is replaced: failure",
        ),
        ([(9.0, "push")], "a test ran it, and had done nothing to it by then"),
    ],
)
def test_what_a_test_changed_before_it_did_anything_is_told(staged: list[tuple[float, str]], told: str) -> None:
    events = [Happened(time, "warning", f"staged: {text}") for time, text in staged]
    history: Any = SimpleNamespace(setup={"staged": {"told": ["all"], "dry": False}}, events=events)
    assert staged_before(history, Cause("failed", "why", 7.2)) == f"; {told}"


@pytest.mark.parametrize(("kind", "told"), [("fall", "5.000 s: weaken"), ("percept_lost", "7.100 s: push")])
def test_what_a_test_did_after_balance_was_lost_is_not_told_beside_the_cause_of_a_fall(kind: str, told: str) -> None:
    staged = [Happened(5.0, "warning", "staged: weaken"), Happened(7.1, "warning", "staged: push")]
    history: Any = SimpleNamespace(setup={"staged": {"told": ["both"], "dry": False}}, events=staged)
    assert staged_before(history, Cause(kind, "why", 7.2, began=6.5)) == f"; a test staged at {told}"
