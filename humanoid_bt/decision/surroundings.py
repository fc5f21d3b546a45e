"""What is solid around the robot, as far as it was seen: where it stands, whether it moves, how fast."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from humanoid_bt.core.messages import Array, State
from humanoid_bt.decision.obstacles import Obstacles
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.perception.track import Track

UNKNOWN_SIZE = 0.5
"""Length and width of what is said to be an obstacle, and was seen without a size [m]: those of a person."""

REMEMBERED = 0.3
"""Confidence below which a thing is not seen, but published where it was seen last."""

_FOLLOW_TIME = 0.4  # s, of the low-pass of a position
_JUMP, _JUMP_PER_METER = 0.05, 0.03  # m, m/m: what comes farther than this has moved; more than the noise
_REST_TIME = 1.0  # s after its last move in which a thing still counts as moving
_BEGUN = 0.4  # s before it is clear that a thing moves, in which it already did
_LOOKS = 4  # at least so many places in that time or in the last second show how fast it is
_ROUNDING = 1e-6  # s
_FORESEEN = 3.0  # s for which what moved when it was last seen is thought to go on
_OVERHEAD = 0.25  # m above the eyes under which the robot walks through


@dataclass
class _Thing:
    """One obstacle: where it is, and where and when it was when it had moved last [m], [s].

    That it is not seen to move, because it has left the view, does not say that it stands still.
    """

    position: Array
    stamp: float
    anchor: Array = field(init=False)
    moved_at: float = -math.inf
    velocity: Array = field(default_factory=lambda: np.zeros(2))

    def __post_init__(self) -> None:
        self.anchor = self._told = self.position
        self._since = self._seen_at = self.stamp
        self._looks = deque([(self.stamp, self.position)])  # in which it may have moved

    def update(self, seen: Array, stamp: float, jump: float, *, remembered: bool) -> bool:
        """Take where it was seen, or is remembered to have been; return whether it has moved."""
        elapsed = stamp - self.stamp
        if elapsed <= 0.0:
            return False
        self.stamp = stamp
        step, moves = seen - self.position, self.goes_on(stamp)
        jumps = not moves and math.hypot(*step) > jump
        follow = 1.0 if moves or jumps else elapsed / (elapsed + _FOLLOW_TIME)
        self.position = self.position + follow * step
        way = self.position - self.anchor
        moved = math.hypot(*way) > jump
        if moved:
            self.velocity = way / (stamp - max(self._since, self.moved_at, self._seen_at - _REST_TIME))
            self.anchor, self.moved_at = self.position, stamp
        if moved or not remembered:
            self._seen_at = stamp
            if jumps:
                self._looks.clear()
            self._looks.append((stamp, seen))
            while self._looks[0][0] < stamp - (_REST_TIME if moves else _BEGUN) - _ROUNDING:
                self._looks.popleft()
            if (moves or moved) and len(self._looks) >= _LOOKS:
                self.velocity = _slope(self._looks)
        return moved

    def goes_on(self, now: float) -> bool:
        """Return whether it moves, or did a moment ago when it was last seen."""
        return self._seen_at - self.moved_at < _REST_TIME and now - self._seen_at < _FORESEEN

    def place(self, now: float) -> Array:
        """Return where it is thought to be, shape (2,), world frame [m]."""
        return self.position + (now - self._seen_at) * self.velocity if self.goes_on(now) else self.position

    def is_elsewhere(self, place: Array, jump: float) -> bool:
        """Return whether a place is farther from the last one of which this was true; it is then the last one."""
        elsewhere = math.dist(place, self._told) > jump
        if elsewhere:
            self._told = place
        return elsewhere


class Surroundings:
    """Everything solid that the robot has seen.

    Args:
        robot: who asks.
        named: percepts that are obstacles, too, if they have no size.

    Attributes:
        obstacles: what stands around, as of the last :meth:`look`.
        velocities: of each, shape (n, 2), world frame [m/s]; 0 of what is at rest.
        changes: how often something has come, moved or gone.
        movers: names of what has ever moved.
    """

    def __init__(self, robot: RobotHandle, named: Sequence[str] = ()) -> None:
        self._robot, self._named = robot, tuple(named)
        self._things: dict[str, _Thing] = {}
        self._looked_at: State | None = None
        self.obstacles = Obstacles((), np.empty((0, 2)), np.empty((0, 2)), np.empty(0))
        self.velocities: Array = np.empty((0, 2))
        self.changes = 0
        self.movers: set[str] = set()

    @property
    def moving(self) -> list[int]:
        """What moves now, by its number among the obstacles."""
        if not self.movers:
            return []
        return np.flatnonzero(self.velocities.any(axis=1)).tolist()

    def look(self) -> Obstacles:
        """Take what is seen in this tick, once, and return what stands around."""
        if self._robot.state is self._looked_at:
            return self.obstacles
        self._looked_at = self._robot.state
        tracks = self._tracks()
        if not tracks and not len(self.obstacles):
            return self.obstacles
        now = self._robot.clock.now()
        for name in self._things.keys() - {track.name for track in tracks}:
            del self._things[name]
            self.changes += 1
        for track in tracks:
            seen, jump = track.position_world[:2], _JUMP + _JUMP_PER_METER * track.distance
            if (thing := self._things.get(track.name)) is None:
                self._things[track.name] = _Thing(seen, track.stamp)
                self.changes += 1
                continue
            if thing.update(seen, track.stamp, jump, remembered=track.confidence < REMEMBERED):
                self.movers.add(track.name)
            self.changes += thing.is_elsewhere(thing.place(now), jump)
        things = [self._things[track.name] for track in tracks]
        self.obstacles = Obstacles(
            [track.name for track in tracks],
            np.array([thing.place(now) for thing in things]).reshape(-1, 2),
            np.array([_floor_size(track) for track in tracks]).reshape(-1, 2) / 2,
            np.array([track.heading_world for track in tracks]),
        )
        self.velocities = np.array([thing.velocity * thing.goes_on(now) for thing in things]).reshape(-1, 2)
        return self.obstacles

    def place(self, name: str) -> Array:
        """Return where a thing that stands around is thought to be, shape (2,), world frame [m]."""
        return np.asarray(self.obstacles.middles[list(self.obstacles.names).index(name)])

    def _tracks(self) -> list[Track]:
        solid = self._robot.obstacles
        if not (solid or self._named or self._things):
            return []
        eyes = float(self._robot.state.gaze_position[2])
        solid = [track for track in solid if not _is_overhead(track, eyes)]
        sized = {track.name for track in solid}
        named = [self._robot.track(name) for name in self._named if name not in sized]
        return solid + [track for track in named if track is not None and not track.gone] + self._left()

    def _left(self) -> list[Track]:
        """Return what is gone from where it was last seen, because it goes on."""
        now = self._robot.clock.now()
        tracks = [self._robot.track(name) for name, thing in self._things.items() if thing.goes_on(now)]
        return [track for track in tracks if track is not None and track.gone]


def _slope(looks: Sequence[tuple[float, Array]]) -> Array:
    """Return how fast something moves that was seen at times [s] at places, shape (2,) [m/s], by least squares."""
    times, places = np.array([time for time, _ in looks]), np.array([place for _, place in looks])
    times -= times.mean()
    return np.asarray(times @ places / (times @ times))


def _is_overhead(track: Track, eyes: float) -> bool:
    return track.size is not None and bool(track.position_world[2] - track.size[2] / 2 > eyes + _OVERHEAD)


def _floor_size(track: Track) -> Sequence[float]:
    return (UNKNOWN_SIZE, UNKNOWN_SIZE) if track.size is None else (float(track.size[0]), float(track.size[1]))
