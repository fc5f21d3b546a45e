"""One servo cycle: measure, supervise, every so often plan the whole body, drive the joints.

A stop does not wait for the next plan: the whole body is planned anew in the cycle in which the supervisor orders it.
Nor does an arm that is to yield.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType as View

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.control.body.body import Body
from humanoid_bt.control.body.choice import bodies
from humanoid_bt.control.cycle_log import CycleLog
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.control.estimator.estimator import Estimator
from humanoid_bt.control.servo import Servo
from humanoid_bt.control.snapshot import copies
from humanoid_bt.control.supervisor import Supervisor
from humanoid_bt.core.clock import ESTIMATE_PERIOD, SERVO_PERIOD, cycles
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import (
    SIDES,
    Array,
    Command,
    Estimate,
    FootPose,
    Gait,
    HandTarget,
    Mode,
    Reading,
    Side,
    State,
    Target,
)
from humanoid_bt.core.palm import in_world, other_side, turn_left
from humanoid_bt.files.class_files import why_raised
from humanoid_bt.plant.interface import SILENT_AFTER, Plant
from humanoid_bt.robot.arms import arms_of
from humanoid_bt.robot.model import BASE_COORDINATES, RobotModel

_DAMP, _STAND = Mode.DAMP, Gait.STAND  # reading a member from its class costs more than comparing it
_SETTLED_AFTER = 0.2  # s of standing
_SETTLED_SPEED = 0.018  # m/s of the centre of mass, which then has less than 5 mm to go
_STIRRED_SPEED = 0.08  # m/s of it above which a robot that had settled has not any more: hands move it


class Controller:
    """Everything that runs at the servo's rate for one robot.

    Args:
        robot: the robot.
        plant: what it drives.
        place: where the robot stands, as in :meth:`reset`.
        waits: whether time stands still while something computes, as in lockstep; on the wall clock it does not.

    Attributes:
        supervisor: decides what is allowed.
        estimator: says where the robot is.
        body: plans the setpoints: the first of the robot's bodies that has not failed.
        body_failed: when the first of them failed in this run, and why, for people; "" while it plans.
        servo: drives the joints.
        log: is told every servo cycle, if there is one.
        cycle: servo cycles so far.
    """

    def __init__(
        self,
        robot: RobotModel,
        plant: Plant,
        place: tuple[float, float, float] = (0.0, 0.0, 0.0),
        *,
        waits: bool = True,
    ) -> None:
        self._robot, self._plant = robot, plant
        self.supervisor = Supervisor(robot.config.fall, arms_of(robot), robot.config.contact)
        dynamics = RobotDynamics(robot)
        self.estimator = Estimator(robot, dynamics)
        self._bodies = bodies(robot, dynamics, self.estimator.contact, waits=waits)
        self.body = self._bodies[0]
        self.servo = Servo(robot)
        self.log: CycleLog | None = None
        self._estimate_period = cycles(ESTIMATE_PERIOD)
        self._reading = Reading(len(robot.joint_names))
        self._limited = np.zeros(len(robot.joint_names), dtype=bool)
        self.reset(place)

    def reset(self, place: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        """Start a run with the robot standing at rest.

        Args:
            place: where it stands, as it is told: x, y [m] of the middle between its soles, and their heading [rad].
        """
        self.cycle = 0
        self._setpoint_fault = ""
        self._limp = False
        self._held = False
        self._silent = False
        self._at_rest = False
        self._next_plan = 0  # cycle
        self.body_failed = ""
        self._reading = self._plant.measure(self._reading)
        self.estimator.reset(self._reading, place)
        estimate = self.estimator.estimate
        self._take(self._bodies[0])
        for body in self._bodies:
            body.reset(estimate)
        self.servo.reset(estimate.qpos[BASE_COORDINATES:])
        self.supervisor.reset_run(float(estimate.qpos[2]))

    def submit(self, command: Command) -> bool:
        """Give a command from decision to the supervisor; return whether it is in force."""
        return self.supervisor.submit(command)

    def run_cycle(self) -> None:
        """Run one servo cycle."""
        self.run_cycles(1)

    def run_cycles(self, count: int) -> None:
        """Run so many servo cycles, one after the other.

        It is decided anew when something has changed that the supervisor looks at, or when a plan is due; in the cycles
        between, the drives follow the same command, and what the sensors say is heard.
        """
        end = self.cycle + count
        while self.cycle < end:
            self._decide()
            look = self.supervisor.next_look(self._setpoint_fault)
            self._drive(min(end, look, max(self._next_plan, self.cycle + 1)))

    def _decide(self) -> None:
        """Let the supervisor look at everything, and see to it that there is a command for the drives."""
        supervisor, estimator = self.supervisor, self.estimator
        estimate = estimator.estimate
        supervisor.check(self.cycle, estimate, self._setpoint_fault, estimator.watch.fault, self._plant.fault)
        if self.log is not None:
            self.log.begin(self.cycle + 1, supervisor, self.servo, self.body)
        if supervisor.mode is _DAMP:
            self._let_go()
        elif self._silent:
            self._wait()
        elif self.cycle >= self._next_plan or (supervisor.hold and not self._held):
            if self._limp:
                self._stand_up(estimate)
            self._plan(estimate)
            self._next_plan = self.cycle + self._body_period
        self._held = supervisor.hold

    def _drive(self, until: int) -> None:
        """Drive the joints and hear the sensors in this cycle, and up to another one if nothing changes before."""
        supervisor, estimator, plant, log, servo = self.supervisor, self.estimator, self._plant, self.log, self.servo
        estimate, command, fault, reading = estimator.estimate, servo.command, plant.fault, self._reading
        cycle = self.cycle
        while True:
            plant.step(command)
            self.cycle = cycle = cycle + 1
            if log is not None:
                reading = log.measured
            plant.measure(reading)
            self._silent = reading.age > SILENT_AFTER
            if self._silent:
                estimator.miss(reading)
            else:
                estimator.take(reading)
            heard = estimator.heard
            if heard >= self._estimate_period or (heard and cycle == self._next_plan):
                estimator.update(reading, servo.setpoint)
                self._feel()
            if log is not None:
                log.end(estimator.estimate)
            if cycle >= until or estimator.estimate is not estimate or plant.fault != fault:
                return
            supervisor.cycle = cycle
            if log is not None:
                log.begin(cycle + 1, supervisor, servo, self.body)

    def _plan(self, estimate: Estimate) -> None:
        supervisor, body = self.supervisor, self.body
        self._end_logged_plan()
        body.arms.sides = supervisor.touch.yielding
        try:
            setpoint = body.update(estimate, supervisor.targets, supervisor.hold)
        except Exception as error:
            if body is self._bodies[-1]:
                raise
            self._give_up(body, estimate, body.failure or why_raised(error, type(body)))
            return
        supervisor.touch.homeward = body.arms.homeward
        refused = self.servo.follow(setpoint, body.period)
        self._setpoint_fault = refused or body.fault
        still = body.gait is _STAND and body.still_for >= _SETTLED_AFTER
        self._at_rest = still and body.com_speed < (_STIRRED_SPEED if self._at_rest else _SETTLED_SPEED)
        if body.failure:
            self._give_up(body, estimate, body.failure)

    def _give_up(self, body: Body, estimate: Estimate, why: str) -> None:
        """Let the next body take the place of one that failed, for the rest of the run; the last one goes on."""
        self.supervisor.request_stop("body", why)
        self.body_failed = self.body_failed or f"its body failed after {self.cycle * SERVO_PERIOD:.1f} s: {why}"
        place = self._bodies.index(body) + 1
        if place < len(self._bodies):
            self._take(self._bodies[place])
            self.body.restart(estimate)

    def _take(self, body: Body) -> None:
        """Let a body plan from now on."""
        self.body, self._body_period = body, cycles(body.period)

    def _feel(self) -> None:
        """Tell the supervisor what pushes the robot, and the observer what of it is nothing that it carries.

        A robot that is limp lies on the floor: that is no contact that matters, and nothing that it carries.
        """
        supervisor, touch, contact = self.supervisor, self.supervisor.touch, self.estimator.contact
        if supervisor.mode is _DAMP:
            contact.reset()
            touch.reset()
            return
        pressed = touch.pressed
        supervisor.feel(contact.forces, self.estimator.estimate)
        if touch.pressed != pressed:
            contact.distrust(touch.pressed)
        if touch.yielding and touch.yielding - self.body.arms.sides:
            self._next_plan = self.cycle

    def _let_go(self) -> None:
        self._end_logged_plan()
        self.servo.damp()
        self._limp = True
        self._setpoint_fault = ""

    def _wait(self) -> None:
        """Hold the setpoint while the plant is silent, as it does itself, and let the plan go on from there.

        A plan that went on meanwhile would come as a blow: nothing has followed it.
        """
        if self.servo.moves:
            self._end_logged_plan()
            self.servo.hold()

    def _end_logged_plan(self) -> None:
        """Let the log take what is left of the last plan, before there is another one or none."""
        if self.log is not None:
            self.log.end_plan()

    def _stand_up(self, estimate: Estimate) -> None:
        """Stiffen limp joints where they are: the setpoints from before the fall would be a blow."""
        self.body.restart(estimate)
        self.servo.reset(estimate.qpos[BASE_COORDINATES:])
        self._limp = False

    @property
    def settled(self) -> bool:
        """Whether the robot stands, at rest, with no step pending; one that has settled may move its hands."""
        return self._at_rest and self.supervisor.mode is not _DAMP

    def state(self) -> State:
        """Return a snapshot of everything, into which nobody can write."""
        estimate, body, supervisor = self.estimator.estimate, self.body, self.supervisor
        dynamics, command, contacts = body.dynamics, supervisor.command, supervisor.touch.contacts
        joints, points, turns = copies(estimate, self.servo.command, dynamics, body.stance)
        positions, velocities, torques, setpoints, setpoint_velocities = joints
        place, velocity, rate, com, com_velocity, stance, eyes, view, *palms = points
        turn, *hand_turns = turns
        covariance = self.estimator.covariance
        covariance.setflags(write=False)
        for contact in contacts.values():
            contact.force.setflags(write=False)
        hands: dict[Side, Array] = dict(zip(dynamics.sides, palms, strict=True))
        targets = supervisor.targets
        hand_errors, turn_errors = _hand_errors(dynamics, targets)
        return State(
            time=estimate.time,
            cycle=self.cycle,
            joint_positions=positions,
            joint_velocities=velocities,
            joint_torques=torques,
            setpoint_positions=setpoints,
            setpoint_velocities=setpoint_velocities,
            base_position=place,
            base_quaternion=turn,
            base_linear_velocity=velocity,
            base_angular_velocity=rate,
            base_covariance=covariance,
            com=com,
            com_velocity=com_velocity,
            hands=View(hands),
            hand_orientations=View(dict(zip(dynamics.sides, hand_turns, strict=True))),
            feet=View(dynamics.feet),
            stance=stance,
            gaze_position=eyes,
            gaze_direction=view,
            foot_force=View(dict(zip(SIDES, estimate.foot_force.tolist(), strict=True))),
            gait=body.gait,
            footsteps=tuple([(step.side, _foot_pose(step.pose)) for step in body.footsteps]),
            base_settled=self.settled,
            mode=supervisor.mode,
            stop_reason=supervisor.reason,
            stop_source=supervisor.source,
            command_sequence=command.sequence if command else -1,
            command_sources=View(command.sources if command else {}),
            targets=View(targets),
            hand_errors=View(hand_errors),
            hand_turn_errors=View(turn_errors),
            hand_obstacles=View(body.hand_obstacles),
            limit_flags=self._limit_flags(),
            contacts=View(contacts),
        )

    def _limit_flags(self) -> tuple[str, ...]:
        """Return the joints whose setpoint was clamped or whose drive gives all the torque it has."""
        robot, limited = self._robot, self._limited
        if not _at_limit(self.estimator.estimate.joint_torque, robot.torque_limit, self.servo.limited, limited):
            return ()
        return tuple([name for name, one in zip(robot.joint_names, limited.tolist(), strict=True) if one])


def _hand_errors(dynamics: RobotDynamics, targets: Mapping[str, Target]) -> tuple[dict[Side, float], dict[Side, float]]:
    """Return how far the hands are from their targets [m], and how far they are turned from them [rad]."""
    errors: dict[Side, float] = {}
    turns: dict[Side, float] = {}
    for side in dynamics.sides:
        goal = targets.get(f"{side}_hand")
        if not isinstance(goal, HandTarget):
            continue
        if goal.relative:
            leader = other_side(side)
            goal = in_world(goal, dynamics.palm(leader), dynamics.palm_frame(leader))
        offset = goal.position - dynamics.palm(side)
        errors[side] = float((offset @ offset) ** 0.5)
        if goal.orientation is not None:
            turns[side] = turn_left(dynamics.palm_frame(side), goal.orientation)
    return errors, turns


def _foot_pose(pose: Array) -> FootPose:
    x, y, yaw = pose.tolist()
    return FootPose(x, y, yaw)


@compiled("b1(f8[::1], f8[::1], b1[::1], b1[::1])")
def _at_limit(torque: Array, most: Array, clamped: NDArray[np.bool_], limited: NDArray[np.bool_]) -> bool:
    """Write which joints give all their torque, or are clamped, each of shape (nj,); return whether any is."""
    found = False
    for joint in range(len(torque)):
        limited[joint] = clamped[joint] or abs(torque[joint]) >= most[joint]
        found = found or limited[joint]
    return found
