"""Plain frozen data that every layer shares: state, command, percepts, targets.

Units are SI, angles radians. Frames: *world* is fixed, z up; *base* is the robot's pelvis link.
Quaternions are (w, x, y, z), as in MuJoCo. Arrays are copies that nobody changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import Enum
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Side = Literal["left", "right"]
"""A side of the robot."""

SIDES: tuple[Side, Side] = ("left", "right")
"""Both of them."""

SIGHT = 1000.0
"""Distance from the robot up to which something can be seen [m]."""

WORKSPACE = SIGHT + 1000.0
"""Distance from the world's origin, along each axis, up to which a target can be [m]: what a robot sees is one."""

HEIGHT_OFFSET = 0.5
"""How far above or below its home height the centre of mass can be asked to be [m]."""

MOST_PRESS = 50.0
"""Force with which a hand can be asked to press [N]."""

READING_SIZE = 2 + 4 + 3 + 3
"""Numbers of a reading besides the three of each joint."""

Level = Literal["info", "warning", "error"]
"""How much an event of a run matters."""

TORSO = "torso"
"""The trunk and what it carries besides the arms, where something can touch it."""

TOUCHED = ("left_arm", "right_arm", TORSO)
"""Where the robot can be touched, as far as it feels it."""

RESOURCES = ("base", "left_hand", "right_hand", "gaze", "posture")
"""What a skill can command; each has at most one owner at a time."""


@dataclass(frozen=True, slots=True)
class BaseTarget:
    """Where to stand: middle between the feet, world frame.

    Attributes:
        position: shape (2,) [m].
        heading: [rad].
    """

    position: Array
    heading: float


PalmAxis = Literal["fingers", "facing"]
"""An axis of a palm: where its fingers point (x of its frame), or where it faces (z)."""


@dataclass(frozen=True, slots=True)
class Pointing:
    """Where an axis of a palm is to point; about it the hand may turn as it likes.

    Attributes:
        direction: unit vector, shape (3,), in the frame of the target.
        axis: which one.
    """

    direction: Array
    axis: PalmAxis = "fingers"


@dataclass(frozen=True, slots=True)
class HandTarget:
    """Where to bring a palm, and how to turn it.

    Attributes:
        position: shape (3,) [m].
        orientation: of the palm's frame, wxyz, shape (4,), or where one of its axes is to point; any if None.
        relative: both are as seen from the other palm, in its frame, and not in the world.
        speed: at most this fast [m/s], and turning as much slower than it can; the robot's own limit if None.
        press: force with which the palm presses on what it touches on the way there [N]; 0: it is to touch nothing.
    """

    position: Array
    orientation: Array | Pointing | None = None
    relative: bool = False
    speed: float | None = None
    press: float = 0.0


@dataclass(frozen=True, slots=True)
class ArmTarget:
    """How to hold the joints of an arm; those that are not named go home.

    Attributes:
        joints: name -> angle [rad].
        speed: at most this fast [rad/s]; the robot's own limit if None.
    """

    joints: Mapping[str, float]
    speed: float | None = None


@dataclass(frozen=True, slots=True)
class GazeTarget:
    """What to look at.

    Attributes:
        point: shape (3,), world frame [m].
    """

    point: Array


@dataclass(frozen=True, slots=True)
class PostureTarget:
    """How to hold the body while standing.

    Attributes:
        height: offset of the centre of mass from its height in the home posture [m].
    """

    height: float


Target = BaseTarget | HandTarget | ArmTarget | GazeTarget | PostureTarget


@dataclass(frozen=True, slots=True)
class Pose:
    """Where something is, and how it is turned.

    Attributes:
        position: shape (3,), world frame [m].
        quaternion: wxyz, shape (4,), of its frame in the world.
        rotation: the same as a matrix, shape (3, 3), whose columns are the frame's axes.
    """

    position: Array
    quaternion: Array
    rotation: Array


@dataclass(frozen=True, slots=True)
class Pause:
    """Who wants the robot held while the tree stands still, and why.

    Attributes:
        source: who: "keyboard", "program", "break at PATH".
        reason: why.
    """

    source: str
    reason: str

    def __str__(self) -> str:
        return f"paused by {self.source}: {self.reason}"


@dataclass(frozen=True, slots=True)
class Command:
    """What decision asks of control, once per tick. A resource without a target is released.

    Attributes:
        sequence: counts up by one per command.
        stamp: engine time of the tick [s].
        targets: resource -> target.
        sources: resource -> path of the tree node that asked for it.
        pause: who wants the robot held instead, None if nobody does.
    """

    sequence: int
    stamp: float
    targets: Mapping[str, Target] = field(default_factory=dict)
    sources: Mapping[str, str] = field(default_factory=dict)
    pause: Pause | None = None


