"""Every fault, brought about at its moment, does what it says, through the product's own supervisor and loop."""

from __future__ import annotations

import math

import numpy as np
import pytest

from humanoid_bt import Event, Stage, UserError
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.errors import Place
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.testing.claim import Claim
from humanoid_bt.testing.faults import EStop, Lose, Push, Set, Silence

HERE = {"at": 0, "see": {"percept": "target", "position": [0.42, 0.2, 0.9]}}  # seen wherever the robot looks


def texts(run):
    return [event["text"] for event in run.report.events]


def tracks(run, name="target"):
    return [(view.time, view.tracks.get(name)) for view in run.views()]


# ---- the robot ------------------------------------------------------------------------------------------------------


def test_a_push_moves_the_robot_and_is_told(stage):
    still = stage.run("stand", duration=0.25)
    run = stage.run("stand", duration=0.25, script=[{"at": 0.1, "push": {"force": [0, 150, 0], "duration": "60 ms"}}])
    assert not still.report.external_force_max
    assert run.report.external_force_max == 150
    speed = [state.com_velocity[1] for state in run.states]
    assert max(speed) > max(abs(state.com_velocity[1]) for state in still.states) + 0.05
    assert next(state.time for state in run.states if state.com_velocity[1] > 0.02) == pytest.approx(0.12)
    push = "push (force [0, 150, 0] N, duration 0.06 s)"
    assert texts(run)[:3] == [f"staged: {push}", "torso touched something: 68 N", f"staged: over: {push}"]


def test_weak_drives_give_no_more_than_their_part_and_then_all_again(stage):
    weaken = {"joints": ["left_shoulder_*", "right_shoulder_pitch"], "to": 0, "duration": "0.1 s"}
    run = stage.run("stand", duration=0.3, script=[{"at": 0.1, "weaken": weaken}])
    names = load_robot(stage.workspace.find_robot("humanoid"))[0].joint_names
    weak = [number for number, name in enumerate(names) if "left_shoulder" in name or name == "right_shoulder_pitch"]
    torque = {round(state.time, 2): state.joint_torques for state in run.states}
    assert len(weak) == 4
    noise = 1.0  # Nm, that the sensors never have
    assert np.abs(torque[0.1][weak]).max() > noise
    assert np.abs(torque[0.16][weak]).max() < noise
    assert np.abs(torque[0.16]).max() > noise
    assert np.abs(torque[0.24][weak]).max() > noise


def test_drives_that_are_weakened_twice_are_weaker_still(stage, monkeypatch):
    script = [{"at": 0, "weaken": {"joints": ["*"], "to": 0.5}}, {"at": 0, "weaken": {"joints": ["left_*"], "to": 0.5}}]
    strengths, set_strength = [], MujocoPlant.set_strength

    def noted(plant, strength):
        strengths.extend(strength)
        set_strength(plant, strength)

    monkeypatch.setattr(MujocoPlant, "set_strength", noted)
    stage.run("stand", script=script, duration=0.1)
    assert {0.25, 0.5} <= set(strengths)


def test_a_sensor_that_breaks_stops_the_robot_and_the_next_run_has_it_whole(stage):
    run = stage.run("stand", duration=0.3, script=[{"at": 0.1, "break": {"sensor": "gyro", "how": "jumping"}}])
    (stop,) = run.stops
    assert (stop.mode.value, stop.reason) == ("protective_stop", "a sensor failed: the gyro jumps")
    assert 0.1 < stop.time <= 0.15
    assert texts(run)[0] == "staged: break (sensor gyro, how jumping)"
    assert stage.run("stand", duration=0.3, script=[{"at": 0.2, "break": "left_knee"}]).stops[0].time > 0.2
    assert not stage.run("stand", duration=0.3).stops


def test_an_emergency_stop_ends_the_run_unless_the_script_resets_it(dry):
    stopped = dry.run("fetch", script=[{"at": 0.1, "estop": "a hand on the button"}])
    assert (stopped.outcome, stopped.reason) == ("stopped", "a hand on the button (the test)")
    assert [(stop.mode.value, stop.source) for stop in stopped.stops] == [("emergency_stop", "the test")]
    again = dry.run("fetch", script=[{"at": 0.1, "estop": {}}, {"at": 0.5, "reset": "somebody"}])
    assert again.succeeded
    assert 0.1 < again.stops[0].time < 0.12
    assert "reset by somebody: done" in texts(again)
    ended = dry.run("fetch", on_estop="end", script=[{"at": 0.1, "estop": {}}, {"at": 0.5, "reset": "somebody"}])
    assert ended.outcome == "stopped"


# ---- what it sees ---------------------------------------------------------------------------------------------------


