"""The safety table's rows as data: how each fault is made, which modes must follow, and what ends them."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from threading import Event
from typing import Any

import mink
import numpy as np

from humanoid_bt.control.body.planar import ahead
from humanoid_bt.control.body.policy import inference
from humanoid_bt.control.body.policy.upper_body import UpperBody
from humanoid_bt.core.clock import cycles
from humanoid_bt.core.messages import SIDES, BaseTarget, Command, HandTarget, Mode, Pause, Reading
from humanoid_bt.plant.sensor_failures import FAILURES, FOOT_SENSORS
from humanoid_bt.robot.policy.network import Network, Tensor
from tests.safety.machine import Machine, Scripted, intact, resent, seconds

STOP, PROTECT, DAMP, RUN, PAUSED = Mode.EMERGENCY_STOP, Mode.PROTECTIVE_STOP, Mode.DAMP, Mode.RUN, Mode.PAUSED

_MEETS_FROM, _MEETS_EVERY = 1.5, 3.5  # s, in which a hand meets something
_NOTICED = 0.05  # s, in which a sensor that fails is noticed
_BLOW, _STAYS = (40.0, 0.1), (12.0, 0.7)  # N and s, of what it meets, first and then

Fault = Callable[[Machine, np.random.Generator], None]


@dataclass(frozen=True)
class Row:
    """One row.

    Attributes:
        name: of the row.
        fault: begins the fault; what ends it is scheduled on the machine.
        modes: the modes that must follow, in order; none: the mode stays RUN.
        ends: what ends the stop, or the fault.
        lasts: how long the fault is watched before the robot is let come to rest [s].
        releases: whether decision lets go of the robot then; otherwise the stop itself, or the tree, brings it to rest.
        stands: whether the robot must be standing in the end.
        tree: whether a tree decides, instead of a script.
        resets: whether the latched stop is reset in the end.
        promised: whether standing is promised, or only counted.
        may_fall: whether a fall that ends limp is as told, too.
        within: time in which the first of the modes must follow [s].
    """

    name: str
    fault: Fault
    modes: tuple[Mode, ...]
    ends: str
    lasts: float = 0.3
    releases: bool = False
    stands: bool = True
    tree: bool = False
    resets: bool = False
    promised: bool = True
    may_fall: bool = False
    within: float = math.inf


# ---- emergency stop, requested stop ---------------------------------------------------------------------------------


def estop(machine: Machine, _: np.random.Generator) -> None:
    machine.supervisor.raise_estop("test", "pressed")


def tree_failed(machine: Machine, _: np.random.Generator) -> None:
    machine.supervisor.request_stop("the tree", "a node raised an exception")


# ---- decision -------------------------------------------------------------------------------------------------------


def nothing(_: Command) -> list[Command]:
    return []


def killed(machine: Machine, _: np.random.Generator) -> None:
    machine.line = nothing


def stopped(machine: Machine, _: np.random.Generator) -> None:
    machine.line = nothing
    machine.after(0.5, lambda: setattr(machine, "line", intact))


def stuck(machine: Machine, _: np.random.Generator) -> None:
    """Nothing for a while, then whatever lay in memory."""
    machine.line = nothing
    machine.after(0.3, lambda: setattr(machine, "line", garbage))


def garbage(command: Command) -> list[Any]:
    return [None, 7, "go", *(damage(command) for damage in DAMAGES.values()), Command("x", 0.0, None)]  # type: ignore[arg-type]  # what nobody may send


def paused(machine: Machine, _: np.random.Generator) -> None:
    """Every command asks for a pause from now on, instead of what decision wants."""
    machine.line = lambda command: [resent(command, targets={}, sources={}, pause=Pause("keyboard", "a key"))]


def paused_for_a_while(machine: Machine, rng: np.random.Generator) -> None:
    paused(machine, rng)
    machine.after(1.0, lambda: setattr(machine, "line", intact))


def killed_while_paused(machine: Machine, rng: np.random.Generator) -> None:
    paused(machine, rng)
    machine.after(0.5, lambda: killed(machine, rng))


# ---- commands -------------------------------------------------------------------------------------------------------

DAMAGES: dict[str, Callable[[Command], Command]] = {
    "not finite": lambda command: resent(command, targets={"left_hand": HandTarget(np.full(3, np.nan))}),
    "out of range": lambda command: resent(command, targets={"base": BaseTarget(np.array([1e6, 0.0]), 0.0)}),
    "stale": lambda command: resent(command, stamp=command.stamp - 0.2),
    "out of order": lambda command: resent(command, sequence=0),
    "malformed": lambda command: resent(command, targets={"base": HandTarget(np.zeros(3)), "tail": None}),
}


def damaged(damage: Callable[[Command], Command]) -> Fault:
    """Damage every command from now on."""

    def fault(machine: Machine, _: np.random.Generator) -> None:
        machine.line = lambda command: [damage(command)]

    return fault


def some_damaged(machine: Machine, rng: np.random.Generator) -> None:
    """Damage every second command, in another way each time."""
    pending = list(rng.permutation(list(DAMAGES)))

    def line(command: Command) -> list[Command]:
        if not pending or command.sequence % 2:
            return [command]
        return [DAMAGES[pending.pop()](command)]

    machine.line = line


# ---- perception -----------------------------------------------------------------------------------------------------


def blind(machine: Machine, _: np.random.Generator) -> None:
    machine.kill_perception()


def blind_for_a_while(machine: Machine, _: np.random.Generator) -> None:
    machine.kill_perception()
    machine.after(1.2, machine.revive_perception)


# ---- inverse kinematics ---------------------------------------------------------------------------------------------


class Contradiction(mink.Limit):  # type: ignore[misc]  # mink has no types
    """The first joint shall turn both ways: a problem without a solution."""

    def compute_qp_inequalities(self, configuration: mink.Configuration, dt: float) -> mink.Constraint:
        matrix = np.zeros((2, configuration.nv))
        matrix[0, 6], matrix[1, 6] = 1.0, -1.0
        return mink.Constraint(matrix, np.array([-1.0, -1.0]))


def unsolvable(duration: float) -> Fault:
    def fault(machine: Machine, _: np.random.Generator) -> None:
        kinematics = machine.controller.body.kinematics
        if isinstance(kinematics, UpperBody):  # of a learned walker: what it lends has no solution
            way = kinematics._way
            kinematics._way = lambda *_: None  # type: ignore[method-assign]  # of this one alone
            again = functools.partial(setattr, kinematics, "_way", way)
            machine.after(duration, again)
            machine.undo.append(again)
            return
        limits = kinematics.limits
        limits.append(Contradiction())
        machine.after(duration, lambda: limits.__delitem__(-1))
        machine.undo.append(lambda: limits.__delitem__(slice(1, None)))

    return fault


# ---- pushes ---------------------------------------------------------------------------------------------------------


def knocked_over(machine: Machine, rng: np.random.Generator) -> None:
    machine.plant.push(machine.robot.config.torso, 600 * _direction(rng), 0.2)


def pushed_while_stopped(machine: Machine, rng: np.random.Generator) -> None:
    machine.line = nothing
    machine.after(
        seconds(int(rng.integers(150, 1200))),
        lambda: machine.plant.push(machine.robot.config.torso, 60 * _direction(rng), 0.1),
    )


def _direction(rng: np.random.Generator) -> np.ndarray:
    angle = rng.uniform(-np.pi, np.pi)
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def arm_pushed(machine: Machine, rng: np.random.Generator) -> None:
    """Push a hand harder than an arm stands."""
    machine.plant.push(machine.robot.config.hands[SIDES[rng.integers(2)]].body, 60 * _direction(rng), 0.2)


def in_the_way(times: int) -> Fault:
    """Walk on and on, and have a hand pushed back, as by something that it meets, some times."""

    def fault(machine: Machine, _: np.random.Generator) -> None:
        stance = machine.state.stance
        goal = BaseTarget(ahead(stance, 6.0, 0.0)[:2], float(stance[2]))
        sequence = machine.last_command.sequence if machine.last_command else 0
        machine.decision = Scripted(lambda _: {"base": goal}, sequence)
        back = np.array([*(ahead(stance, -1.0, 0.0) - stance)[:2], 0.0])

        def push(force: float, duration: float) -> Callable[[], None]:
            return lambda: machine.plant.push(machine.robot.config.hands["left"].body, force * back, duration)

        for time in range(times):
            machine.after(_MEETS_FROM + _MEETS_EVERY * time, push(*_BLOW))
            machine.after(_MEETS_FROM + _MEETS_EVERY * time + _BLOW[1], push(*_STAYS))

    return fault


# ---- sensors --------------------------------------------------------------------------------------------------------


def imu_fails(how: str) -> Fault:
    """Let one of the IMU's sensors fail."""

    def fault(machine: Machine, rng: np.random.Generator) -> None:
        machine.plant.fail_sensor(str(rng.choice(["gyro", "accelerometer", "orientation"])), how)

    return fault


