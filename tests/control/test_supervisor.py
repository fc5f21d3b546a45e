from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.messages import (
    ArmTarget,
    BaseTarget,
    Command,
    Estimate,
    GazeTarget,
    HandTarget,
    Mode,
    Pointing,
    PostureTarget,
    Target,
)
from tests.control.supervised import HAND, HEIGHT, SOURCES, UPRIGHT, Run, lying, on_its_side


@pytest.fixture
def run() -> Run:
    return Run()


def test_it_begins_in_run_with_nothing_commanded(run: Run) -> None:
    run.go(1000)
    assert run.mode is Mode.RUN
    assert not run.supervisor.hold
    assert run.supervisor.targets == {}
    assert run.supervisor.stops == []


def test_an_accepted_command_is_in_force(run: Run) -> None:
    assert run.send()
    run.go()
    assert run.supervisor.targets is HAND
    assert not run.supervisor.hold


# ---- emergency stop -------------------------------------------------------------------------------------------------


def test_an_emergency_stop_is_latched_until_reset(run: Run) -> None:
    run.send()
    run.supervisor.raise_estop("keyboard", "pressed")
    run.go(500, alive=True)
    assert run.mode is Mode.EMERGENCY_STOP
    assert run.supervisor.hold
    assert run.supervisor.targets == {}
    assert (run.supervisor.reason, run.supervisor.source) == ("pressed", "keyboard")
    assert run.supervisor.reset() == ""
    run.go()
    assert run.mode is Mode.RUN
    assert (run.supervisor.reason, run.supervisor.source) == ("", "")


def test_it_acts_in_the_next_cycle_and_names_the_first_who_raised_it(run: Run) -> None:
    run.supervisor.raise_estop("tree", "too near")
    run.supervisor.raise_estop("keyboard", "pressed")
    run.go()
    assert run.mode is Mode.EMERGENCY_STOP
    assert run.supervisor.source == "tree"
    assert len(run.supervisor.stops) == 1


def test_whatever_lines_its_reason_has_it_is_told_in_one(run: Run) -> None:
    run.supervisor.raise_estop("key\nboard", "in\nthe\tway")
    run.go()
    assert (run.supervisor.source, run.supervisor.reason) == ("key board", "in the way")


def test_after_a_reset_the_old_command_is_not_taken_up_again(run: Run) -> None:
    run.send()
    run.supervisor.raise_estop("keyboard", "pressed")
    run.go(50)
    run.supervisor.reset()
    run.go()
    assert run.mode is Mode.RUN
    assert run.supervisor.targets == {}
    run.go(101)
    assert run.mode is Mode.PROTECTIVE_STOP  # decision is silent: it was alive before
    assert run.send()
    run.go()
    assert run.supervisor.targets is HAND


def test_a_reset_does_not_let_old_commands_in(run: Run) -> None:
    run.send()
    run.supervisor.raise_estop("keyboard", "pressed")
    run.go()
    run.supervisor.reset()
    assert not run.send(sequence=run.sequence)
    assert "out of order" in run.supervisor.rejected[-1]


def test_a_reset_cannot_clear_a_stop_that_no_cycle_has_seen(run: Run) -> None:
    run.supervisor.raise_estop("keyboard", "pressed")
    assert run.supervisor.reset() == ""
    run.go()
    assert run.mode is Mode.EMERGENCY_STOP


def test_what_blocks_the_robot_stops_it_until_a_reset(run: Run) -> None:
    ahead: dict[str, Target] = {"base": BaseTarget(np.array([2.0, 0.0]), 0.0)}
    for _ in range(120):
        run.go(90)
        run.send(ahead)
        run.supervisor.feel({"torso": np.array([-60.0, 0.0, 0.0])}, UPRIGHT)
    run.go()
    assert run.mode is Mode.EMERGENCY_STOP
    assert run.supervisor.reason == "something is in the way of the torso: 60 N, for more than 10 s"
    run.supervisor.reset()
    run.supervisor.feel({"torso": np.zeros(3)}, UPRIGHT)
    run.go()
    assert run.mode is Mode.RUN


# ---- silent decision ------------------------------------------------------------------------------------------------


def test_silent_decision_is_a_protective_stop_until_fresh_commands_come(run: Run) -> None:
    run.send()
    run.go(100)
    assert run.mode is Mode.RUN
    run.go(1)
    assert run.mode is Mode.PROTECTIVE_STOP
    assert run.supervisor.hold
    assert run.supervisor.targets == {}
    assert "silent" in run.supervisor.reason
    run.go(1000)
    assert run.send()
    run.go()
    assert run.mode is Mode.RUN
    assert run.supervisor.targets is HAND
    assert [stop.mode for stop in run.supervisor.stops] == [Mode.PROTECTIVE_STOP]