def test_what_is_seen_is_where_the_script_says_until_it_is_lost(dry):
    lost = {"at": 0.25, "lose": "target"}
    there = {"at": 0.65, "see": {"percept": "target", "position": [0, 2, 1], "confidence": 0.7}}
    seen = tracks(dry.run("stand", duration=1.0, script=[HERE, lost, there]))
    assert seen[0][1].position_world == pytest.approx([0.42, 0.2, 0.9])
    assert [track.age for time, track in seen if time < 0.65] == pytest.approx(
        [time % 0.1 if time < 0.29 else time - 0.2 for time, _ in seen if time < 0.65], abs=1e-6
    )
    assert seen[-1][1].position_world == pytest.approx([0, 2, 1])
    assert seen[-1][1].confidence == 0.7


def test_what_the_scene_shows_can_be_lost_for_a_time(dry):
    run = dry.run(
        "fetch",
        duration=0.6,
        replace={"approach": "running"},
        script=[{"at": 0.1, "lose": {"percept": "target", "duration": "0.3 s"}}],
    )
    ages = {round(time, 2): round(track.age, 2) for time, track in tracks(run)}
    assert (ages[0.1], ages[0.38], ages[0.42]) == (0.1, 0.38, 0.02)
    assert run.report.unseen == {}


def test_what_was_lost_from_the_beginning_was_never_seen(dry):
    run = dry.run("fetch", duration=0.3, script=[{"at": 0, "lose": "target"}])
    assert not any(track for _, track in tracks(run))
    assert run.report.unseen == {"target": "kept from it by the test"}


def test_noise_drops_moves_doubts_and_delays_what_is_seen(dry):
    noise = {"percept": "target", "sigma": "3 cm", "drop_out": 0.25, "confidence": 0.5, "delay": "60 ms"}
    run = dry.run("stand", duration=15, script=[HERE, {"at": 0, "noise": noise}])
    observed = {track.stamp: (time, track) for time, track in reversed(tracks(run)) if track}
    assert 0.6 < len(observed) / 150 < 0.9
    assert {round(time - stamp, 6) for stamp, (time, _) in observed.items()} == {0.06}
    assert {track.confidence for _, track in observed.values()} == {0.95 / 2}
    offsets = np.array([track.position_world for _, track in observed.values()]) - [0.42, 0.2, 0.9]
    assert offsets.std(axis=0) == pytest.approx([0.03] * 3, rel=0.25)
    assert abs(offsets.mean()) < 0.01
    assert dry.run("stand", duration=1, script=[HERE, {"at": 0, "noise": noise}]).report.percepts != (
        dry.run("stand", duration=1, seed=1, script=[HERE, {"at": 0, "noise": noise}]).report.percepts
    )


def test_noise_without_a_name_is_about_everything_that_is_seen(dry):
    run = dry.run("stand", duration=0.1, script=[HERE, {"at": 0, "noise": {"confidence": 0.1}}])
    assert tracks(run)[-1][1].confidence == pytest.approx(0.095)


@pytest.mark.parametrize("at", [0, 0.05])
def test_noise_is_of_what_is_seen_later_too(dry, at):
    noise, there = {"at": 0, "noise": {"percept": "target", "confidence": 0.1}}, {**HERE, "at": at}
    assert tracks(dry.run("stand", duration=0.2, script=[noise, there]))[-1][1].confidence == pytest.approx(0.095)


@pytest.mark.parametrize("fault", [{"noise": {"drop_out": 1}}, {"lose": "target"}, {"noise": {"delay": "9 s"}}])
def test_what_the_script_shows_and_takes_away_is_kept_from_the_robot(fault):
    run = Stage(scene="empty", dry=True).run("fetch", duration=0.2, script=[HERE, {"at": 0, **fault}])
    assert run.report.unseen == {"target": "kept from it by the test"}


def test_what_arrives_late_is_not_taken_for_what_was_seen_since(dry):
    late = {"percept": "target", "delay": "0.25 s", "duration": "0.5 s"}
    run = dry.run("stand", duration=1, script=[HERE, {"at": 0, "noise": late}])
    stamps = [sample.percepts["target"].stamp for sample in run.samples if sample.percepts]
    assert stamps == sorted(stamps)


# ---- what it is told ------------------------------------------------------------------------------------------------


def test_a_silent_decision_is_stopped_by_the_supervisor_and_goes_on(dry):
    run = dry.run("fetch", script=[{"at": 0.1, "silence": "0.3 s"}])
    assert run.succeeded
    assert [(stop.mode.value, stop.reason) for stop in run.stops] == [
        ("protective_stop", "decision silent for more than 100 ms")
    ]
    assert not dry.run("fetch", script=[{"at": 0.1, "silence": "80 ms"}]).stops