def joint_fails(how: str) -> Fault:
    """Let the sensors of a joint fail."""

    def fault(machine: Machine, rng: np.random.Generator) -> None:
        machine.plant.fail_sensor(str(rng.choice(machine.robot.joint_names)), how)

    return fault


def joint_is_wild(machine: Machine, rng: np.random.Generator) -> None:
    """Let a joint say speeds or torques that cannot be, while its angle is right."""
    sensor, most = [("joint_velocity", 500.0), ("joint_torque", 3000.0)][rng.integers(2)]
    joint, measure = rng.integers(len(machine.robot.joint_names)), machine.plant.measure

    def wild(into: Reading | None = None) -> Reading:
        reading = measure(into)
        getattr(reading, sensor)[joint] = rng.uniform(-most, most)
        return reading

    machine.plant.measure = wild  # type: ignore[method-assign]  # of this plant alone
    machine.undo.append(lambda: setattr(machine.plant, "measure", measure))


def foot_fails(how: str) -> Fault:
    """Let the force sensor of a foot fail."""

    def fault(machine: Machine, rng: np.random.Generator) -> None:
        machine.plant.fail_sensor(str(rng.choice(FOOT_SENSORS)), how)

    return fault


def blind_to_itself(machine: Machine, _: np.random.Generator) -> None:
    machine.plant.fail_sensor("imu", "silent")


