"""What the robot sees, wants and balances on, drawn into the 3D view."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import rerun as rr

from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import (
    SIDES,
    Array,
    BaseTarget,
    FootPose,
    GazeTarget,
    HandTarget,
    Pointing,
    Side,
    State,
)
from humanoid_bt.core.palm import commanded
from humanoid_bt.perception.track import Track
from humanoid_bt.record.batch import Batch
from humanoid_bt.record.columns import Color, entity, send, send_sets, strips, time_column
from humanoid_bt.record.scene_view import WORLD
from humanoid_bt.robot.config import SoleConfig

PERCEPTS = f"{WORLD}/percepts"
"""Parent of what is seen, each at its place."""

PATH = f"{WORLD}/path"
"""Entity of the ground path; the view shows all its points up to now."""

SIDE_COLORS: dict[Side, Color] = {"left": (77, 171, 247), "right": (255, 146, 43)}

_GRAVITY = 9.81  # m/s^2
_LOADED = 20.0  # force above which a foot supports [N]
_PATH_SPACING = 0.04  # distance between points of the ground path [m]
_LIFT = 0.004  # flat things lie this far above the floor, or they flicker [m]
_GAZE_LENGTH = 0.35  # of the gaze without a target [m]
_AXIS_LENGTH = 0.12  # of the axes of a hand that is to be turned [m]
_FADED = 0.5  # age at which a percept is drawn grey [s]; perception runs at 10 Hz
_COM_COLOR = (255, 255, 255)
_DCM_COLOR = (240, 101, 149)
_SUPPORT_COLOR = (105, 219, 124)
_PATH_COLOR = (134, 142, 150)
_GAZE_COLOR = (102, 217, 232)
_BASE_COLOR = (252, 196, 25)
_AXIS_COLORS = ((250, 82, 82), (81, 207, 102), (76, 110, 245))  # x along the fingers, y, z where the palm faces
_OLD_COLOR = (120, 124, 130)
_CONTACT_COLOR = (255, 82, 82)
_NEWTON = 0.005  # m of an arrow for each
_CHEST = 0.25  # m above the base: about where a torso's contact is drawn

_Samples = Sequence[tuple[State, Mapping[str, Track]]]


class Overlays:
    """Percepts, targets, footsteps, balance and path of one robot.

    Args:
        sole: the rectangle drawn for a foothold.
    """

    def __init__(self, sole: SoleConfig) -> None:
        self._sole = sole
        self._half_size = [sole.half_length, sole.half_width, 0.001]
        self._samples: Batch[tuple[State, Mapping[str, Track]]] = Batch("what the robot sees and wants")
        self._footsteps: tuple[tuple[Side, FootPose], ...] | None = None
        self._last_path: Array | None = None
        self._percepts: set[str] = set()
        self._turns = False  # a hand was turned

    def log_static(self, stream: Any) -> None:
        """Write what never changes: frames, sizes, colours."""
        frame = rr.CoordinateFrame(WORLD)
        balance = rr.Points3D.from_fields(
            colors=[_COM_COLOR, _DCM_COLOR], radii=[0.018], labels=["CoM", "DCM"], show_labels=False
        )
        support = rr.LineStrips3D.from_fields(colors=[_SUPPORT_COLOR], radii=[0.005])
        stream.log(f"{WORLD}/balance/points", frame, balance, static=True)
        stream.log(f"{WORLD}/balance/support", frame, support, static=True)
        stream.log(PATH, frame, rr.Points3D.from_fields(colors=[_PATH_COLOR], radii=[0.012]), static=True)
        stream.log(f"{WORLD}/footsteps", frame, static=True)
        stream.log(f"{WORLD}/targets/hands", frame, rr.Points3D.from_fields(radii=[0.028]), static=True)
        stream.log(f"{WORLD}/targets/errors", frame, rr.LineStrips3D.from_fields(radii=[0.004]), static=True)
        turns = rr.Arrows3D.from_fields(radii=[0.005])
        stream.log(f"{WORLD}/targets/turns", frame, turns, static=True)
        base = rr.Arrows3D.from_fields(colors=[_BASE_COLOR], radii=[0.012])
        stream.log(f"{WORLD}/targets/base", frame, base, static=True)
        contacts = rr.Arrows3D.from_fields(colors=[_CONTACT_COLOR], radii=[0.01])
        stream.log(f"{WORLD}/contacts", frame, contacts, static=True)
        gaze = rr.LineStrips3D.from_fields(colors=[_GAZE_COLOR], radii=[0.0025])
        stream.log(f"{WORLD}/gaze", frame, gaze, static=True)

    def add(self, state: State, tracks: Mapping[str, Track]) -> None:
        """Take one state and the percepts as they are known with it."""
        self._samples.append((state, tracks))

    def flush(self, stream: Any) -> None:
        """Write what was added since the last flush."""
        draws = (
            self._draw_percepts,
            self._draw_balance,
            self._draw_hands,
            self._draw_base,
            self._draw_gaze,
            self._draw_contacts,
            self._draw_footsteps,
            self._draw_path,
        )
        self._samples.draw(*(partial(draw, stream) for draw in draws))

    def _draw_percepts(self, stream: Any, samples: _Samples) -> None:
        for name in sorted({name for _, tracks in samples for name in tracks}):
            path = f"{PERCEPTS}/{entity(name)}"
            if name not in self._percepts:
                self._percepts.add(name)
                kinds = (tracks[name].class_name for _, tracks in samples if name in tracks)
                label = f"{name}: {kind}" if (kind := next(kinds, "")) else name
                look = rr.Points3D.from_fields(labels=[label], radii=[0.022], show_labels=True)
                stream.log(path, rr.CoordinateFrame(WORLD), look, static=True)
            seen = [(state.time, tracks[name]) for state, tracks in samples if name in tracks]
            columns = rr.Points3D.columns(
                positions=[track.position_world for _, track in seen],
                colors=[_confidence_color(track) for _, track in seen],
            )
            send(stream, path, [time for time, _ in seen], columns)

    def _draw_balance(self, stream: Any, samples: _Samples) -> None:
        times = _times(samples)
        com = np.array([state.com for state, _ in samples])
        velocity = np.array([state.com_velocity[:2] for state, _ in samples])
        # Divergent component of motion of the linear inverted pendulum: x + v / omega.
        period = np.sqrt(np.maximum(com[:, 2:], 0.05) / _GRAVITY)
        points = np.full((len(samples), 2, 3), _LIFT)
        points[:, 0, :2] = com[:, :2]
        points[:, 1, :2] = com[:, :2] + velocity * period
        columns = rr.Points3D.columns(positions=points.reshape(-1, 3))
        send_sets(stream, f"{WORLD}/balance/points", times, columns, [2] * len(samples))
        polygons = [self._support(state) for state, _ in samples]
        lines = rr.LineStrips3D.columns(strips=strips([polygon for polygon in polygons if polygon]))
        send_sets(stream, f"{WORLD}/balance/support", times, lines, [int(bool(polygon)) for polygon in polygons])

    def _draw_hands(self, stream: Any, samples: _Samples) -> None:
        times = _times(samples)
        goals = [
            [(side, goal) for side in SIDES if (goal := commanded(state, side)) is not None] for state, _ in samples
        ]
        targets = [
            [(side, goal.position, state.hands.get(side, goal.position)) for side, goal in row]
            for row, (state, _) in zip(goals, samples, strict=True)
        ]
        counts = [len(row) for row in targets]
        flat = [hand for row in targets for hand in row]
        colors = [SIDE_COLORS[side] for side, _, _ in flat]
        points = rr.Points3D.columns(positions=_rows([position for _, position, _ in flat]), colors=colors)
        send_sets(stream, f"{WORLD}/targets/hands", times, points, counts)
        lines = rr.LineStrips3D.columns(strips=strips([(target, palm) for _, target, palm in flat]), colors=colors)
        send_sets(stream, f"{WORLD}/targets/errors", times, lines, counts)
        axes = [[axis for _, goal in row for axis in _axes(goal)] for row in goals]
        drawn = [axis for row in axes for axis in row]
        if drawn or self._turns:  # most runs turn no hand
            arrows = rr.Arrows3D.columns(
                origins=_rows([origin for origin, _, _ in drawn]),
                vectors=_rows([vector for _, vector, _ in drawn]),
                colors=[color for _, _, color in drawn],
            )
            send_sets(stream, f"{WORLD}/targets/turns", times, arrows, [len(row) for row in axes])
            self._turns = True

    def _draw_base(self, stream: Any, samples: _Samples) -> None:
        times = _times(samples)
        bases = [state.targets.get("base") for state, _ in samples]
        found = [target for target in bases if isinstance(target, BaseTarget)]
        arrows = rr.Arrows3D.columns(
            origins=_rows([[*target.position, _LIFT] for target in found]),
            vectors=_rows(
                [[0.25 * math.cos(target.heading), 0.25 * math.sin(target.heading), 0.0] for target in found]
            ),
        )
        send_sets(stream, f"{WORLD}/targets/base", times, arrows, [int(isinstance(base, BaseTarget)) for base in bases])

    def _draw_gaze(self, stream: Any, samples: _Samples) -> None:
        rays = strips([(state.gaze_position, _gaze_end(state)) for state, _ in samples])
        send(stream, f"{WORLD}/gaze", _times(samples), rr.LineStrips3D.columns(strips=rays))

    def _draw_contacts(self, stream: Any, samples: _Samples) -> None:
        """Draw what pushes the robot as arrows that end where it does."""
        times = _times(samples)
        found = [
            [(_touched_at(state, group), _NEWTON * contact.force) for group, contact in state.contacts.items()]
            for state, _ in samples
        ]
        flat = [arrow for arrows in found for arrow in arrows]
        columns = rr.Arrows3D.columns(
            origins=_rows([end - way for end, way in flat]), vectors=_rows([way for _, way in flat])
        )
        send_sets(stream, f"{WORLD}/contacts", times, columns, [len(arrows) for arrows in found])

    def _draw_footsteps(self, stream: Any, samples: _Samples) -> None:
        changes: list[State] = []
        for state, _ in samples:
            if state.footsteps != self._footsteps:
                self._footsteps = state.footsteps
                changes.append(state)
        if not changes:
            return
        flat = [step for state in changes for step in state.footsteps]
        columns = rr.Boxes3D.columns(
            half_sizes=_rows([self._half_size] * len(flat)),
            centers=_rows([[foot.x, foot.y, foot.z + _LIFT] for _, foot in flat]),
            quaternions=[
                rr.Quaternion(xyzw=[0, 0, math.sin(foot.yaw / 2), math.cos(foot.yaw / 2)]) for _, foot in flat
            ],
            colors=[SIDE_COLORS[side] for side, _ in flat],
            fill_mode=[rr.components.FillMode.Solid] * len(flat),
        )
        times = [state.time for state in changes]
        counts = [len(state.footsteps) for state in changes]
        send_sets(stream, f"{WORLD}/footsteps", times, columns, counts, lasting=True)

    def _draw_path(self, stream: Any, samples: _Samples) -> None:
        points: list[tuple[float, Array]] = []
        for state, _ in samples:
            here = state.stance[:2]
            if self._last_path is None or np.hypot(*(here - self._last_path)) >= _PATH_SPACING:
                self._last_path = here
                points.append((state.time, np.array([here[0], here[1], _LIFT])))
        if points:
            columns = rr.Points3D.columns(positions=[point for _, point in points])
            send(stream, PATH, [time for time, _ in points], columns)

    def _support(self, state: State) -> list[tuple[float, float, float]]:
        """Return the outline of what the robot stands on, closed; empty in the air."""
        soles = [_sole_corners(state.feet[side], self._sole) for side in SIDES if state.foot_force[side] > _LOADED]
        if not soles:
            return []
        outline = soles[0] if len(soles) == 1 else _convex_hull([*soles[0], *soles[1]])
        return [(x, y, _LIFT) for x, y in (*outline, outline[0])]


def _times(samples: _Samples) -> rr.TimeColumn:
    return time_column([state.time for state, _ in samples])


def _axes(target: HandTarget) -> list[tuple[Array, Array, Color]]:
    """Return origin, vector and colour of the axes that a hand is to have: all three, or the one that points."""
    match target.orientation:
        case None:
            return []
        case Pointing(direction=direction, axis=axis):
            return [(target.position, _AXIS_LENGTH * direction, _AXIS_COLORS[0 if axis == "fingers" else 2])]
        case orientation:
            axes = _AXIS_LENGTH * rotation_matrix(orientation).T
            return [(target.position, axis, color) for axis, color in zip(axes, _AXIS_COLORS, strict=True)]


def _rows(values: list[Any]) -> Array:
    return np.array(values, dtype=float).reshape(-1, 3)


def _touched_at(state: State, group: str) -> Array:
    """Return about where a group of links is touched, shape (3,)."""
    for side in SIDES:
        if group == f"{side}_arm" and side in state.hands:
            return state.hands[side]
    x, y, z = state.base_position.tolist()
    return np.array([x, y, z + _CHEST])


def _gaze_end(state: State) -> Array:
    target = state.targets.get("gaze")
    if isinstance(target, GazeTarget):
        return target.point
    return np.asarray(state.gaze_position + _GAZE_LENGTH * state.gaze_direction)


def _confidence_color(track: Track) -> Color:
    """Red at no confidence, yellow at half, green at full; grey once old."""
    if track.age > _FADED:
        return _OLD_COLOR
    share = min(max(track.confidence, 0.0), 1.0)
    return (round(230 * min(1.0, 2 - 2 * share)), round(210 * min(1.0, 2 * share)), 70)


def _sole_corners(foot: FootPose, sole: SoleConfig) -> list[tuple[float, float]]:
    """Return them one after the other, all the way round."""
    cos, sin = math.cos(foot.yaw), math.sin(foot.yaw)
    along_x, along_y = cos * sole.half_length, sin * sole.half_length
    across_x, across_y = -sin * sole.half_width, cos * sole.half_width
    signs = ((1, -1), (1, 1), (-1, 1), (-1, -1))
    return [(foot.x + a * along_x + b * across_x, foot.y + a * along_y + b * across_y) for a, b in signs]


def _convex_hull(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the hull counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(points)

    def half(chain: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for x, y in chain:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0:
                    break
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    return half(ordered) + half(ordered[::-1])