def test_late_commands_are_obeyed_later_or_refused(dry):
    def first(run):
        return next(state.time for state in run.states if state.command_sequence >= 0)

    def stands(run):
        return next(state.time for state in run.states if math.hypot(*state.stance[:2]) > 1)

    prompt, late = dry.run("fetch"), dry.run("fetch", script=[{"at": 0, "delay": "60 ms"}])
    assert (first(prompt), stands(prompt)) == pytest.approx((0.02, 0.02))
    assert (first(late), stands(late)) == pytest.approx((0.08, 0.08))
    assert late.succeeded
    too_late = dry.run("fetch", duration=1, script=[{"at": 0, "delay": "140 ms"}])
    assert not [state for state in too_late.states if state.command_sequence >= 0]
    assert any(text.startswith("refused a command: stamped") for text in texts(too_late))


def test_commands_are_prompt_again_when_a_delay_is_over(dry):
    run = dry.run("stand", duration=1, script=[{"at": 0.1, "delay": {"by": "60 ms", "duration": "0.3 s"}}])
    behind = {round(state.time, 2): round(state.time / 0.02) - 1 - state.command_sequence for state in run.states[1:]}
    assert (behind[0.1], behind[0.3], behind[0.6]) == (0, 3, 0)


def test_late_commands_are_late_for_the_simulated_robot_too(stage):
    run = stage.run("stand", duration=0.2, script=[{"at": 0, "delay": "40 ms"}])
    assert [state.command_sequence for state in run.states][:6] == [-1, -1, -1, 0, 1, 2]


# ---- its tree -------------------------------------------------------------------------------------------------------


def test_a_node_raises_in_the_tick_after_its_moment(dry):
    run = dry.run("fetch", script=[{"when": "distance(target) < 0.5 m", "raise": {"node": "reach", "message": "oh"}}])
    assert run.outcome == "error"
    assert "reach' raised InjectedError: oh" in run.reason
    assert run.time == pytest.approx(0.04)
    assert run.samples[-1].command is None
    assert run.stops[0].reason == "a node raised an exception"


@pytest.mark.parametrize("node", ["within", "act on target", "emergency_stop"])
def test_any_kind_of_node_can_raise(dry, node):
    run = dry.run("fetch", script=[{"at": 0.02, "raise": node}])
    assert run.outcome == "error"
    assert f"{node}' raised InjectedError: raised by the test" in run.reason


def test_what_never_happened_is_told_and_keeps_expectations_from_being_met(dry):
    far = {"when": "distance(target) > 5 m", "estop": "far", "optional": True}
    never = [{"at": 9, "lose": "target"}, {"at": 0, "raise": "turn"}, far]
    run = dry.run("fetch", script=[HERE, *never])
    assert run.succeeded
    told = ["at 9 s lose (percept target)", "at 0 s raise (node turn)", f"when {far['when']} estop (reason far)"]
    assert [missed.event for missed in run.missed] == run.report.staged["missed"] == told
    assert [line for line in run.report.staged["told"] if line.endswith(", which never happened")] == [
        f"{event}, which never happened" for event in told
    ]
    assert [text for text in texts(run) if "never" in text] == [f"staged: never happened: {event}" for event in told]
    with pytest.raises(AssertionError) as raised:
        run.expect("never: fell")
    assert str(raised.value).count("at 0.34 s the run was over, and it had never happened") == 2
    dry.run("fetch", script=[HERE, far]).expect("never: fell")


def test_parameters_of_nodes_are_set_while_they_run(dry):
    run = dry.run("fetch", script=[{"at": 0.0, "set": {"reach.hold": "1 s"}}])
    assert run.time == pytest.approx(0.34 + 0.7)
    assert dry.run("fetch").time == pytest.approx(0.34)


# ---- moments --------------------------------------------------------------------------------------------------------


def test_an_event_happens_once_in_the_tick_after_it_became_true(dry):
    push = {"when": "distance(target) < 0.5 m and hand_speed > 0", "estop": {}}
    with pytest.raises(UserError, match="event 1 of the script"):
        dry.run("fetch", script=[push])
    run = dry.run("fetch", script=[{"when": "distance(target) < 0.5 m", "estop": {}}])
    assert run.stops[0].time == pytest.approx(0.04, abs=0.02)
    assert [text for text in texts(run) if "staged: estop" in text] == [
        "staged: estop, for distance(target) 0.4 m < 0.5 m"
    ]


def test_a_moment_is_not_true_before_the_first_tick(dry):
    run = dry.run("stand", script=[{"when": "time >= 0 s", "estop": "now"}], duration=0.2)
    assert [event["time"] for event in run.report.events if "staged: estop" in event["text"]] == [0.02]