@dataclass(frozen=True, slots=True)
class Percept:
    """What perception says of one thing.

    Attributes:
        name: the percept's name, as trees refer to it.
        stamp: engine time at which it was seen [s].
        position: shape (3,), in the robot's base frame at ``stamp`` [m].
        confidence: in [0, 1]; 0 of what is known to be there no longer.
        size: of the upright box around a solid thing, with ``position`` in its middle, shape (3,): length, width,
            height [m]; None if it is not known, or if nothing can bump into the thing.
        heading: of the box's length, in the base frame [rad].
        orientation: of the thing's own frame in the base frame, wxyz, shape (4,); None if it is not known.
        class_name: what kind of thing it is, such as ``cup``; "" if it is not known.
        covariance: of ``position``, base frame, shape (3, 3) [m^2]; None if it is not known.
    """

    name: str
    stamp: float
    position: Array
    confidence: float
    size: Array | None = None
    heading: float = 0.0
    orientation: Array | None = None
    class_name: str = ""
    covariance: Array | None = None


@dataclass(frozen=True, slots=True)
class JointCommand:
    """What the servo gives the drives, every cycle; each of shape (nj,).

    Torque of a joint: stiffness (position - q) + damping (velocity - qd) + torque, limited by the drive.

    Attributes:
        position: [rad].
        velocity: [rad/s].
        stiffness: [Nm/rad].
        damping: [Nm s/rad].
        torque: feedforward [Nm].
    """

    position: Array
    velocity: Array
    stiffness: Array
    damping: Array
    torque: Array


class Reading:
    """What the sensors of a robot say: all that control knows of it.

    Views of one row of numbers, so that a reading is copied at once; in the order of MuJoCo's qpos and qvel.

    Args:
        joints: how many the robot has.
        values: the row, if it exists already, shape (12 + 3 joints,).

    Attributes:
        time: engine time at which it arrived [s].
        age: how long it was under way and has been there since [s], beside the delay of the sensors themselves; 0 where
            there is no cable.
        passed: servo periods in which the sensors said it and nothing else that was heard: 1 where everything they say
            arrives, more after something was lost or late, 0 for what was measured before already.
        values: all of it.
        rates: imu, joint_velocity and joint_torque, shape (6 + 2 nj,).
        imu: the next two, shape (6,).
        accelerometer: specific force at the base, base frame, shape (3,) [m/s^2]; at rest 9.81 upward.
        gyro: angular velocity of the base, base frame, shape (3,) [rad/s].
        orientation: of the base, as the IMU's own filter gives it, wxyz, shape (4,); its heading drifts.
        foot_force: normal force on the (left, right) foot, shape (2,) [N]; 0 where the robot has no such sensor.
        joint_position, joint_velocity: shape (nj,) [rad], [rad/s].
        joint_torque: what the drives say they apply, shape (nj,) [Nm].
    """

    __slots__ = (
        "accelerometer",
        "age",
        "foot_force",
        "gyro",
        "imu",
        "joint_position",
        "joint_torque",
        "joint_velocity",
        "orientation",
        "passed",
        "rates",
        "time",
        "values",
    )

    def __init__(self, joints: int, values: Array | None = None) -> None:
        self.time = self.age = 0.0
        self.passed = 1
        self.values = values = np.zeros(READING_SIZE + 3 * joints) if values is None else values
        self.foot_force, self.orientation, self.joint_position = values[:2], values[2:6], values[6 : 6 + joints]
        self.rates = rates = values[6 + joints :]
        self.imu, self.accelerometer, self.gyro = rates[:6], rates[:3], rates[3:6]
        self.joint_velocity, self.joint_torque = rates[6:].reshape(2, joints)


@dataclass(slots=True)
class Estimate:
    """What control believes of the robot, in MuJoCo's layout for one with a free base.

    The world is where the robot was told to be when the run began, and odometry since then: it drifts. Heights are
    above the ground that the robot stands on. It is not frozen, for that would take four times as long to make, 200
    times a second; its arrays change in any case.

    Attributes:
        time: engine time [s].
        qpos: shape (7 + nj,): base position (world) [m], base quaternion wxyz, joint positions [rad].
        qvel: shape (6 + nj,): base linear velocity (world) [m/s], base angular velocity (base frame) [rad/s],
            joint velocities [rad/s].
        joint_torque: shape (nj,): torque that the drives applied [Nm].
        foot_force: normal force on the (left, right) foot, shape (2,) [N].
    """

    time: float
    qpos: Array
    qvel: Array
    joint_torque: Array
    foot_force: Array


@dataclass(frozen=True, slots=True)
class Truth:
    """Where the robot really is, which control never knows: for what surrounds it, and to see how wrong control is.

    Attributes:
        time: engine time [s].
        base_position: world frame, shape (3,) [m].
        base_quaternion: world frame, wxyz, shape (4,).
        gaze_position: where the gaze site is, world frame, shape (3,) [m].
        gaze_direction: unit vector, world frame, shape (3,).
        joint_positions: of the robot's joints, shape (nj,) [rad]; empty where nobody asks.
    """

    time: float
    base_position: Array
    base_quaternion: Array
    gaze_position: Array
    gaze_direction: Array
    joint_positions: Array = field(default_factory=lambda: np.empty(0))


class Mode(Enum):
    """What the supervisor allows."""

    RUN = "run"
    PAUSED = "paused"
    PROTECTIVE_STOP = "protective_stop"
    EMERGENCY_STOP = "emergency_stop"
    DAMP = "damp"


