"""Servo cycles in which nothing is decided: a run of many at once is that of one after the other, to the bit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import count

import numpy as np
import pytest

from humanoid_bt.control.body.quadratic_program import QuadraticProgram
from humanoid_bt.control.cycle_log import CycleLog, Layout
from humanoid_bt.control.supervisor import Supervisor
from humanoid_bt.core.messages import BaseTarget, Gait, HandTarget, JointCommand, Mode, Reading, Target
from humanoid_bt.link.wire import encode_state
from tests.control.control_rig import ControlRig

WALK = {"base": BaseTarget(np.array([0.5, 0.0]), 0.0), "left_hand": HandTarget(np.array([0.35, 0.2, 0.9]))}
EVENT = 333  # servo cycle, in the midst of everything that has a period
END = 700
_MORE = END // 20 + 1

Prepare = Callable[[ControlRig, pytest.MonkeyPatch], None]


def _nothing(_rig: ControlRig, _patch: pytest.MonkeyPatch) -> None:
    pass


def _emergency_stop(rig: ControlRig, _patch: pytest.MonkeyPatch) -> None:
    rig.controller.supervisor.raise_estop("a test", "to see it")


def _reset_of_a_stop(rig: ControlRig, patch: pytest.MonkeyPatch) -> None:
    _emergency_stop(rig, patch)
    rig.controller.run_cycles(40)
    assert rig.controller.supervisor.reset() == ""


def _fall(rig: ControlRig, _patch: pytest.MonkeyPatch) -> None:
    rig.plant.push("torso", np.array([900.0, 0.0, 0.0]), 0.3)


def _fall_and_reset(rig: ControlRig, patch: pytest.MonkeyPatch) -> None:
    """Limp joints become stiff again where they are."""
    _fall(rig, patch)
    while rig.controller.supervisor.mode is not Mode.DAMP:
        rig.controller.run_cycles(1)
    patch.setattr(rig.controller.supervisor, "_why_falling", lambda _: "")
    rig.controller.run_cycles(20)
    rig.controller.supervisor.reset()


def _failing_sensor(rig: ControlRig, _patch: pytest.MonkeyPatch) -> None:
    rig.plant.fail_sensor("gyro", "silent")


def _plant_that_is_silent(rig: ControlRig, patch: pytest.MonkeyPatch) -> None:
    rig.silence(patch, 0.1)


def _plant_that_is_late(rig: ControlRig, patch: pytest.MonkeyPatch) -> None:
    rig.silence(patch, 0.013)


def _plant_that_is_silent_without_a_fault(rig: ControlRig, patch: pytest.MonkeyPatch) -> None:
    rig.silence(patch, 0.1)
    told = rig.plant.measure

    def measured(into: Reading | None = None) -> Reading:
        reading = told(into)
        patch.setattr(rig.plant, "fault", "")
        return reading

    patch.setattr(rig.plant, "measure", measured)


def _plant_with_a_fault(rig: ControlRig, patch: pytest.MonkeyPatch) -> None:
    """It comes and goes between two estimates, and what is measured is as ever."""
    step = rig.plant.step

    def stepped(command: JointCommand) -> None:
        step(command)
        patch.setattr(rig.plant, "fault", "it is hot" if 336 < rig.plant.cycle < 373 else "")

    patch.setattr(rig.plant, "step", stepped)


def _no_solution_for_a_while(_rig: ControlRig, patch: pytest.MonkeyPatch) -> None:
    solve, plans = QuadraticProgram.solve, count()
    patch.setattr(QuadraticProgram, "solve", lambda of: solve(of) if next(plans) > 24 else None)


def _last_command(rig: ControlRig, _patch: pytest.MonkeyPatch) -> None:
    """It comes between two ticks, and so does the end of the time for which decision may be silent."""
    rig.command(WALK)


def _no_solution(_rig: ControlRig, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(QuadraticProgram, "solve", lambda _: None)


def _arm_in_the_way(rig: ControlRig, _patch: pytest.MonkeyPatch) -> None:
    rig.plant.push("left_hand", np.array([-60.0, 0.0, 0.0]), 0.2)


def _request(rig: ControlRig, _patch: pytest.MonkeyPatch) -> None:
    rig.controller.supervisor.request_stop("a test", "a skill raised")


def _ran(
    rig: ControlRig, prepare: Prepare, targets: Mapping[str, Target], ticks: int, *, at_once: bool
) -> tuple[list[bytes], list[bytes], list[str]]:
    """Return the states of all ticks, the rows that were logged, and what was stopped or refused and when."""
    rig.reset()
    controller, layout = rig.controller, Layout.of(rig.robot.joint_names)
    tables = layout.local()
    controller.log = CycleLog(*tables, layout)
    states, rows, given = list[bytes](), list[bytes](), 0
    cycles = controller.run_cycles if at_once else _one_by_one(controller.run_cycles)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(controller, "run_cycles", cycles)
        while controller.cycle < END:
            if controller.cycle % 20 == 0 and given < ticks:
                given += 1
                rig.command(targets)
            if controller.cycle == EVENT:
                prepare(rig, patch)
            until = controller.cycle // 20 * 20 + 20
            cycles((EVENT if controller.cycle < EVENT < until else until) - controller.cycle)
            states.append(encode_state(controller.state()))
            rows += [table.take().tobytes() for table in tables]
    controller.log = None
    supervisor = controller.supervisor
    return states, rows, [*map(str, supervisor.stops), *supervisor.rejected]


def _one_by_one(run_cycles: Callable[[int], None]) -> Callable[[int], None]:
    def run(number: int) -> None:
        for _ in range(number):
            run_cycles(1)

    return run


@pytest.mark.parametrize(
    ("prepare", "mode"),
    [
        (_nothing, Mode.RUN),
        (_emergency_stop, Mode.EMERGENCY_STOP),
        (_reset_of_a_stop, Mode.RUN),
        (_fall, Mode.DAMP),
        (_fall_and_reset, Mode.RUN),
        (_failing_sensor, Mode.PROTECTIVE_STOP),
        (_plant_that_is_silent, Mode.RUN),
        (_plant_that_is_late, Mode.RUN),
        (_plant_that_is_silent_without_a_fault, Mode.RUN),
        (_plant_with_a_fault, Mode.RUN),
        (_no_solution, Mode.PROTECTIVE_STOP),
        (_no_solution_for_a_while, Mode.RUN),
        (_arm_in_the_way, Mode.RUN),
        (_request, Mode.PROTECTIVE_STOP),
    ],
)
def test_whatever_happens_a_run_is_the_same_to_the_bit(rig: ControlRig, prepare: Prepare, mode: Mode) -> None:
    one_by_one = _ran(rig, prepare, WALK, _MORE, at_once=False)
    assert rig.controller.supervisor.mode is mode
    states, rows, told = _ran(rig, prepare, WALK, _MORE, at_once=True)
    assert told == one_by_one[2]
    assert states == one_by_one[0]
    assert b"".join(rows[1::2]) == b"".join(one_by_one[1][1::2])
    assert b"".join(rows[::2]) == b"".join(one_by_one[1][::2])


@pytest.mark.parametrize(("prepare", "ticks", "stops"), [(_nothing, 0, 0), (_nothing, 3, 1), (_last_command, 13, 1)])
def test_silence_of_decision_is_noticed_in_the_same_cycle(
    rig: ControlRig, prepare: Prepare, ticks: int, stops: int
) -> None:
    one_by_one = _ran(rig, prepare, WALK, ticks, at_once=False)
    assert len(one_by_one[2]) == stops
    assert _ran(rig, prepare, WALK, ticks, at_once=True) == one_by_one


def test_what_has_not_changed_is_looked_at_once_in_five_cycles(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    looked = list[int]()
    check = Supervisor.check

    def spy(supervisor: Supervisor, cycle: int, *rest: object) -> None:
        looked.append(cycle)
        check(supervisor, cycle, *rest)  # type: ignore[arg-type]  # as they were given

    rig.command(WALK)
    rig.controller.run_cycles(20)
    monkeypatch.setattr(Supervisor, "check", spy)
    rig.command(WALK)
    rig.controller.run_cycles(20)
    assert looked == [20, 25, 30, 35]
    assert rig.state.gait is Gait.STEP
