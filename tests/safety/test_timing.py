"""When a stop comes, in servo cycles of 1 ms."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.control.supervisor import DECISION_TIMEOUT, NO_SOLUTION_TIMEOUT
from humanoid_bt.core.clock import PERCEPTION_PERIOD, WHOLE_BODY_PERIOD, cycles
from humanoid_bt.core.messages import BaseTarget, Mode
from tests.safety.machine import TICK, Machine, Scripted
from tests.safety.rows import DAMAGES, RUN, damaged, killed, knocked_over, stopped, unsolvable
from tests.safety.trials import shared_machine

SILENCE = cycles(DECISION_TIMEOUT)
WALK = {"base": BaseTarget(np.array([3.0, 0.0]), 0.0)}
RNG = np.random.default_rng(0)


@pytest.fixture
def machine() -> Machine:
    """A robot that begins to walk."""
    machine = shared_machine()
    machine.reset()
    machine.decision = Scripted(lambda _: WALK)
    return machine


@pytest.mark.parametrize("phase", [0, *(pytest.param(phase, marks=pytest.mark.trials) for phase in (1, 7)), 19])
def test_silence_ends_in_a_stop_exactly_at_its_timeout(machine: Machine, phase: int) -> None:
    machine.run(700 + phase)
    last = (machine.cycle - 1) // TICK * TICK  # the cycle before which decision was last heard
    killed(machine, RNG)
    machine.run(SILENCE + TICK)
    assert machine.modes == [(last + SILENCE, Mode.PROTECTIVE_STOP)]


@pytest.mark.parametrize("damage", DAMAGES)
def test_bad_commands_count_as_silence(machine: Machine, damage: str) -> None:
    machine.run(705)
    damaged(DAMAGES[damage])(machine, RNG)
    machine.run(SILENCE + TICK)
    assert machine.modes == [(700 + SILENCE, Mode.PROTECTIVE_STOP)]
    assert len(machine.supervisor.rejected) >= SILENCE // TICK


def test_the_first_fresh_command_ends_a_protective_stop_in_its_own_cycle(machine: Machine) -> None:
    machine.run(700)
    stopped(machine, RNG)  # until cycle 1200, in which a tick is due
    machine.run(700)
    assert machine.modes[1:] == [(1200, RUN)]


@pytest.mark.parametrize("phase", range(6))
def test_an_emergency_stop_drives_the_joints_with_a_safe_setpoint_in_the_very_next_cycle(
    machine: Machine, phase: int
) -> None:
    machine.run(700 + phase)
    before = machine.controller.servo.command
    raised = machine.cycle
    machine.supervisor.raise_estop("test", "pressed")
    machine.run(1)
    assert machine.modes == [(raised, Mode.EMERGENCY_STOP)]
    assert machine.supervisor.targets == {}
    assert machine.controller.servo.command is not before


def test_no_solution_ends_in_a_stop_at_its_timeout_after_the_first_failure(machine: Machine) -> None:
    machine.run(1301)
    unsolvable(0.5)(machine, RNG)
    machine.run(400)
    first = 1301 + cycles(WHOLE_BODY_PERIOD) - 1  # the next cycle that plans
    assert machine.modes == [(first + cycles(NO_SOLUTION_TIMEOUT) + 1, Mode.PROTECTIVE_STOP)]


def test_the_joints_go_limp_in_the_cycle_in_which_a_fall_is_seen(machine: Machine) -> None:
    machine.run(300)
    knocked_over(machine, RNG)
    stiff = [True]
    while machine.supervisor.mode is Mode.RUN and machine.cycle < 3000:
        machine.run(1)
        stiff.append(bool(machine.controller.servo.command.stiffness.any()))
    assert machine.supervisor.mode is Mode.DAMP
    assert stiff[-2:] == [True, False]


def test_a_tree_stops_walking_in_the_tick_in_which_its_percept_is_too_old(machine: Machine) -> None:
    machine.sees.see("target", [3.0, 0.0, 0.9], 0.95)
    machine.follow_tree("fetch")  # its watchdog waits 0.5 s
    machine.run(1450)
    assert machine.last_command is not None
    assert "base" in machine.last_command.targets
    machine.kill_perception()
    last_seen = machine.cycle // cycles(PERCEPTION_PERIOD) * cycles(PERCEPTION_PERIOD)
    walked_until = 0
    while machine.cycle < last_seen + 700:
        machine.run(TICK)
        if "base" in machine.last_command.targets:
            walked_until = machine.cycle
    assert 0 <= last_seen + 500 + TICK - walked_until <= TICK
    assert machine.supervisor.mode is RUN
