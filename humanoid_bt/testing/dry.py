"""A dry engine: no physics, the robot is at once where it is told to be. For the logic of trees, and nothing else."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.control.supervisor import Supervisor, reset_text
from humanoid_bt.core.clock import DECISION_PERIOD, PERCEPTION_PERIOD, CycleClock, cycles
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.geometry import (
    planar_pose,
    pose_product,
    quaternion,
    rotation_matrix,
    turn_of_axis,
    turned,
)
from humanoid_bt.core.kept import Kept
from humanoid_bt.core.messages import (
    SIDES,
    ArmTarget,
    Array,
    BaseTarget,
    Command,
    Estimate,
    FootPose,
    Gait,
    GazeTarget,
    HandTarget,
    Percept,
    Pointing,
    PostureTarget,
    Side,
    State,
)
from humanoid_bt.core.odometry import truth_of
from humanoid_bt.core.palm import axis_of, in_world, other_side
from humanoid_bt.link.run_folder import RunInfo
from humanoid_bt.link.wire import Event
from humanoid_bt.perception.interface import Perception
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_model import scene_model
from humanoid_bt.plant.touches import Touch
from humanoid_bt.robot.arms import arms_of
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel
from humanoid_bt.session.engine import Input
from humanoid_bt.tree.tree import Tree

_UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])
_GRAVITY = 9.81  # m/s^2
_DECISION, _LOOK = cycles(DECISION_PERIOD), cycles(PERCEPTION_PERIOD)


class Dry:
    """A robot in a scene that does at once, in one tick, what it is told; its joints stay as when it stands.

    The supervisor is the real one, once a tick: emergency stops, silence and refused commands are what they are.

    Args:
        robot: the robot.
        start: configuration to start in, shape (7 + nj,).
        scene: what surrounds it.
        perception: what it sees.
    """

    external_force_max = 0.0
    touches: Sequence[Touch] = ()
    timing = cycle_tables = hold = calls = None
    takes_orders = shows_parameters = False

    def __init__(self, robot: RobotModel, start: Array, scene: Scene, perception: Perception) -> None:
        self.robot = robot
        self.clock = CycleClock()
        self.supervisor = Supervisor(robot.config.fall, arms_of(robot))
        joints = len(robot.joint_names)
        self._measured = Estimate(0.0, start, np.zeros(BASE_DOFS + joints), np.zeros(joints), np.zeros(2))
        self._body = _Body(robot, self._measured)
        self._model: mujoco.MjModel | None = None
        self.reset(perception, scene)

    def reset(self, perception: Perception, scene: Scene) -> None:
        """Begin a new run: the robot stands at the start, time is zero, nothing was seen."""
        self.clock.cycle = 0
        self.perception, self.scene, self._model = perception, scene, None
        self.notices: Kept[Event] = Kept()
        self.inputs: Kept[Input] = Kept()
        self.supervisor.reset_run(float(self._measured.qpos[2]))
        self._percepts: dict[str, Percept] = {}
        self._command: Command | None = None
        self._resets: deque[str] = deque()
        x, y, heading = scene.start_pose
        self._body.stand_at(np.array([x, y]), heading)

    @property
    def model(self) -> mujoco.MjModel:
        """MuJoCo's model of the robot in its scene, for those who draw it."""
        if self._model is None:
            self._model = scene_model(self.robot, self.scene)
        return self._model

    @property
    def truth(self) -> None:
        """None: the robot is where it believes to be."""

    @property
    def publishes(self) -> Collection[str]:
        """The percepts that its sources publish."""
        return self.perception.names

    @property
    def unseen(self) -> Mapping[str, str]:
        """The percepts that were never published so far, and why."""
        return self.perception.unseen

    def start(self, info: RunInfo, log: Path | None = None) -> None:
        """Begin; only perception has something to start."""
        self.perception.start()

    def log_cycles(self) -> None:
        """Keep no servo cycles: there are none."""

    def take_cycles(self) -> None:
        """Return None: there are no servo cycles."""

    def close(self) -> None:
        """End perception."""
        self.perception.close()

    def abandon(self) -> str:
        """Return "": nothing goes on."""
        return ""

    def show_parameters(self, _shown: Sequence[Mapping[str, Any]]) -> None:
        """Nothing: nobody looks."""

    def take_settings(self) -> tuple[()]:
        """Return none."""
        return ()

    def take_orders(self) -> tuple[()]:
        """Return none: goals come through a gateway, in realtime mode."""
        return ()

    def announce(self, kind: str, values: Mapping[str, object]) -> None:
        """Tell nobody: only a gateway listens, in realtime mode."""

    def publish(self, status: Mapping[str, object], tree: Tree) -> None:
        """Tell nobody."""

    def push(self, body: str, force: Array, duration: float) -> None:
        """Refuse: there is no body to push; raises UserError."""
        raise UserError("a dry run simulates no body that could be pushed")

    def request_reset(self, source: str) -> None:
        """Reset a latched stop before the next tick."""
        self._resets.append(source)

    def sense(self) -> tuple[State, dict[str, Percept]]:
        """Return the state and the latest percepts, for one tick of decision."""
        now = self.clock.now()
        while self._resets:
            source = self._resets.popleft()
            self.inputs.append(Input(now, "reset", source))
            self.notices.append(Event(now, "warning", reset_text(source, self.supervisor.reset())))
        state = self._body.state(now, self.clock.cycle, self.supervisor)
        if self.clock.due(cycles(self.perception.period)):
            for percept in self.perception.observe(truth_of(state), state):
                self._percepts[percept.name] = percept
            for level, text in self.perception.take_news():
                self.notices.append(Event(now, level, text))
        return state, dict(self._percepts)

    def submit(self, command: Command) -> None:
        """Give the command of a tick to the supervisor, which hears of it when time goes on."""
        self._command = command

    def advance(self) -> None:
        """Let one period of decision pass, and be where the command says."""
        supervisor = self.supervisor
        if self._command is not None:
            supervisor.submit(self._command)
            self._command = None
        self.clock.cycle += _DECISION
        supervisor.check(self.clock.cycle - 1, self._measured)
        if not supervisor.hold:
            self._body.obey(supervisor)


