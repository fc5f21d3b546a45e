"""The simulated plant: a robot in a scene, in MuJoCo, one servo period a step."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable

import mujoco
import numpy as np

from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.clock import SERVO_PERIOD, cycles
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.errors import ControlLost, Place, UserError, nearest, relative
from humanoid_bt.core.messages import SIDES, Array, JointCommand, Reading, Truth
from humanoid_bt.plant.scene import Scene, random_stream
from humanoid_bt.plant.scene_model import physics_model
from humanoid_bt.plant.sensors import Sensors
from humanoid_bt.plant.touches import Touches
from humanoid_bt.robot.model import BASE_COORDINATES, GAZE_SITE, RobotModel, foot_sensor
from humanoid_bt.robot.mujoco_functions import kinematics


class MujocoPlant:
    """A robot standing in a scene.

    Args:
        robot: the robot.
        scene: what surrounds it.

    Raises:
        UserError: robot and scene do not go together.

    Attributes:
        model, data: MuJoCo's, without what is only drawn; the robot's coordinates come first.
        time: engine time [s].
        external_force_max: largest external force or torque there ever was on any body [N, Nm].
        touches: what of the scene the robot has touched since :meth:`place`, besides the floor.
        fault: "", always: it is here.
    """

    fault = ""

    def __init__(self, robot: RobotModel, scene: Scene) -> None:
        self.robot = robot
        self.scene = scene
        self.model = physics_model(robot, scene)
        self.data = mujoco.MjData(self.model)
        joints = len(robot.joint_names)
        self._nq = BASE_COORDINATES + joints
        self._objects = {name: self.model.body(f"object_{name}").id for name in scene.config.objects}
        self.touches = Touches(self.model, robot.config)
        feet = [int(self.model.sensor(foot_sensor(side)).adr[0]) + 2 for side in SIDES]  # upward
        self._sensors = Sensors(robot.config.sensors, self.model, self.data, joints, feet)
        self._see = _truth.bind(
            self.model._address, self.data._address, self.data.qpos, self.data.site_xpos, self.data.site_xmat,
            self.model.site(GAZE_SITE).id,
        )  # fmt: skip
        self._forces = self.data.xfrc_applied, self.data.qfrc_applied
        self._stiffness, self._damping = robot.stiffness, robot.damping
        self._drives, self._payloads = 1.0, (0.0, 0.0)
        self._strength = np.ones(joints)  # what each drive gives of the torque that it is asked for
        self._friction, self._mass = self.model.geom_friction.copy(), self.model.body_mass.copy()
        self._command: JointCommand | None = None  # which the drives have
        self._late = 0  # servo cycles until they hear of one
        self._coming: deque[JointCommand] = deque()
        self._pushes: dict[int, tuple[float, Array]] = {}
        self.external_force_max = 0.0
        self.cycle = 0
        self.time = 0.0

    def place(self, qpos: Array) -> None:
        """Put the robot at the scene's start pose, at rest, before a run begins.

        Args:
            qpos: standing posture with the middle between the feet at the origin, heading along x, shape (7 + nj,).

        Raises:
            UserError: physics cannot begin there.
        """
        x, y, heading = self.scene.start_pose
        self._stiffness, self._damping = self.robot.stiffness, self.robot.damping
        self.set_strength(np.ones(len(self.robot.joint_names)))
        mujoco.mj_resetData(self.model, self.data)
        start = qpos.copy()
        cos, sin = math.cos(heading), math.sin(heading)
        start[0], start[1] = x + cos * qpos[0] - sin * qpos[1], y + sin * qpos[0] + cos * qpos[1]
        turn = np.array([math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)])
        mujoco.mju_mulQuat(start[3:7], turn, qpos[3:7])
        self.data.qpos[: self._nq] = start
        self.data.ctrl[:] = self._stiffness * start[BASE_COORDINATES:]  # the drives hold what they find
        self._command = None
        self._coming.clear()
        self._pushes.clear()
        self.touches.clear()
        self.external_force_max = 0.0
        self.cycle = 0
        self.time = 0.0
        self._put(self._objects)
        try:
            mujoco.mj_forward(self.model, self.data)
        except mujoco.FatalError as error:
            raise UserError(_gives_up(error), Place(relative(self.scene.config.path)), code="model") from error
        self._sensors.reset(random_stream(self.scene.seed, "sensors"))

    def truth(self) -> Truth:
        """Return where the robot really is."""
        numbers, eyes = np.empty(self._nq), np.empty((2, 3))
        self._see(numbers, eyes)
        return Truth(self.time, numbers[:3], numbers[3:BASE_COORDINATES], eyes[0], eyes[1], numbers[BASE_COORDINATES:])

    def measure(self, into: Reading | None = None) -> Reading:
        """Return what the robot's sensors say now, as :class:`~humanoid_bt.plant.interface.Plant` wants it."""
        reading = Reading(len(self._strength)) if into is None else into
        self._sensors.read(reading)
        reading.time = self.time
        return reading

    def step(self, command: JointCommand) -> None:
        """Drive the joints for one servo period.

        Raises:
            ControlLost: physics cannot go on.
        """
        if self._late:
            self._coming.extend([command] * (1 if self._coming else self._late + 1))
            command = self._coming.popleft()
        if command is not self._command:
            self._take(command)
        if self._pushes:
            self._apply_pushes()
        try:
            mujoco.mj_step(self.model, self.data)
        except mujoco.FatalError as error:
            raise ControlLost(_gives_up(error)) from error
        self.cycle += 1
        self.time = self.cycle * SERVO_PERIOD
        if self.touches.possible:
            self.touches.note(self.data, self.time)
        self._sensors.sense()

    def _take(self, command: JointCommand) -> None:
        self._command = command
        if command.stiffness is not self._stiffness or command.damping is not self._damping:
            self._stiffness, self._damping = command.stiffness, command.damping
            self.model.actuator_biasprm[:, 1] = -self._strength * command.stiffness
            self.model.actuator_biasprm[:, 2] = -self._strength * command.damping
        position = command.position - self._sensors.encoder_bias  # the drive believes its encoder
        self.data.ctrl[:] = command.stiffness * position + command.damping * command.velocity + command.torque

    def move_objects(self) -> None:
        """Put the scene's objects where its script says they are now."""
        self._put(self.scene.moved)

    def _put(self, names: Iterable[str]) -> None:
        for name in names:
            self.model.body_pos[self._objects[name]] = self.scene.object_position(name, self.time)

    def alter(
        self,
        *,
        friction: float = 1.0,
        payload: float = 0.0,
        hand_payload: float = 0.0,
        drives: float = 1.0,
        drive_delay: float = 0.0,
        encoders: Array | None = None,
    ) -> None:
        """Let the world differ from what the robot's numbers say, from the next :meth:`place` on.

        Args:
            friction: factor of the friction of everything.
            payload: what the torso carries besides its own mass, at its centre of mass [kg].
            hand_payload: what each hand carries in the same way [kg].
            drives: what every drive gives of the torque that it is asked for, and of the largest.
            drive_delay: from when control commands something until the drives hear of it [s].
                The drives' own loops are as quick as before.
            encoders: what each encoder shows too much, to control and to its drive alike, shape (nj,) [rad]; nothing
                if None.
        """
        self.model.geom_friction[:] = self._friction * friction
        if (payload, hand_payload) != self._payloads:
            self._payloads = payload, hand_payload
            config = self.robot.config
            self.model.body_mass[:] = self._mass
            self.model.body(config.torso).mass += payload
            for hand in config.hands.values():
                self.model.body(hand.body).mass += hand_payload
            mujoco.mj_setConst(self.model, self.data)
        self._drives = drives
        self._late = cycles(drive_delay)
        self._sensors.encoder_error[:] = 0.0 if encoders is None else encoders

    def set_strength(self, strength: Array) -> None:
        """Let drives give a part of the torque that they are asked for, and of the largest, until :meth:`place`.

        Args:
            strength: that part of each, shape (nj,); 1 for a drive that is as it should be.
        """
        self._strength = self._drives * strength
        limits = self._strength * self.robot.torque_limit
        self.model.actuator_forcerange[:, 0], self.model.actuator_forcerange[:, 1] = -limits, limits
        self.model.actuator_gainprm[:, 0] = self._strength
        self.model.actuator_biasprm[:, 1] = -self._strength * self._stiffness
        self.model.actuator_biasprm[:, 2] = -self._strength * self._damping

    def fail_sensor(self, sensor: str, how: str) -> None:
        """Let a sensor fail until :meth:`place`; see :meth:`Sensors.fail <humanoid_bt.plant.sensors.Sensors.fail>`."""
        self._sensors.fail(sensor, how, self.robot.joint_names)

    def push(self, body: str, force: Array, duration: float) -> None:
        """Push a body with an external force: a disturbance for tests, counted in ``external_force_max``.

        Args:
            body: name of the body.
            force: world frame, shape (3,) [N].
            duration: [s].

        Raises:
            UserError: there is no such body.
        """
        bodies = [self.model.body(i).name for i in range(1, self.model.nbody)]
        if body not in bodies:
            raise UserError(f"there is no body {body!r} to push", hint=nearest(body, bodies), code="unknown-body")
        self._pushes[self.model.body(body).id] = (self.time + duration, np.array(force, dtype=float).reshape(3))

    def _apply_pushes(self) -> None:
        for body, (until, force) in list(self._pushes.items()):
            if self.time >= until:
                self.data.xfrc_applied[body] = 0.0
                del self._pushes[body]
            else:
                self.data.xfrc_applied[body, :3] = force
        self.note_external_force()

    def note_external_force(self) -> None:
        """Look at every external force that MuJoCo applies now and remember the largest."""
        self.external_force_max = max(self.external_force_max, _largest(*self._forces))