def test_a_silence_is_forgiven_once_and_never_starts_a_stopped_robot(run: Run) -> None:
    run.send()
    run.go(90)
    run.supervisor.forgive_silence()
    run.go(90)
    assert run.mode is Mode.RUN
    run.supervisor.forgive_silence()
    run.go(20)
    assert run.mode is Mode.PROTECTIVE_STOP
    run.supervisor.forgive_silence()
    run.go()
    assert run.mode is Mode.PROTECTIVE_STOP
    run.send()
    run.go(90)
    run.supervisor.forgive_silence()  # another silence
    run.go(90)
    assert run.mode is Mode.RUN


def test_a_stopped_robot_is_not_started_by_the_first_forgiveness_either(run: Run) -> None:
    run.send()
    run.go(101)
    run.supervisor.forgive_silence()
    run.go()
    assert run.mode is Mode.PROTECTIVE_STOP


def test_a_reset_before_decision_s_first_command_does_not_begin_a_silence(run: Run) -> None:
    run.supervisor.raise_estop("keyboard", "pressed")
    run.go()
    run.supervisor.reset()
    run.go(200)
    assert run.mode is Mode.RUN


def test_a_late_command_is_no_reason_why_the_ones_before_were_refused(run: Run) -> None:
    run.send()
    assert not run.send({"left_hand": HandTarget(np.full(3, np.nan))})
    assert not run.send(sequence=1)
    run.go(101)
    assert run.supervisor.reason.endswith("is not finite (from 'root/reach')")


def test_rejected_commands_do_not_keep_decision_alive(run: Run) -> None:
    run.send()
    for place in (np.nan,) * 6 + (1e9,) * 6:  # another reason later is no other stop
        run.go(20)
        assert not run.send({"left_hand": HandTarget(np.full(3, place))})
    assert run.mode is Mode.PROTECTIVE_STOP
    why = "what it commands is refused: the target of 'left_hand' is not finite"
    assert run.supervisor.reason.startswith(f"decision silent for more than 100 ms: {why}")
    assert len(run.supervisor.stops) == 1


def test_a_requested_stop_stays_whatever_decision_sends(run: Run) -> None:
    run.send()
    run.supervisor.request_stop("the tree", "it failed")
    run.go(300, alive=True)
    assert run.mode is Mode.PROTECTIVE_STOP
    assert (run.supervisor.reason, run.supervisor.source) == ("it failed", "the tree")


def test_a_new_cause_of_a_protective_stop_is_told(run: Run) -> None:
    run.send()
    run.go(150)
    run.supervisor.request_stop("the tree", "it failed")
    run.go(50, alive=True)
    assert [stop.reason for stop in run.supervisor.stops] == ["decision silent for more than 100 ms", "it failed"]
    assert run.supervisor.reason == "it failed"


# ---- commands that are not intact -----------------------------------------------------------------------------------

GOOD = np.array([0.4, 0.1, 0.9])