class _Body:
    """Where everything of a standing robot is.

    Args:
        robot: the robot.
        measured: how it stands with the middle between its feet at the origin, heading along x.
    """

    def __init__(self, robot: RobotModel, measured: Estimate) -> None:
        self._names = robot.joint_names
        self._dynamics = dynamics = RobotDynamics(robot)
        dynamics.update(measured)
        self._home, self._frames = measured, {side: dynamics.palm_frame(side) for side in dynamics.hands}
        self._hands: tuple[Side, ...] = tuple(dynamics.hands)
        self._feet = dynamics.feet
        hands = (dynamics.hands[side] for side in self._hands)
        points = [dynamics.com, dynamics.gaze_position, dynamics.base_position, *hands]
        self._points = np.array(points)
        self._forward = dynamics.gaze_direction
        self._pose = measured.qpos[:BASE_COORDINATES].copy()
        self._home_joints = _kept(measured.qpos[BASE_COORDINATES:].copy())
        self._certain = _kept(np.zeros((9, 9)))
        self._zeros, self._nothing = _kept(np.zeros(len(self._home_joints))), _kept(np.zeros(3))
        self._weight = robot.mass * _GRAVITY / len(SIDES)
        self.stand_at(np.zeros(2), 0.0)

    def stand_at(self, position: Array, heading: float) -> None:
        """Stand with the middle between the feet at a position, shape (2,), and nothing commanded."""
        x, y = position.tolist()
        cos, sin = math.cos(heading), math.sin(heading)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        ground = np.array([x, y, 0.0])
        self._stance = _kept(np.array([x, y, heading]))
        self._placed = self._points @ turn.T + ground
        self._ahead = _kept(turn @ self._forward)
        self._turn = turn
        self._base = _kept(pose_product(planar_pose(x, y, 0.0, heading), self._pose))
        self._stood: dict[Side, FootPose] = {}
        for side, foot in self._feet.items():
            x, y, _ = (turn @ (foot.x, foot.y, foot.z) + ground).tolist()
            self._stood[side] = FootPose(x, y, foot.yaw + heading, foot.z)
        self._rest()

    def _rest(self) -> None:
        """Command nothing but where it stands."""
        self._up = np.zeros(3)
        self._looks = self._ahead
        self._joints = self._home_joints
        self._held: dict[Side, Array] = {}  # palms
        self._frames_now = {side: self._turn @ frame for side, frame in self._frames.items()}
        self._errors: dict[Side, float] = {}
        self._turn_errors: dict[Side, float] = {}

    def obey(self, supervisor: Supervisor) -> None:
        """Be where the targets in force say."""
        targets = supervisor.targets
        base = targets.get("base")
        if isinstance(base, BaseTarget) and (*base.position.tolist(), base.heading) != tuple(self._stance.tolist()):
            self.stand_at(base.position, base.heading)
        self._rest()
        posture = targets.get("posture")
        if isinstance(posture, PostureTarget):
            self._up = np.array([0.0, 0.0, posture.height])
        hands = {side: target for side in SIDES if (target := targets.get(f"{side}_hand"))}
        for side, hand in hands.items():
            if isinstance(hand, ArmTarget):
                self._bend(side, hand)
        for side in sorted(hands, key=lambda side: isinstance(of := hands[side], HandTarget) and of.relative):
            if isinstance(hand := hands[side], HandTarget):
                self._bring(side, hand)
        gaze = targets.get("gaze")
        if isinstance(gaze, GazeTarget):
            offset = gaze.point - (self._placed[1] + self._up)
            distance = math.sqrt(offset @ offset)
            self._looks = _kept(offset / distance) if distance > 0 else self._ahead

    def _bend(self, side: Side, target: ArmTarget) -> None:
        """Have an arm's joints where they are told to be, and the palm where that brings it."""
        joints = self._joints.copy()
        for name, angle in target.joints.items():
            joints[self._names.index(name)] = angle
        self._joints = _kept(joints)
        qpos = np.concatenate([self._base, joints])
        qpos[2] += self._up[2]
        self._dynamics.update(replace(self._home, qpos=qpos))
        self._held[side] = _kept(self._dynamics.palm(side))
        self._frames_now[side] = self._dynamics.palm_frame(side)

    def _bring(self, side: Side, target: HandTarget) -> None:
        """Have a palm where it is told to be, turned as it is told."""
        goal = target
        if goal.relative:
            leader = other_side(side)
            goal = in_world(goal, self._held[leader], self._frames_now[leader])
        self._held[side] = _kept(goal.position)
        self._errors[side] = 0.0
        match goal.orientation:
            case None:
                return
            case Pointing(direction=direction, axis=axis):
                frame = self._frames_now[side]
                turn = turn_of_axis(axis_of(frame, axis), direction)
                self._frames_now[side] = rotation_matrix(turned(_UNTURNED, turn)) @ frame
            case orientation:
                self._frames_now[side] = rotation_matrix(orientation)
        self._turn_errors[side] = 0.0

    def state(self, time: float, cycle: int, supervisor: Supervisor) -> State:
        """Return the robot's state."""
        com, gaze, base, *hands = _kept(self._placed + self._up)
        placed = dict(zip(self._hands, hands, strict=True)) | self._held
        command = supervisor.command
        return State(
            time=time,
            cycle=cycle,
            joint_positions=self._joints,
            joint_velocities=self._zeros,
            joint_torques=self._zeros,
            setpoint_positions=self._joints,
            setpoint_velocities=self._zeros,
            base_position=base,
            base_quaternion=self._base[3:],
            base_linear_velocity=self._nothing,
            base_angular_velocity=self._nothing,
            base_covariance=self._certain,
            com=com,
            com_velocity=self._nothing,
            hands=placed,
            hand_orientations={side: _kept(quaternion(self._frames_now[side])) for side in self._hands},
            feet=self._stood,
            stance=self._stance,
            gaze_position=gaze,
            gaze_direction=self._looks,
            foot_force=dict.fromkeys(SIDES, self._weight),
            gait=Gait.STAND,
            footsteps=(),
            base_settled=True,
            mode=supervisor.mode,
            stop_reason=supervisor.reason,
            stop_source=supervisor.source,
            command_sequence=command.sequence if command else -1,
            command_sources=command.sources if command else {},
            targets=supervisor.targets,
            hand_errors=dict(self._errors),
            hand_turn_errors=dict(self._turn_errors),
            hand_obstacles={},
            limit_flags=(),
            contacts={},
        )


def _kept(values: Array) -> Array:
    """Return an array after nobody can write into it any more, as those of any state."""
    values.setflags(write=False)
    return values
