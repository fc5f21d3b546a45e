"""One tree node's way to the robot: what it may read of it, and the targets that it may set."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from humanoid_bt.core.clock import Clock
from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import (
    HEIGHT_OFFSET,
    MOST_PRESS,
    ArmTarget,
    Array,
    BaseTarget,
    GazeTarget,
    HandTarget,
    Level,
    Mode,
    PalmAxis,
    Pose,
    PostureTarget,
    Side,
    State,
    Target,
    touch_text,
)
from humanoid_bt.core.texts import shortened
from humanoid_bt.core.units import nonzero
from humanoid_bt.decision.arguments import angles, how_turned, number, place, places, real, side_of, speed_of
from humanoid_bt.decision.robot import LEVELS, Robot
from humanoid_bt.perception.track import Track

if TYPE_CHECKING:  # a skill's file is imported without it
    from humanoid_bt.decision.anatomy import ArmJoint
    from humanoid_bt.robot.config import RobotConfig

_RUN = Mode.RUN  # reading a member from its class costs more than comparing it
_AT_LIMIT = 0.03  # rad


class RobotHandle:
    """One tree node's way to the robot: it may read everything and command what it declared.

    A target holds for one tick; a skill sets it again in every ``update``. What it does not set is released.

    Args:
        robot: what it reads and commands.
        path: the node's path, the source of its targets.
        resources: what it may command.
    """

    def __init__(self, robot: Robot, path: str, resources: tuple[str, ...]) -> None:
        self._robot = robot
        self.path = path
        self.resources = resources
        self.targets: dict[str, Target] = {}
        self.route: Array | None = None

    @property
    def state(self) -> State:
        """The state at the start of this tick."""
        return self._robot.state

    @property
    def config(self) -> RobotConfig:
        """The robot's numbers."""
        return self._robot.config

    @property
    def clock(self) -> Clock:
        """The tree's clock: the engine's, which stands still while the run is paused."""
        return self._robot.clock

    def track(self, name: str) -> Track | None:
        """Return the latest percept of this name, or None if it was never seen."""
        return self._robot.track(name)

    @property
    def obstacles(self) -> Sequence[Track]:
        """Everything seen so far that is solid: the tracks that have a size and are not gone."""
        return self._robot.obstacles

    def why_unseen(self, name: str) -> str:
        """Say why there is no track of this name, or that it is gone: ``'cup' was never seen: hidden``."""
        return self._robot.why_unseen(name)

    def nearest_hand(self, bearing: float) -> Side:
        """Return the hand on the side of what is at a bearing [rad], or the only one that the robot has."""
        hands, on_left = self.state.hands, real(bearing, "a bearing", "rad") > 0
        side: Side = "left" if on_left else "right"
        other: Side = "right" if on_left else "left"
        return other if side not in hands and other in hands else side

    def why_no_nearer(self, side: Side, distance: float) -> str:
        """Say that a palm comes no nearer to its target than this [m], and which own link is in its way.

        ``left hand comes no nearer than 12 cm: the right forearm is in the way``
        """
        if touched := self.touched(side):
            return touched
        obstacle = self.state.hand_obstacles.get(side)
        why = f": the {obstacle.replace('_', ' ')} is in the way" if obstacle else ""
        return f"{side} hand comes no nearer than {nonzero(real(distance, 'a distance', 'm') * 100)} cm{why}"

    def why_not_turned(self, side: Side, angle: float) -> str:
        """Say that a palm is turned no nearer to its target than this [rad], and what keeps it.

        ``left hand turns no nearer than 12 deg: left_wrist_pitch is at its limit``
        """
        if touched := self.touched(side):
            return touched
        limited = [
            name
            for name, joint in self.arm_joints(side).items()
            if min(joint.angle - joint.lower, joint.upper - joint.angle) < _AT_LIMIT
        ]
        obstacle = self.state.hand_obstacles.get(side)
        why = f": the {obstacle.replace('_', ' ')} is in the way" if obstacle else ""
        if limited:
            why = f": {' and '.join(limited)} {'is at its limit' if len(limited) == 1 else 'are at their limits'}"
        return f"{side} hand turns no nearer than {nonzero(math.degrees(real(angle, 'an angle', 'rad')))} deg{why}"

    def why_no_step(self) -> str:
        """Say that the base stands though it is sent on, as for a way of few centimetres, "" if it does not.

        ``, for which it makes no step``, to go after what is left of the way.
        """
        stands = self.state.base_settled and self.state.mode is _RUN
        return ", for which it makes no step" if stands else ""

    def walk_to(self, position: Any, heading: float) -> None:
        """Ask the robot to walk straight to a place and stand there; :class:`Route` goes round obstacles.

        Args:
            position: shape (2,), middle between the feet, world frame [m]; at most 2000.
            heading: world frame [rad]; a full turn more or less is the same.

        Raises:
            ValueError: it has another shape, a number is not finite, or the place is out of the world.
        """
        facing = math.remainder(number(heading, "heading", math.inf, "rad"), math.tau)
        self._set("base", BaseTarget(place(position, 2), facing))

    def show_route(self, points: Any) -> None:
        """Show people, in the recording, the way that the base is to take: shape (n, 2), world frame [m].

        Raises:
            ValueError: it has another shape, a number is not finite, or a point is out of the world.
        """
        found = places(points, "the points of a way")
        self.route = found if len(found) else None

    def touched(self, side: Side) -> str:
        """Say that an arm yields because something touched it, "" if none did: ``right arm touched something: 43 N``.

        Its hand goes nowhere until the node that wanted it there has let go of it, and nothing touches it any more.
        """
        contact = self.state.contacts.get(f"{side_of(side)}_arm")
        return touch_text(f"{side}_arm", contact) if contact and contact.yields else ""

    def move_hand(
        self,
        side: Side,
        position: Any,
        orientation: Any = None,
        *,
        direction: Any = None,
        axis: PalmAxis = "fingers",
        relative: bool = False,
        speed: float | None = None,
        press: float = 0.0,
    ) -> None:
        """Ask for a palm at a position: shape (3,), world frame [m]; and turned, if that is said.

        Args:
            side: of the hand.
            position: shape (3,) [m], at most 2000.
            orientation: of the palm's frame, whose x is along the fingers and whose z is where the palm faces:
                quaternion wxyz, shape (4,), or rotation matrix, shape (3, 3).
            direction: where one axis of the palm is to point, shape (3,), of any length; in place of an orientation.
            axis: which one: "fingers", or "facing".
            relative: all of this is as seen from the other palm, in its frame, and not in the world. The same node
                moves the other hand to a place in the world.
            speed: at most this fast [m/s], and turning as much slower; never faster than the robot's own limit.
            press: it may touch something on the way there, and then presses with this force [N], at most 50.

        Raises:
            ValueError: a number is not finite or out of range, or something is not what it is to be.
        """
        side = side_of(side)
        turn, force = how_turned(orientation, direction, axis), number(press, "press", MOST_PRESS, "N", least=0.0)
        if force and relative:
            raise ValueError("a hand that is held relative to the other one cannot press")
        self._set(f"{side}_hand", HandTarget(place(position, 3), turn, bool(relative), speed_of(speed), force))

    def move_arm(self, side: Side, joints: Mapping[str, float], *, speed: float | None = None) -> None:
        """Ask for joints of an arm, by their names, at angles [rad]; those that are not named go home.

        An arm has one owner: its resource is that of its hand.

        Args:
            side: of the arm.
            joints: name -> angle, within its limits (see ``arm_joints``).
            speed: at most this fast [rad/s]; never faster than the robot's own limit.

        Raises:
            HumanoidBtError: a name is none of this arm's joints, or an angle is outside its limits.
            ValueError: these are no angles by name, or the speed is not above 0.
        """
        side, asked = side_of(side), angles(joints)
        if fault := self._robot.anatomy.joints_fault(side, asked):
            raise HumanoidBtError(f"a target of the {side} arm {fault}")
        self._set(f"{side}_hand", ArmTarget(asked, speed_of(speed)))

    def arm_joints(self, side: Side) -> dict[str, ArmJoint]:
        """Return the joints of an arm by name, from the shoulder to the hand: ``angle``, ``lower``, ``upper`` [rad]."""
        return self._robot.anatomy.arm_joints(side_of(side), self.state)

    def arm_length(self, side: Side) -> float:
        """Return how far a palm is from the shoulder when the arm is stretched [m]."""
        return self._robot.anatomy.arm_length(side_of(side))

    def pose(self, name: str) -> Pose:
        """Return where a body or a site of the model is, in the world: ``position`` and ``quaternion``.

        Every robot has ``left_palm``, ``left_shoulder``, ``left_sole``, those of the right side, and ``gaze``.

        Raises:
            HumanoidBtError: the robot has neither of this name.
        """
        return self._robot.anatomy.pose(name, self.state)

    def look_at(self, point: Any) -> None:
        """Ask the head, and the torso where the neck ends, to look at a point: shape (3,), world frame [m].

        Raises:
            ValueError: a number is not finite, or beyond 2000 m.
        """
        self._set("gaze", GazeTarget(place(point, 3)))

    def set_height(self, offset: float) -> None:
        """Ask for the centre of mass this much above (or below) its home height [m], at most 0.5.

        Raises:
            ValueError: it is not finite, or out of range.
        """
        self._set("posture", PostureTarget(number(offset, "height", HEIGHT_OFFSET, "m")))

    def raise_estop(self, reason: str) -> None:
        """Raise the emergency stop at once; only a reset from outside ends it."""
        self._robot.raise_estop(self.path, shortened(reason))  # whatever it is

    def log(self, text: str, level: Level = "info") -> None:
        """Tell something to people, as an event of the run; it is recorded."""
        if level not in LEVELS:
            raise ValueError(f"what is told is an 'info', a 'warning' or an 'error', not {level!r}")
        self._robot.log(self.path, level, text)

    def release(self) -> None:
        """Take back everything asked for in this tick; called when the node ends or is halted."""
        self.targets.clear()
        self.route = None

    def _set(self, resource: str, target: Target) -> None:
        self._robot.grant(self, resource)
        self.targets[resource] = target
