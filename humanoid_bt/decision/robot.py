"""The robot as decision sees it: a snapshot of state and percepts in, targets out, leases on resources.

Targets set during a tick are buffered and leave as one :class:`~humanoid_bt.core.messages.Command` at its end.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from humanoid_bt.core.clock import DECISION_PERIOD, Clock, TreeClock
from humanoid_bt.core.errors import HumanoidBtError, ResourceConflict, nearest
from humanoid_bt.core.geometry import heading_of, rotation_matrix
from humanoid_bt.core.messages import (
    HEIGHT_OFFSET,
    MOST_PRESS,
    RESOURCES,
    WORKSPACE,
    ArmTarget,
    Array,
    BaseTarget,
    Command,
    GazeTarget,
    HandTarget,
    Level,
    Mode,
    PalmAxis,
    Percept,
    Pose,
    PostureTarget,
    Side,
    State,
    Target,
    touch_text,
)
from humanoid_bt.decision.arguments import check_relative, how_turned, number, place, side_of, speed_of
from humanoid_bt.perception.interface import OLDEST
from humanoid_bt.perception.track import Track

if TYPE_CHECKING:  # a skill's file is imported without it
    from humanoid_bt.decision.anatomy import Anatomy, ArmJoint
    from humanoid_bt.decision.calls import Calls
    from humanoid_bt.robot.config import RobotConfig
    from humanoid_bt.robot.model import RobotModel

_log = logging.getLogger(__name__)
_LEVELS: dict[Level, int] = {"info": logging.INFO, "warning": logging.WARNING, "error": logging.ERROR}

_AT_LIMIT = 0.03  # rad
_POSES = round(OLDEST / DECISION_PERIOD)  # of the base that are kept, for percepts that come late


class Robot:
    """Everything decision knows and asks of one robot.

    Args:
        config: the robot's numbers.
        clock: the engine's clock.
        raise_estop: called at once with source and reason when a node raises the emergency stop.
        log: called at once with source, level and text when a node has something to tell; the program's log if None.
        unseen: answers with the percepts that were never published so far, and why.
        model: the robot; made when it is first asked for where parts of the body are if None, which takes a while.
        calls: what carries calls to other programs, None where nothing does.

    Attributes:
        calls: what carries calls to other programs, None where nothing does.
        clock: the tree's clock, which stands still while the run is paused.
    """

    def __init__(
        self,
        config: RobotConfig,
        clock: Clock,
        raise_estop: Callable[[str, str], None] | None = None,
        log: Callable[[str, Level, str], None] | None = None,
        unseen: Callable[[], Mapping[str, str]] | None = None,
        *,
        model: RobotModel | None = None,
        calls: Calls | None = None,
    ) -> None:
        self._raise_estop = raise_estop
        self._model = model
        self._unseen = unseen
        self._tell = log or _to_log
        self.calls = calls
        self.config = config
        self._engine_clock = clock
        self.clock = TreeClock(clock)
        self._state: State | None = None
        self._percepts: dict[str, tuple[Percept, Array, float, Array]] = {}
        self._tracks: dict[str, Track] = {}  # those that were asked for in this tick
        self._now = 0.0  # the tick's start
        self._past: deque[tuple[float, Array, Array]] = deque(maxlen=_POSES)  # time, position, quaternion of the base
        self._commanding: dict[RobotHandle, None] = {}  # handles that set a target in this tick, in that order
        self._sequence = 0

    @property
    def now(self) -> float:
        """The engine's time [s]."""
        return self._engine_clock.now()

    @property
    def state(self) -> State:
        """The state at the start of this tick."""
        if self._state is None:
            raise HumanoidBtError("the robot has no state before the first tick")
        return self._state

    @cached_property
    def anatomy(self) -> Anatomy:
        """The robot's body."""
        from humanoid_bt.decision.anatomy import Anatomy  # noqa: PLC0415 (a skill's file needs no simulator)

        return Anatomy(self._model or self.config)

    def handle(self, node_path: str, resources: tuple[str, ...]) -> RobotHandle:
        """Return the handle through which one tree node commands the robot.

        Args:
            node_path: the node's path, the source of its targets.
            resources: what it may command.
        """
        return RobotHandle(self, node_path, resources)

    def track(self, name: str) -> Track | None:
        """Return the latest percept of this name as it was at the start of the tick, or None if never seen."""
        return self._track(name)

    def _track(self, name: str) -> Track | None:
        track = self._tracks.get(name)
        if track is None and (known := self._percepts.get(name)):
            percept, position_world, heading, turn = known
            age = self._now - percept.stamp
            track = self._tracks[name] = Track(percept, position_world, age, self.state, heading, turn=turn)
        return track

    def why_unseen(self, name: str) -> str:
        """Return that a percept is gone, or was never seen and why, for people: ``'cup' was never seen: hidden``."""
        if (track := self._track(name)) is not None and track.gone:
            return f"{name!r} is gone from where it was seen"
        if self._unseen is None:
            return f"{name!r} was never seen"
        unseen = self._unseen()
        why = unseen.get(name, "perception offers no such percept")
        hint = nearest(name, {*unseen, *self._percepts}) if name not in unseen else ""
        return f"{name!r} was never seen: {why}" + (f" ({hint})" if hint else "")

    @property
    def obstacles(self) -> Sequence[Track]:
        """Everything seen so far that is solid, as it was at the start of the tick, but what is known to be gone."""
        solid = (self._track(name) for name, (percept, *_) in self._percepts.items() if percept.size is not None)
        return [track for track in solid if track is not None and not track.gone]

    @property
    def routes(self) -> Sequence[Array]:
        """The ways that nodes follow in this tick, each of shape (n, 2), world frame [m]."""
        return [handle.route for handle in self._commanding if handle.route is not None]

    @property
    def tracks(self) -> Mapping[str, Track]:
        """Every percept seen so far, by name, as it was at the start of the tick."""
        return {name: track for name in self._percepts if (track := self.track(name))}

    def raise_estop(self, source: str, reason: str) -> None:
        """Raise the emergency stop, now and not at the end of the tick; only a reset from outside ends it.

        Args:
            source: path of the node that raises it.
            reason: why.

        Raises:
            HumanoidBtError: this robot has none.
        """
        if self._raise_estop is None:
            raise HumanoidBtError(f"{source!r} raises an emergency stop of a robot that has none: {reason}")
        self._raise_estop(source, reason)

    def log(self, source: str, level: Level, text: str) -> None:
        """Tell something to people, as an event of the run; it is recorded.

        Args:
            source: path of the node that tells it.
            level: how much it matters.
            text: what it tells.
        """
        self._tell(source, level, text)

    def begin_tick(self, state: State, percepts: Mapping[str, Percept]) -> None:
        """Take the snapshot that the whole tick sees, and forget the targets of the last one."""
        self._state = state
        self._now = self._engine_clock.now()
        self._past.append((state.time, state.base_position, state.base_quaternion))
        for name, percept in percepts.items():
            known = self._percepts.get(name)
            if known is None or _is_news(percept, known[0]):
                self._percepts[name] = (percept, *self._place(percept))
        self._tracks.clear()
        for handle in self._commanding:
            handle.release()
        self._commanding.clear()

    def commit(self) -> Command:
        """Return the one command of this tick.

        Raises:
            ResourceConflict: two nodes that are both alive command one resource.
            HumanoidBtError: a hand is to go where the other one is, which has no place to go to.
        """
        targets: dict[str, Target] = {}
        sources: dict[str, str] = {}
        for handle in self._commanding:
            for resource, target in handle.targets.items():
                if resource in targets:
                    raise ResourceConflict(
                        f"{resource!r} is commanded by two nodes at once: {sources[resource]!r} and {handle.path!r}"
                    )
                targets[resource] = target
                sources[resource] = handle.path
        check_relative(targets, sources)
        command = Command(self._sequence, self.state.time, targets, sources)
        self._sequence += 1
        return command

    def release_all(self) -> Command:
        """Return a command that releases everything."""
        for handle in self._commanding:
            handle.targets.clear()
        return self.commit()

    def stand_still(self, state: State, percepts: Mapping[str, Percept]) -> None:
        """Take a snapshot as :meth:`begin_tick`, of a time that does not pass for the tree."""
        before = self._now if self._state is not None else self._engine_clock.now()
        self.begin_tick(state, percepts)
        self.clock.stood += self._now - before

    def repeat(self, command: Command) -> Command:
        """Return a command of an earlier tick as one of now."""
        again = replace(command, sequence=self._sequence, stamp=self.state.time)
        self._sequence += 1
        return again

    def take_over(self, other: Robot) -> None:
        """Go on where another tree's view of the same robot ends.

        What that one knows is known here too, and commands are counted on. Its nodes command no more.
        """
        self._state, self._now, self._past = other._state, other._now, other._past
        self._percepts, self._sequence = other._percepts, other._sequence
        self.clock.stood = other.clock.stood

    def note(self, handle: RobotHandle) -> None:
        """Take note that a handle has set a target in this tick."""
        self._commanding[handle] = None

    def _place(self, percept: Percept) -> tuple[Array, float, Array]:
        """Return where a percept is in the world, the heading of the box around it, and how the base was turned."""
        _, base, quaternion = self._base_at(percept.stamp)
        turn = rotation_matrix(quaternion)
        position: Array = base + turn @ percept.position
        position.setflags(write=False)
        return position, percept.heading + heading_of(turn), quaternion

    def _base_at(self, time: float) -> tuple[float, Array, Array]:
        """Return where the base was at the tick nearest to a time [s], mostly one of the latest."""
        nearest = self._past[-1]
        for pose in reversed(self._past):
            if abs(pose[0] - time) > abs(nearest[0] - time):
                break
            nearest = pose
        return nearest