@pytest.mark.parametrize(
    ("targets", "why"),
    [
        ({"left_hand": HandTarget(np.array([0.4, np.nan, 0.9]))}, "not finite"),
        ({"left_hand": HandTarget(np.array([0.4, np.inf, 0.9]))}, "not finite"),
        ({"base": BaseTarget(np.zeros(2), math.nan)}, "not finite"),
        ({"posture": PostureTarget(math.inf)}, "not finite"),
        ({"base": BaseTarget(np.array([1e5, 0]), 0.0)}, "out of range"),
        ({"posture": PostureTarget(-3.0)}, "out of range"),
        ({"gaze": GazeTarget(np.array([0, 0, 1e4]))}, "out of range"),
        ({"left_hand": HandTarget(np.zeros(2))}, "malformed"),
        ({"left_hand": HandTarget(np.zeros((3, 1)))}, "malformed"),
        ({"base": BaseTarget(np.zeros((2, 1)), 0.0)}, "malformed"),
        ({"left_hand": HandTarget(np.array(["a", "b", "c"]))}, "malformed"),  # type: ignore[arg-type]  # the mistake that is tried
        ({"left_hand": HandTarget(None)}, "malformed"),  # type: ignore[arg-type]  # the mistake that is tried
        ({"base": BaseTarget(np.zeros(2), "north")}, "malformed"),  # type: ignore[arg-type]  # the mistake that is tried
        ({"left_hand": BaseTarget(np.zeros(2), 0.0)}, "cannot take a BaseTarget"),
        ({"tail": HandTarget(GOOD)}, "cannot take a HandTarget"),
        ({"left_hand": GOOD}, "cannot take a ndarray"),
        (None, "malformed"),
        ({"left_hand": HandTarget(GOOD, np.array([1.0, 0, 0, np.nan]))}, "an orientation that is not finite"),
        ({"left_hand": HandTarget(GOOD, np.zeros(4))}, "an orientation of length 0 and not 1"),
        ({"left_hand": HandTarget(GOOD, np.zeros(3))}, "an orientation that is malformed"),
        ({"left_hand": HandTarget(GOOD, Pointing(np.array([0, 0, 2.0])))}, "a direction of length 2 and not 1"),
        ({"left_hand": HandTarget(GOOD, Pointing(np.zeros(4)))}, "a direction that is malformed"),
        ({"left_hand": HandTarget(GOOD, Pointing(np.eye(3)[0], "thumb"))}, "no axis of a palm"),  # type: ignore[arg-type]  # the mistake that is tried
        ({"left_hand": HandTarget(GOOD, speed=0.0)}, "the speed 0.0, which is not above 0"),
        ({"left_hand": HandTarget(GOOD, speed=math.nan)}, "a speed that is not finite"),
        ({"left_hand": HandTarget(GOOD, speed="fast")}, "malformed"),  # type: ignore[arg-type]  # the mistake that is tried
        ({"left_hand": HandTarget(GOOD, relative=True)}, "relative to 'right_hand', for which there is no position"),
        (
            {"left_hand": HandTarget(GOOD, relative=True), "right_hand": HandTarget(GOOD, relative=True)},
            "is relative to 'right_hand'",
        ),
        ({"left_hand": ArmTarget({})}, "names no joint"),
        ({"left_hand": ArmTarget({"left_elbow": math.nan})}, "not finite: nan rad of 'left_elbow'"),
        (
            {"left_hand": ArmTarget({"left_elbow": 1.2})},
            "asks 1.2 rad of 'left_elbow', whose limits are -2.28 to",
        ),
        ({"left_hand": ArmTarget({"right_elbow": -1.0})}, "names 'right_elbow', a joint of the right arm"),
        ({"left_hand": ArmTarget({"left_elbo": -1.0})}, "did you mean 'left_elbow'?"),
        ({"left_hand": ArmTarget({"left_elbow": -1.0}, speed=-1.0)}, "the speed -1.0, which is not above 0"),
        ({"base": ArmTarget({"left_elbow": -1.0})}, "cannot take a ArmTarget"),
    ],
)
def test_a_command_that_is_not_intact_is_refused_and_the_last_good_one_holds(run: Run, targets: Any, why: str) -> None:
    run.send()
    run.go(50)
    assert not run.send(targets)
    assert why in run.supervisor.rejected[-1]
    run.go()
    assert run.mode is Mode.RUN
    assert run.supervisor.targets is HAND


def test_a_refusal_names_the_node_that_commanded(run: Run) -> None:
    run.send({"left_hand": HandTarget(np.full(3, np.nan))})
    assert "'root/reach'" in run.supervisor.rejected[-1]


@pytest.mark.parametrize("age", [0.12, -0.12, math.nan])
def test_a_command_from_another_time_is_refused(run: Run, age: float) -> None:
    run.go(500)
    assert not run.send(age=age)
    assert "stamped" in run.supervisor.rejected[-1]
    assert run.supervisor.targets == {}


@pytest.mark.parametrize("sequence", [5, 4, -1])
def test_repeated_and_overtaken_commands_are_refused(run: Run, sequence: int) -> None:
    run.send(sequence=5)
    assert not run.send({}, sequence=sequence)
    assert run.supervisor.targets is HAND
    assert run.send({}, sequence=6)


@pytest.mark.parametrize("junk", [None, "go", Command("x", 0.0), Command(9, None)])  # type: ignore[arg-type]  # the mistake that is tried
def test_junk_is_refused(run: Run, junk: Any) -> None:
    run.send()
    assert not run.supervisor.submit(junk)
    assert "malformed" in run.supervisor.rejected[-1]


# ---- no valid setpoint ----------------------------------------------------------------------------------------------


def test_no_valid_setpoint_for_a_while_is_a_protective_stop_until_there_is_one(run: Run) -> None:
    run.go(200, fault="no solution", alive=True)
    assert run.mode is Mode.RUN
    assert run.supervisor.rejected == ["setpoint at 0.001 s: no solution"]  # told once, not in every cycle
    run.go(1, fault="no solution", alive=True)
    assert run.mode is Mode.PROTECTIVE_STOP
    assert run.supervisor.reason == "no solution for more than 200 ms"
    run.go(1, alive=True)
    assert run.mode is Mode.RUN