class Gait(Enum):
    """What the legs do."""

    STAND = "stand"
    STEP = "step"
    SETTLE = "settle"


@dataclass(frozen=True, slots=True)
class FootPose:
    """A foothold or a sole, world frame.

    Attributes:
        x, y, z: sole centre [m].
        yaw: heading [rad].
    """

    x: float
    y: float
    yaw: float
    z: float = 0.0


@dataclass(frozen=True, slots=True)
class Contact:
    """Something that touches the robot elsewhere than at the soles, as its drives' torques tell.

    Attributes:
        force: with which it pushes the robot now, world frame, shape (3,) [N].
        largest: the largest since it began [N].
        yields: whether the arm yields: it follows what pushes it, and its hand has been let go.
    """

    force: Array
    largest: float
    yields: bool = False


@dataclass(frozen=True, slots=True)
class State:
    """What control knows, as decision and the recording see it.

    Attributes:
        time: engine time [s].
        cycle: servo cycle.
        joint_positions, joint_velocities, joint_torques: measured, shape (nj,) [rad], [rad/s], [Nm].
        setpoint_positions, setpoint_velocities: what the servo was told, shape (nj,) [rad], [rad/s].
        base_position: world frame, shape (3,) [m].
        base_quaternion: world frame, wxyz, shape (4,).
        base_linear_velocity: world frame, shape (3,) [m/s].
        base_angular_velocity: base frame, shape (3,) [rad/s].
        base_covariance: of what is believed of the base: (turn, velocity, position), world frame, shape (9, 9)
            [rad, m/s, m].
        com, com_velocity: centre of mass, world frame, shape (3,) [m], [m/s].
        hands: palm positions, world frame, side -> shape (3,) [m].
        hand_orientations: of the palms' frames, x along the fingers, z where the palm faces: world frame, wxyz, side ->
            shape (4,).
        feet: measured sole poses.
        stance: middle between the feet on the ground and its heading, world frame, shape (3,): x, y [m], yaw [rad].
        gaze_position: where the gaze site is, world frame, shape (3,) [m].
        gaze_direction: unit vector, world frame, shape (3,).
        foot_force: normal force on each foot [N].
        gait: what the legs do.
        footsteps: planned footholds ahead, the next first, with their side.
        base_settled: standing, at rest, no step pending.
        mode: what the supervisor allows.
        stop_reason: why the mode is not RUN, else "".
        stop_source: who caused it, else "".
        command_sequence: of the command in force, -1 for none.
        command_sources: resource -> path of the node, of the command in force.
        targets: resource -> target, of the command in force.
        hand_errors: measured distance of each commanded palm to its target [m].
        hand_turn_errors: how far each palm whose orientation or direction is commanded is turned from it [rad].
        hand_obstacles: the own link that keeps a commanded palm from its target, by the name of its body; a hand that
            none keeps is missing.
        limit_flags: joints at a soft, rate or torque limit in this cycle, by name.
        contacts: what touches the robot elsewhere than at the soles: left_arm, right_arm, torso -> contact; where
            nothing does, it is missing.
    """

    time: float
    cycle: int
    joint_positions: Array
    joint_velocities: Array
    joint_torques: Array
    setpoint_positions: Array
    setpoint_velocities: Array
    base_position: Array
    base_quaternion: Array
    base_linear_velocity: Array
    base_angular_velocity: Array
    base_covariance: Array
    com: Array
    com_velocity: Array
    hands: Mapping[Side, Array]
    hand_orientations: Mapping[Side, Array]
    feet: Mapping[Side, FootPose]
    stance: Array
    gaze_position: Array
    gaze_direction: Array
    foot_force: Mapping[Side, float]
    gait: Gait
    footsteps: tuple[tuple[Side, FootPose], ...]
    base_settled: bool
    mode: Mode
    stop_reason: str
    stop_source: str
    command_sequence: int
    command_sources: Mapping[str, str]
    targets: Mapping[str, Target]
    hand_errors: Mapping[Side, float]
    hand_turn_errors: Mapping[Side, float]
    hand_obstacles: Mapping[Side, str]
    limit_flags: tuple[str, ...]
    contacts: Mapping[str, Contact] = field(default_factory=dict)


def touch_text(group: str, contact: Contact) -> str:
    """Return what touched a group of links, for people: ``right arm touched something: 43 N``."""
    return f"{group.replace('_', ' ')} touched something: {contact.largest:.0f} N"


_ARRAYS = tuple(field.name for field in fields(State) if field.type == "Array")
_MAPPINGS = tuple(field.name for field in fields(State) if str(field.type).startswith("Mapping"))


def frozen(state: State) -> State:
    """Return a state after nobody can write into it any more: what one skill sees is what all see."""
    for name in _ARRAYS:
        getattr(state, name).setflags(write=False)
    for name in _MAPPINGS:
        object.__setattr__(state, name, MappingProxyType(getattr(state, name)))
    for hand in (*state.hands.values(), *state.hand_orientations.values()):
        hand.setflags(write=False)
    for contact in state.contacts.values():
        contact.force.setflags(write=False)
    return state