def _is_news(percept: Percept, known: Percept) -> bool:
    """Return whether a percept says more than one that is known: it is newer, or says that what was seen is gone."""
    return percept.stamp > known.stamp or (percept.stamp == known.stamp and percept.confidence == 0 < known.confidence)


class RobotHandle:
    """One tree node's way to the robot: it may read everything and command what it declared.

    A target holds for one tick; a skill sets it again in every ``update``. What it does not set is released.
    """

    def __init__(self, robot: Robot, path: str, resources: tuple[str, ...]) -> None:
        self._robot = robot
        self._resources = resources
        self.path = path
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
        hands = self.state.hands
        side: Side = "left" if bearing > 0 else "right"
        other: Side = "right" if bearing > 0 else "left"
        return other if side not in hands and other in hands else side

    def why_no_nearer(self, side: Side, distance: float) -> str:
        """Say that a palm comes no nearer to its target than this [m], and which own link is in its way.

        ``left hand comes no nearer than 12 cm: the right forearm is in the way``
        """
        if touched := self.touched(side):
            return touched
        obstacle = self.state.hand_obstacles.get(side)
        why = f": the {obstacle.replace('_', ' ')} is in the way" if obstacle else ""
        return f"{side} hand comes no nearer than {distance * 100:.0f} cm{why}"

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
        return f"{side} hand turns no nearer than {math.degrees(angle):.0f} deg{why}"

    def why_no_step(self) -> str:
        """Say that the base stands though it is sent on, as for a way of few centimetres, "" if it does not.

        ``, for which it makes no step``, to go after what is left of the way.
        """
        stands = self.state.base_settled and self.state.mode is Mode.RUN
        return ", for which it makes no step" if stands else ""

    def walk_to(self, position: Any, heading: float) -> None:
        """Ask the robot to walk straight to a place and stand there; :class:`Route` goes round obstacles.

        Args:
            position: shape (2,), middle between the feet, world frame [m]; at most 1000.
            heading: world frame [rad].

        Raises:
            ValueError: a number is not finite, or out of range.
        """
        self._set("base", BaseTarget(place(position, 2), number(heading, "heading", WORKSPACE, "rad")))

    def show_route(self, points: Any) -> None:
        """Show people, in the recording, the way that the base is to take: shape (n, 2), world frame [m]."""
        self.route = np.array(points, dtype=float)

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
            position: shape (3,) [m], at most 1000.
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
        """
        side, angles = side_of(side), {name: float(angle) for name, angle in joints.items()}
        if fault := self._robot.anatomy.joints_fault(side, angles):
            raise HumanoidBtError(f"a target of the {side} arm {fault}")
        self._set(f"{side}_hand", ArmTarget(angles, speed_of(speed)))

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
            ValueError: a number is not finite, or beyond 1000 m.
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
        self._robot.raise_estop(self.path, reason)

    def log(self, text: str, level: Level = "info") -> None:
        """Tell something to people, as an event of the run; it is recorded."""
        if level not in _LEVELS:
            raise ValueError(f"what is told is an 'info', a 'warning' or an 'error', not {level!r}")
        self._robot.log(self.path, level, text)

    def release(self) -> None:
        """Take back everything asked for in this tick; called when the node ends or is halted."""
        self.targets.clear()
        self.route = None

    def _set(self, resource: str, target: Target) -> None:
        if resource not in self._resources:
            wanted = tuple(name for name in RESOURCES if name in (*self._resources, resource))
            raise HumanoidBtError(f"commands {resource!r} without declaring it; its class needs resources = {wanted}")
        self.targets[resource] = target
        self._robot.note(self)


def _to_log(source: str, level: Level, text: str) -> None:
    _log.log(_LEVELS[level], "%s: %s", source, text)