# ---- a learned walker -----------------------------------------------------------------------------------------------


def policy_wrong(machine: Machine, _: np.random.Generator) -> None:
    """Have every answer of the network be no number from now on."""
    network = _network(machine)
    run = network.run
    network.run = lambda outputs, inputs: [np.full_like(answer, np.nan) for answer in run(outputs, inputs)]  # type: ignore[method-assign]  # of this network alone
    machine.undo.append(lambda: setattr(network, "run", run))


def policy_stuck(machine: Machine, _: np.random.Generator) -> None:
    """Have the network compute for ever from now on."""
    network, over, patience = _network(machine), Event(), inference.PATIENCE
    run = network.run

    def computes(_outputs: list[str], _inputs: Mapping[str, Tensor]) -> list[Tensor]:
        over.wait()
        raise RuntimeError("it was stuck")

    network.run = computes  # type: ignore[method-assign]  # of this network alone
    inference.PATIENCE = 0.5  # s: a trial is not to wait longer
    machine.undo += [over.set, lambda: setattr(network, "run", run), lambda: setattr(inference, "PATIENCE", patience)]


def _network(machine: Machine) -> Network:
    assert machine.robot.policy is not None, "the robot has no learned walker"
    return machine.robot.policy.network


def sensor_row(name: str, fault: Fault, *, promised: bool = True) -> Row:
    """Return the row of a sensor that fails."""
    return Row(name, fault, (PROTECT,), "the run's end", promised=promised, within=_NOTICED)


FRESH, NEVER = "fresh commands", "nothing here"

ROWS = {
    row.name: row
    for row in [
        Row("e-stop raised", estop, (STOP, RUN), "a reset", resets=True),
        Row("a node raised an exception", tree_failed, (PROTECT,), "the run's end"),
        Row("decision killed", killed, (PROTECT,), NEVER),
        Row("decision stopped for 0.5 s", stopped, (PROTECT, RUN), FRESH, lasts=1.2, releases=True),
        Row("paused for 1 s", paused_for_a_while, (PAUSED, RUN), "commands again", lasts=1.5, releases=True),
        Row("decision killed while paused", killed_while_paused, (PAUSED, PROTECT), NEVER, lasts=0.8),
        Row("decision stuck, then garbage", stuck, (PROTECT,), NEVER, lasts=0.6),
        *(Row(f"commands {name}", damaged(damage), (PROTECT,), NEVER) for name, damage in DAMAGES.items()),
        Row("single bad commands", some_damaged, (), "the next good command", lasts=0.5, releases=True),
        Row("perception dead", blind, (), NEVER, lasts=1.0, tree=True),
        Row("perception dead for 1.2 s", blind_for_a_while, (), "a fresh percept", lasts=1.8, releases=True, tree=True),
        Row("IK without solution for 0.1 s", unsolvable(0.1), (), "a solution", lasts=0.4, releases=True),
        Row("IK without solution for 0.5 s", unsolvable(0.5), (PROTECT, RUN), "a solution", lasts=1.2, releases=True),
        Row("knocked over, 600 N for 0.2 s", knocked_over, (DAMP,), "a reset, back on its feet", 2.0, stands=False),
        *(sensor_row(f"a sensor of the IMU {how}", imu_fails(how)) for how in FAILURES),
        *(sensor_row(f"the sensors of a joint {how}", joint_fails(how)) for how in FAILURES),
        sensor_row("a joint's speed or torque cannot be", joint_is_wild),
        sensor_row("the whole IMU silent", blind_to_itself, promised=False),
        Row("pushed, 60 N for 0.1 s, in a stop", pushed_while_stopped, (PROTECT,), NEVER, 1.3, promised=False),
        Row("a hand pushed, 60 N for 0.2 s", arm_pushed, (), "the hand let go of", lasts=1.0, releases=True),
        Row("something in a hand's way", in_the_way(1), (PROTECT, RUN), "nothing in the way", lasts=4.5, releases=True),
        Row("... and again, and again", in_the_way(3), (*(PROTECT, RUN) * 2, STOP, RUN), "a reset", 10.0, resets=True),
    ]
}

POLICY_ROWS = {
    row.name: row
    for row in [
        Row("the policy's answers not finite", policy_wrong, (PROTECT,), "the run's end", may_fall=True, within=0.085),
        Row("the policy never answers", policy_stuck, (PROTECT,), "the run's end", may_fall=True, within=0.085),
    ]
}
"""Further ones of a robot with a learned walker."""

FOOT_ROWS = {
    row.name: row for row in [sensor_row(f"a force sensor of the feet {how}", foot_fails(how)) for how in FAILURES]
}
"""Further ones of a robot with force sensors in its feet."""

SETTLE = cycles(5.0)
"""Servo cycles that the robot gets to come to a stand."""
