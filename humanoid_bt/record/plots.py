"""Numbers over time, of one unit each: joints against setpoints and limits, torques, feet, base, percepts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import mujoco
import numpy as np
import rerun as rr

from humanoid_bt.core.messages import SIDES, Array, State
from humanoid_bt.perception.track import Track
from humanoid_bt.record.batch import Batch
from humanoid_bt.record.columns import Color, Times, entity, scalars, send, time_column
from humanoid_bt.record.overlays import SIDE_COLORS
from humanoid_bt.robot.config import RobotConfig
from humanoid_bt.robot.soft_limits import soft_limits
from humanoid_bt.tree.show.looks import mix

JOINTS = "joints"
FEET = "robot/foot_force"
HANDS = "robot/hand_error"
SPEED, TURN, TILT = "robot/speed", "robot/turn_rate", "robot/tilt"
CONFIDENCE, AGE, DISTANCE = "percepts/confidence", "percepts/age", "percepts/distance"

LEGEND = "legend"
"""Curves of no values: the viewer puts legends over curves, but here are none."""

SEEN = f"percepts/{LEGEND}"
"""Parent of the legend of what is seen."""

_NEAR_LIMIT = 0.1  # a soft limit is drawn once a joint is this near [rad]; all of them would flatten the plot
_THIN, _WIDE = 1.5, 5.0  # of most curves, and of positions, behind the setpoints that they follow
_PALE = 0.5  # share of a joint's colour in its position's, on black
_LIMIT_COLOR = (255, 130, 122)
PALETTE: tuple[Color, ...] = (
    (77, 171, 247),
    (255, 169, 77),
    (105, 219, 124),
    (218, 119, 242),
    (255, 212, 59),
    (102, 217, 232),
    (250, 162, 193),
    (173, 181, 189),
)
"""Colours of curves, one after the other."""

_Samples = Sequence[tuple[State, Mapping[str, Track]]]


class Plots:
    """Time series of one robot.

    Args:
        model: gives the joints' ranges.
        joint_names: the robot's joints, in the state's order.
        config: joint groups, soft limits.
    """

    def __init__(self, model: mujoco.MjModel, joint_names: Sequence[str], config: RobotConfig) -> None:
        self._names = tuple(joint_names)
        members: dict[str, list[int]] = {group: [] for group in (*config.groups, "other")}
        for index, name in enumerate(joint_names):
            members[config.group(name)].append(index)
        self.groups: dict[str, Array] = {group: np.array(found) for group, found in members.items() if found}
        joints = [model.joint(name).id for name in joint_names]
        self._lower, self._upper = soft_limits(model, joints, config.soft_limit_margin)
        self._samples: Batch[tuple[State, Mapping[str, Track]]] = Batch("the plots")
        self._percepts: set[str] = set()
        self._limits_drawn: dict[str, bool] = {}  # at the end of the last batch, by group

    def log_static(self, stream: Any) -> None:
        """Write names and looks of all series."""
        for group, joints in self.groups.items():
            names = _short([self._names[joint] for joint in joints])
            colors = [PALETTE[index % len(PALETTE)] for index in range(len(names))]
            path = entity(JOINTS, group)
            pale = [mix(color, (0, 0, 0), _PALE) for color in colors]
            limits = [_LIMIT_COLOR] * len(names)
            _style(stream, f"{path}/position", names, pale, _WIDE)
            _style(stream, f"{path}/setpoint", [f"{name} setpoint" for name in names], colors, _THIN)
            _style(stream, f"{path}/soft_limit", [f"{name} limit" for name in names], limits, 1.0)
            _style(stream, f"{path}/torque", names, colors, _THIN)
            _style(stream, f"{path}/{LEGEND}", names, colors, _THIN)
            _scalars(stream, f"{path}/{LEGEND}", [0.0], np.full((1, len(names)), np.nan), lasting=True)
        sides = [SIDE_COLORS[side] for side in SIDES]
        _style(stream, FEET, ["left", "right"], sides, _THIN)
        _style(stream, HANDS, ["left", "right"], sides, _THIN)
        for path, name, color in zip((SPEED, TURN, TILT), ("speed", "turn rate", "tilt"), PALETTE, strict=False):
            _style(stream, path, [name], [color], _THIN)

    def add(self, state: State, tracks: Mapping[str, Track]) -> None:
        """Take one state and the percepts as they are known with it."""
        self._samples.append((state, tracks))

    def flush(self, stream: Any) -> None:
        """Write what was added since the last flush."""
        draws = (self._draw_joints, _draw_body, self._draw_percepts)
        self._samples.draw(*(partial(draw, stream) for draw in draws))

    def _draw_joints(self, stream: Any, samples: _Samples) -> None:
        times, states = _states(samples)
        position = np.array([state.joint_positions for state in states])
        setpoint = np.array([state.setpoint_positions for state in states])
        torque = np.array([state.joint_torques for state in states])
        lowest, highest = np.minimum(position, setpoint), np.maximum(position, setpoint)
        limit = np.where(lowest < self._lower + _NEAR_LIMIT, self._lower, np.nan)
        limit = np.where(highest > self._upper - _NEAR_LIMIT, self._upper, limit)
        for group, joints in self.groups.items():
            path = entity(JOINTS, group)
            _scalars(stream, f"{path}/position", times, position[:, joints])
            _scalars(stream, f"{path}/setpoint", times, setpoint[:, joints])
            _scalars(stream, f"{path}/torque", times, torque[:, joints])
            near = ~np.isnan(limit[:, joints])
            if near.any() or self._limits_drawn.get(group, True):  # else there is still none to draw
                _scalars(stream, f"{path}/soft_limit", times, limit[:, joints])
                self._limits_drawn[group] = bool(near[-1].any())

    def _draw_percepts(self, stream: Any, samples: _Samples) -> None:
        for name in sorted({name for _, tracks in samples for name in tracks}):
            seen = [(state.time, tracks[name]) for state, tracks in samples if name in tracks]
            times = time_column([time for time, _ in seen])
            paths = {
                CONFIDENCE: [track.confidence for _, track in seen],
                AGE: [track.age for _, track in seen],
                DISTANCE: [track.distance for _, track in seen],
            }
            if name not in self._percepts:
                color = PALETTE[len(self._percepts) % len(PALETTE)]
                for path in (*paths, SEEN):
                    _style(stream, entity(*path.split("/"), name), [name], [color], _THIN)
                _scalars(stream, entity(*SEEN.split("/"), name), [seen[0][0]], np.array([np.nan]), lasting=True)
                self._percepts.add(name)
            for path, values in paths.items():
                _scalars(stream, entity(*path.split("/"), name), times, np.array(values))


def _draw_body(stream: Any, samples: _Samples) -> None:
    """Draw feet, hands and base."""
    times, states = _states(samples)
    _scalars(stream, FEET, times, np.array([[state.foot_force[side] for side in SIDES] for state in states]))
    errors = np.array([[state.hand_errors.get(side, np.nan) for side in SIDES] for state in states])
    _scalars(stream, HANDS, times, errors)
    for path, values in zip((SPEED, TURN, TILT), _base(states), strict=True):
        _scalars(stream, path, times, values)


def _states(samples: _Samples) -> tuple[rr.TimeColumn, list[State]]:
    """Return times and states."""
    return time_column([state.time for state, _ in samples]), [state for state, _ in samples]


def _scalars(stream: Any, path: str, times: Times, values: Array, *, lasting: bool = False) -> None:
    send(stream, path, times, scalars(values), lasting=lasting)


def _style(stream: Any, path: str, names: Sequence[str], colors: Sequence[Any], width: float) -> None:
    stream.log(path, rr.SeriesLines(names=names, colors=colors, widths=[width] * len(names)), static=True)


def _short(names: Sequence[str]) -> list[str]:
    return [name.removesuffix("_joint").replace("_", " ") for name in names]


def _base(states: Sequence[State]) -> tuple[Array, Array, Array]:
    """Return speed [m/s], turn rate [rad/s] and tilt [rad] of the base."""
    linear = np.array([state.base_linear_velocity[:2] for state in states])
    turn = np.array([state.base_angular_velocity[2] for state in states])
    quaternion = np.array([state.base_quaternion for state in states])
    # Cosine of the tilt: the z axis of the base along the world's, from the rotation matrix's last element.
    upright = 1 - 2 * (quaternion[:, 1] ** 2 + quaternion[:, 2] ** 2)
    tilt = np.arccos(np.clip(upright, -1, 1))
    return np.hypot(linear[:, 0], linear[:, 1]), turn, tilt