def test_events_are_written_as_in_files_or_made_in_python(stage):
    made = Event(at=0.1, push=Push(force=(0, 50, 0)))
    written = {"at": "100 ms", "push": {"force": [0, "50 N", 0]}}
    assert (
        stage.run("stand", duration=0.2, script=[made]).trace
        == stage.run("stand", duration=0.2, script=[written]).trace
    )


def test_what_a_file_can_say_events_made_in_python_can_too(dry):
    made = [
        Event(at="0.1 s", lose="target"),
        Event(when="approach runs", silence=Silence(duration="40 ms"), optional=True),
        Event(when=Claim.parse("reach runs", Place("")), set=Set(values={"reach.hold": "1 s"})),
        {"at": np.int64(1), "see": {"percept": "target", "position": np.float32([0.5, 0, 1])}},
    ]
    see = {"size": None, "confidence": 0.95, "duration": None}
    written = [
        {"at": 0.1, "lose": {"percept": "target", "duration": None}},
        {"when": "approach runs", "optional": True, "silence": {"duration": 0.04}},
        {"when": "reach runs", "set": {"reach.hold": "1 s"}},
        {"at": 1, "see": {"percept": "target", "position": [0.5, 0, 1], **see}},
    ]
    run = dry.run("fetch", script=made)
    assert run.trace == dry.run("fetch", script=written).trace
    assert run.report.staged["script"] == written


@pytest.mark.parametrize(
    ("event", "message"),
    [
        (Event(at=1), "event 1 of the script: error: this event does nothing"),
        (Event(estop=EStop()), "at a time or when something becomes true"),
        (Event(at=1, when="reach runs", estop=EStop()), "not both"),
        (Event(at=1, estop=EStop(), lose=Lose(percept="target")), "one fault, not estop and lose"),
        (Event(at=-1, estop=EStop()), "'at' must be >= 0, not -1"),
        (Event(at=math.nan, estop=EStop()), "'at' must be"),
        (Event(at=1, silence=Silence(duration=0)), "'duration' must be > 0"),
        (Event(at=1, silence=EStop()), "unknown key 'reason' of 'silence'"),
        (Event(at=1, estop=EStop), "'estop' cannot be <class"),
        ({"at": object()}, "'at' cannot be <object"),
        ({"at": 1}, r"event 1 of the script: error: this event does nothing.*\n.*valid: push, estop, reset"),
        ({"estop": {}}, "at a time or when something becomes true"),
        ({"at": 1, "when": "true", "estop": {}}, "not both"),
        ({"at": 1, "estop": {}, "lose": "target"}, "one fault, not estop and lose"),
        ({"at": 1, "estp": {}}, "did you mean 'estop'"),
        ({"at": 1, "lose": "targt"}, "did you mean 'target'"),
        ({"at": 1, "noise": {"percept": "target", "sigma": "3 kg"}}, "'sigma' has the unit 'kg'"),
        ({"at": 1, "raise": "rech"}, "did you mean 'reach'"),
        ({"at": 1, "set": {"reach.hld": 1}}, "did you mean 'hold'"),
        ({"at": 1, "set": "reach"}, "must be a mapping of names to values"),
        ({"at": 1, "push": {"force": [1, 0, 0], "body": "trso"}}, "there is no body 'trso'"),
        ({"at": 1, "weaken": {"joints": ["knee"], "to": 0.5}}, "the robot has no joint 'knee'"),
        ({"at": 1, "break": "giro"}, "the robot has no sensor 'giro'"),
        ({"at": 1, "break": "left_foot"}, "the robot has no sensor 'left_foot'"),
        ({"at": 1, "break": {"sensor": "imu", "how": "odd"}}, "'how' cannot be 'odd'"),
        ({"at": 1, "weaken": {"joints": ["*"], "to": 2}}, "'to' must be >= 0 and <= 1"),
        ({"when": "distance(cup) < 1 m", "estop": {}}, "there is no percept 'cup' in this run"),
        ({"when": "rech runs", "estop": {}}, "did you mean 'reach'"),
    ],
)
def test_what_a_script_cannot_mean_is_said_before_anything_moves(stage, event, message):
    with pytest.raises(UserError, match=message):
        stage.run("fetch", script=[event])


@pytest.mark.parametrize("script", ["estop", {"at": 1, "estop": {}}, Event(at=1, estop=EStop()), None])
def test_a_script_is_a_list(dry, script):
    with pytest.raises(UserError, match="a script is a list of events"):
        dry.run("fetch", script=script)


def test_a_moment_may_ask_what_nodes_do(dry):
    run = dry.run("fetch", script=[{"when": "approach succeeded and reach runs", "lose": "target"}])
    begun = next(entry["time"] for entry in run.report.timeline if entry["path"].endswith("/reach"))
    told = next(event["time"] for event in run.report.events if "staged: lose" in event["text"])
    assert told == pytest.approx(begun + 0.02)
