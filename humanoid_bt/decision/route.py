"""Walking to a place round what is solid, tick by tick: what skills that walk have in common."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from humanoid_bt.core.messages import Array, Gait
from humanoid_bt.core.texts import few, listed
from humanoid_bt.decision import arguments
from humanoid_bt.decision.giving_way import GivingWay
from humanoid_bt.decision.obstacles import SLACK, Obstacles, clear
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.decision.route_planner import Plan, plan
from humanoid_bt.decision.signals import Lasting
from humanoid_bt.decision.surroundings import REMEMBERED, Surroundings

_LEAST = 0.02  # m beyond its radius that the robot keeps away where there is no more room
_TOES = 0.05  # m beyond the tips of its feet that it keeps away from what it walks up to
_TURNING = 0.02  # m by which a robot that turns on the spot keeps within its radius
_CUT = 0.4  # share of the clearance by which it may cut a corner
_SPACING = 0.05  # m between points of the way that are looked at
_AHEAD = 2.0  # m of the way that are looked at
_OFF = 0.15  # m beside the way at which another is planned
_MOVED = 0.02  # m that a place moves before another way is planned
_FAR = 0.1  # m beyond the gait's `near` that a place on the way is ahead, so that the robot walks on
_PASSING = 1.0  # m to a place from which on it matters that something is just passing there
_OLD = 0.5  # s of age from which what it waits for may be gone, and is looked for
_MOST_TOLD = 5  # names of what is in the way
_NO_WAY_TIME = 1.0  # s after which there is no way if everything stands still
_PLAN_AGAIN = 0.25  # s after which it looks again for a way where there was none


class Route:
    """A way round everything solid that the robot has seen; :meth:`follow` it in every tick.

    The way is planned anew when something comes or moves, and when the robot has left it. It keeps away by the radius
    in which the robot walks, of its ``robot.yaml``, and the clearance, or less where there is not so much room. While
    something walks into its way, the robot waits, and steps aside from what comes to where it does.

    Args:
        robot: the skill's ``self.robot``; the skill commands the base.
        clearance: how far to keep from obstacles, beyond the robot's own radius [m].
        obstacles: percepts to go round, too, if they have no size.
        patience: how long to wait for what moves to get out of the way [s].

    Attributes:
        to_go: length of the way that is left [m].
        turns_to_go: how far it turns on that way, left and right added up [rad].
        blocked: why the robot does not walk, for people: ``box and chair are in the way``; "" while it does.
        hopeless: whether it has been so for as long as the patience, or for a second if nothing moves.
    """

    def __init__(
        self, robot: RobotHandle, clearance: float = 0.08, obstacles: Sequence[str] = (), patience: float = 5.0
    ) -> None:
        self._robot = robot
        self._around = Surroundings(robot, obstacles)
        self._least = robot.config.walking_radius + _LEAST
        self._wide = max(robot.config.walking_radius + clearance, self._least)
        self._narrow = max(self._wide - _CUT * clearance, self._least)  # between corners
        self._front = robot.config.sole.half_length + _TOES
        self._giving_way = GivingWay(self._around, robot.config.gait, self._least)
        self._waits, self._stuck = Lasting(patience), Lasting(_NO_WAY_TIME)
        self._plan: Plan | None = None
        self._planned_at, self._planned_for, self._changes = -math.inf, np.full(2, np.inf), -1
        self._in_the_way: list[str] = []
        self._waits_at: Array | None = None  # where it turns to what it waits for, shape (2,)
        self.to_go = self.turns_to_go = math.inf
        self.blocked = ""
        self.hopeless = False

    def follow(self, place: Any, heading: float, ignore: Sequence[str] = ()) -> bool:
        """Walk on to a place, in this tick; return whether the robot does, and not if something is in the way.

        Args:
            place: where to stand, shape (2,), middle between the feet, world frame [m].
            heading: where to face there, world frame [rad].
            ignore: obstacles that the robot walks up to and faces there: it may stand as near to them as its feet can.

        Raises:
            ValueError: a number is not finite, or the place is out of the world.
        """
        goal, heading = arguments.place(place, 2), arguments.number(heading, "heading", math.inf, "rad")
        here = self._robot.state.stance[:2]
        around = self._around.look()
        self._measure([here.tolist(), goal.tolist()], heading)
        taken = self._taken(around, goal[None], ignore)[0]
        if taken and (self.to_go < _PASSING or not {around.names[i] for i in self._around.moving}.issuperset(taken)):
            return self._wait(taken, f"{'stands' if len(taken) == 1 else 'stand'} there, or too near to it")
        if (away := self._giving_way.away(here, ignore)) is not None:
            return self._walk(here, away, float(self._robot.state.stance[2]))
        if self._leads_straight(around, here, goal):
            self._plan = None
            return self._walk(here, goal, heading)
        if self._outdated(here, goal):
            self._make_plan(around, here, goal)
        points = self._plan.points if self._plan is not None else None
        if points is None:
            return self._wait_for_way(around, here, goal)
        along = _project(points, here)[0]
        lengths = _lengths(points)
        self._measure([here.tolist(), *points[lengths > along + _SPACING].tolist(), goal.tolist()], heading)
        ahead = self._ahead(around, here, points, along)
        offset = ahead - here
        direction, length = math.atan2(offset[1], offset[0]), float(np.linalg.norm(offset))
        far = max(length, self._robot.config.gait.near + _FAR)
        target = here + far * np.array([math.cos(direction), math.sin(direction)])
        return self._walk(here, target, direction)

    def nearest(self, places: Any, costs: Any = None, ignore: Sequence[str] = ()) -> int | None:
        """Return the number of the place to which the way is shortest; None if there is no way to any.

        Args:
            places: shape (n, 2), world frame [m].
            costs: of ending at each, as metres of way, shape (n,); none if not given.
            ignore: as of :meth:`follow`.

        Raises:
            ValueError: they have another shape, a number is not finite, or a place is out of the world.
        """
        goals, around = arguments.places(places, "places"), self._around.look()
        worth = np.zeros(len(goals)) if costs is None else np.array(costs, dtype=float)
        free = np.array([not taken for taken in self._taken(around, goals, ignore)])
        numbers = np.flatnonzero(free)
        if not len(numbers):
            return None
        here = self._robot.state.stance[:2]
        found = self._best(around, here, goals[numbers], worth[numbers])
        return int(numbers[found.goal]) if found.points is not None else None

    def free(self, places: Any, ignore: Sequence[str] = ()) -> list[bool]:
        """Return at which places, shape (n, 2), world frame [m], the robot can stand.

        Args:
            places: them.
            ignore: as of :meth:`follow`.

        Raises:
            ValueError: they have another shape, a number is not finite, or a place is out of the world.
        """
        goals, around = arguments.places(places, "places"), self._around.look()
        return [not taken for taken in self._taken(around, goals, ignore)]

    def is_straight(self, place: Any) -> bool:
        """Return whether nothing is between the robot and a place, shape (2,), world frame [m]."""
        goal = arguments.place(place, 2)
        return self._leads_straight(self._around.look(), self._robot.state.stance[:2], goal)

    def hits(self, place: Any) -> str:
        """Return what the robot would step into on the straight way to a place, shape (2,), world frame [m].

        Names as in a sentence; "" if there is nothing. What it stands beside it may leave, and not come nearer to.
        """
        around, here, goal = self._around.look(), self._robot.state.stance[:2], arguments.place(place, 2)
        if not len(around):
            return ""
        start, end = around.beyond(here[None]), around.beyond(goal[None])
        room = np.minimum(self._robot.config.walking_radius, start.max(axis=2) - SLACK)
        return self._named(around, ~clear(start, end, room)[0])

    def beside(self) -> str:
        """Return what the robot would knock against if it turned on the spot; names as in a sentence, "" if nothing."""
        around = self._around.look()
        if not len(around):
            return ""
        room = self._robot.config.walking_radius - _TURNING
        return self._named(around, around.distances(self._robot.state.stance[None, :2])[0] < room)

    def _leads_straight(self, around: Obstacles, here: Array, goal: Array) -> bool:
        """Return whether nothing is between two places."""
        return not len(around) or bool(around.straight(here, goal[None], self._narrow).all())

    def _named(self, around: Obstacles, which: Array) -> str:
        return listed(few([name for name, one in zip(around.names, which.tolist(), strict=True) if one], _MOST_TOLD))

    def _taken(self, around: Obstacles, places: Array, ignore: Sequence[str]) -> list[list[str]]:
        """Return what is too near to each place, by name."""
        if not len(around):
            return [[] for _ in places]
        along = around.toward(places)
        facing = np.hypot(self._front * along, self._least * np.sqrt(1.0 - along**2))  # an ellipse, seen from above
        ignored = np.array([[name in ignore] for name in around.names])
        near = np.all(around.beyond(places) < np.where(ignored, facing, self._least), axis=2).tolist()
        return [[name for name, one in zip(around.names, row, strict=True) if one] for row in near]

    def _outdated(self, here: Array, goal: Array) -> bool:
        now = self._robot.clock.now()
        if self._plan is None or self._changes != self._around.changes or math.dist(goal, self._planned_for) > _MOVED:
            return True
        if self._plan.points is None:
            return now - self._planned_at > _PLAN_AGAIN
        return _project(self._plan.points, here)[1] > _OFF

    def _make_plan(self, around: Obstacles, here: Array, goal: Array) -> None:
        self._plan = found = self._best(around, here, goal[None], np.zeros(1))
        self._planned_at, self._planned_for, self._changes = self._robot.clock.now(), goal, self._around.changes
        self._in_the_way = [around.names[i] for i in found.blocking]

    def _wait_for_way(self, around: Obstacles, here: Array, goal: Array) -> bool:
        """Wait until there is a way, and when it is hopeless say what is really in it, which takes some plans."""
        self._wait(self._in_the_way, "in the way")
        if self.hopeless:
            decisive = self._decisive(around, here, goal)
            self._wait([name for name in decisive if name in self._around.movers] or decisive, "in the way")
        return False

    def _best(self, around: Obstacles, here: Array, goals: Array, costs: Array) -> Plan:
        """Return the shortest way, with less room if there is none with all of it."""
        wide = plan(around, here, goals, self._wide, costs)
        return wide if wide.points is not None else plan(around, here, goals, self._least, costs)

    def _decisive(self, around: Obstacles, here: Array, goal: Array) -> list[str]:
        """Return those of what is in the way without any one of which there would be a way; all if there are none."""
        alone = []
        for name in self._in_the_way:
            others = around.some([i for i, other in enumerate(around.names) if other != name])
            if plan(others, here, goal[None], self._least).points is not None:
                alone.append(name)
        return alone or self._in_the_way

    def _measure(self, points: Sequence[Sequence[float]], heading: float) -> None:
        """Note how far it is along points, from where the robot stands and faces to where it is to face."""
        near, faces = self._robot.config.gait.near, [self._robot.state.stance.item(2)]
        self.to_go = 0.0
        for (x, y), (next_x, next_y) in pairwise(points):
            length = math.hypot(next_x - x, next_y - y)
            self.to_go += length
            if length > near:
                faces.append(math.atan2(next_y - y, next_x - x))
        faces.append(heading)
        self.turns_to_go = sum(abs(math.remainder(after - before, math.tau)) for before, after in pairwise(faces))

    def _ahead(self, around: Obstacles, here: Array, points: Array, begin: float) -> Array:
        """Return the farthest point of the way to which nothing is between, from a length of it on [m]."""
        lengths = _lengths(points)
        end = float(lengths[-1])
        places = np.append(np.arange(begin + _SPACING, min(begin + _AHEAD, end), _SPACING), min(begin + _AHEAD, end))
        on_way = np.stack([np.interp(places, lengths, points[:, 0]), np.interp(places, lengths, points[:, 1])], 1)
        room = self._narrow if self._roomy(around, points) else self._least - SLACK
        seen = np.flatnonzero(around.straight(here, on_way, room))
        if not len(seen):
            self._planned_for = np.full(2, np.inf)  # it has left the way: another one from the next tick on
        return np.asarray(on_way[seen[-1] if len(seen) else 0])

    def _roomy(self, around: Obstacles, points: Array) -> bool:
        """Return whether a way has all the room that it should."""
        middle = points[1:-1]
        return not len(middle) or bool((around.distances(middle) >= self._narrow).all())

    def _walk(self, here: Array, target: Array, heading: float) -> bool:
        """Walk on, unless that would be into something that moves."""
        if hits := self._giving_way.would_meet(here, target):
            return self._wait(hits, "in the way")
        self.blocked, self.hopeless = "", False
        self._giving_way.walk_on()
        now = self._robot.clock.now()
        self._waits.update(False, now)
        self._stuck.update(False, now)
        self._waits_at = None
        self._robot.walk_to(target, heading)
        if self._plan is not None and self._plan.points is not None:
            self._robot.show_route(self._plan.points)
        return True

    def _wait(self, names: Sequence[str], why: str) -> bool:
        """Let the base come to rest, or step aside from what comes to where it would, and note how long for."""
        verb = "" if why.startswith("stand") else "is " if len(names) == 1 else "are "
        self.blocked = f"{listed(few(names, _MOST_TOLD))} {verb}{why}"
        now = self._robot.clock.now()
        still = not self._around.movers.intersection(names)
        waited, stuck = self._waits.update(True, now), self._stuck.update(still, now)
        self.hopeless = waited or stuck
        state = self._robot.state
        if (aside := self._giving_way.aside(state.stance[:2])) is not None:
            self._robot.walk_to(aside, float(state.stance[2]))
        else:
            self._turn_to(names)
        return False

    def _turn_to(self, names: Sequence[str]) -> None:
        """Turn to the nearest of what moves and is out of view, once the robot stands, and if it has room to."""
        movers = self._around.movers.intersection(names, self._around.obstacles.names)
        tracks = [self._robot.track(name) for name in movers]
        unseen = [track for track in tracks if track and (track.age > _OLD or track.confidence < REMEMBERED)]
        if not unseen or self.beside():
            self._waits_at = None
            return
        state = self._robot.state
        if self._waits_at is None and state.gait is Gait.STAND:
            self._waits_at = state.stance[:2].copy()
        if self._waits_at is not None:
            x, y = self._around.place(min(unseen, key=lambda track: track.distance).name) - state.stance[:2]
            self._robot.walk_to(self._waits_at, math.atan2(y, x))


def _lengths(points: Array) -> Array:
    """Return how far along a way each of its points is [m]."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _project(points: Array, here: Array) -> tuple[float, float]:
    """Return how far along a way the point nearest to a place is, and how far the place is from it [m]."""
    ways = np.diff(points, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    shares = np.clip(((here - points[:-1]) * ways).sum(axis=1) / np.maximum(lengths**2, 1e-12), 0.0, 1.0)
    aside = np.linalg.norm(points[:-1] + shares[:, None] * ways - here, axis=1)
    nearest = int(aside.argmin())
    return float(lengths[:nearest].sum() + shares[nearest] * lengths[nearest]), float(aside[nearest])