def test_a_solution_in_between_starts_the_count_again(run: Run) -> None:
    for _ in range(3):
        run.go(150, fault="no solution", alive=True)
        run.go(1, alive=True)
    assert run.mode is Mode.RUN
    assert run.supervisor.stops == []


# ---- falling --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("estimate", "why"),
    [
        (lying(pitch=0.95), "tilted"),
        (lying(pitch=-0.95), "tilted"),
        (lying(pitch=3.0), "tilted"),
        (on_its_side(0.95), "tilted"),
        (on_its_side(-0.95), "tilted"),
        (lying(pitch=0.0, height=0.41), "low"),
        (replace(UPRIGHT, qpos=np.full(9, np.nan)), "not finite"),
        (replace(UPRIGHT, qvel=np.full(8, np.inf)), "not finite"),
    ],
)
def test_a_falling_robot_is_damped_and_that_is_latched(run: Run, estimate: Estimate, why: str) -> None:
    run.send()
    run.go(1, estimate)
    assert run.mode is Mode.DAMP
    assert why in run.supervisor.reason
    assert run.supervisor.targets == {}
    run.go(300, alive=True)  # it got up, and decision is alive
    assert run.mode is Mode.DAMP


@pytest.mark.parametrize("estimate", [lying(pitch=0.8), lying(pitch=0.0, height=0.44)])
def test_leaning_and_crouching_are_not_falling(run: Run, estimate: Estimate) -> None:
    run.go(10, estimate)
    assert run.mode is Mode.RUN


def test_reset_is_refused_while_the_robot_lies(run: Run) -> None:
    run.go(10, lying())
    assert "falling" in run.supervisor.reset()
    assert run.mode is Mode.DAMP
    run.go(1)
    assert run.supervisor.reset() == ""
    run.go(1)
    assert run.mode is Mode.RUN


# ---- precedence and records -----------------------------------------------------------------------------------------


def test_an_emergency_stop_outranks_a_protective_stop(run: Run) -> None:
    run.send()
    run.go(150)
    assert run.mode is Mode.PROTECTIVE_STOP
    run.supervisor.raise_estop("keyboard", "pressed")
    run.go(1)
    assert run.mode is Mode.EMERGENCY_STOP
    run.go(300)  # decision is silent all the time
    assert run.supervisor.reason == "pressed"


def test_falling_outranks_an_emergency_stop_and_one_reset_clears_both(run: Run) -> None:
    run.supervisor.raise_estop("keyboard", "pressed")
    run.go(10)
    run.go(1, lying())
    assert run.mode is Mode.DAMP
    run.go(10)
    assert run.mode is Mode.DAMP
    assert run.supervisor.reset() == ""
    run.go(1)
    assert run.mode is Mode.RUN


def test_an_emergency_stop_raised_while_lying_stays_until_reset(run: Run) -> None:
    run.go(1, lying())
    run.supervisor.raise_estop("keyboard", "pressed")
    run.go(10, lying())
    assert run.mode is Mode.DAMP
    assert run.supervisor.reset() != ""
    run.go(1)
    assert run.mode is Mode.DAMP


def test_a_stop_records_when_why_and_who_commanded_what(run: Run) -> None:
    run.send()
    run.go(40)
    run.supervisor.raise_estop("root/guard", "too near")
    run.go(2)
    (stop,) = run.supervisor.stops
    assert (stop.mode, stop.reason, stop.source) == (Mode.EMERGENCY_STOP, "too near", "root/guard")
    assert stop.time == pytest.approx(0.041)
    assert stop.resources == SOURCES


def test_a_new_run_forgets_everything(run: Run) -> None:
    run.send()
    run.supervisor.raise_estop("keyboard", "pressed")
    run.supervisor.request_stop("the tree", "it failed")
    run.go(5, lying())
    run.supervisor.reset_run(HEIGHT)
    assert (run.mode, run.supervisor.stops, run.supervisor.rejected) == (Mode.RUN, [], [])
    assert run.supervisor.targets == {}
    run.supervisor.check(0, UPRIGHT)
    assert run.supervisor.mode is Mode.RUN
    assert run.supervisor.submit(Command(0, 0.0, HAND, SOURCES))


@pytest.mark.parametrize("press", [-1.0, 51.0, math.nan])
def test_a_hand_that_is_to_press_absurdly_is_rejected(run: Run, press: float) -> None:
    assert not run.send({"left_hand": HandTarget(np.array([0.4, 0.1, 0.9]), press=press)})
    assert "presses with" in run.supervisor.rejected[-1]
    assert run.send({"left_hand": HandTarget(np.array([0.4, 0.1, 0.9]), press=10.0)})