def _gives_up(error: Exception) -> str:
    """Return that physics gave up, which it does when too much touches at once."""
    why = " ".join(str(error).split())
    return f"the simulated physics gave up, most likely because too many solid things touch at once: {why}"


@bindable("void(f8[::1], f8[:, ::1])", "i8, i8, f8[::1], f8[:, ::1], f8[:, ::1], i8")
def _truth(
    numbers: Array, eyes: Array, model: int, data: int, qpos: Array, places: Array, turns: Array, gaze: int
) -> None:
    """See :meth:`MujocoPlant.truth`.

    Args:
        numbers: the robot's coordinates are written into it, shape (7 + nj,).
        eyes: where the gaze site is and its direction of view are written into it.
        model, data: addresses of MuJoCo's.
        qpos: all coordinates.
        places, turns: positions and rotation matrices of all sites, shapes (n, 3) and (n, 9).
        gaze: which of these is meant.
    """
    kinematics(model, data)  # MuJoCo's own is of the beginning of its step
    for i in range(len(numbers)):
        numbers[i] = qpos[i]
    for i in range(3):
        eyes[0, i], eyes[1, i] = places[gaze, i], turns[gaze, 3 * i]


@compiled("f8(f8[:, ::1], f8[::1])")
def _largest(on_bodies: Array, on_joints: Array) -> float:
    """Return the largest of some numbers, shapes (n, 6) and (m,), whatever its sign."""
    largest = 0.0
    for i in range(len(on_bodies)):
        for j in range(6):
            largest = max(largest, abs(on_bodies[i, j]))
    for i in range(len(on_joints)):
        largest = max(largest, abs(on_joints[i]))
    return largest
