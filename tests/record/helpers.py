"""Hand-made states and percepts, and reading a recording back."""

from __future__ import annotations

import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr

from humanoid_bt.core.messages import Array, FootPose, Gait, Mode, Percept, Side, State, Target
from humanoid_bt.perception.track import Track


def make_state(
    time: float = 0.0,
    *,
    joints: tuple[float, float, float] = (0.0, 0.0, 0.0),
    setpoints: tuple[float, float, float] = (0.0, 0.0, 0.0),
    base: tuple[float, float, float] = (0.0, 0.0, 0.8),
    yaw: float = 0.0,
    footsteps: tuple[tuple[Side, FootPose], ...] = (),
    targets: dict[str, Target] | None = None,
    foot_force: dict[Side, float] | None = None,
    mode: Mode = Mode.RUN,
) -> State:
    position = np.array(base)
    velocity: Array = np.zeros(3)
    feet: dict[Side, FootPose] = {"left": FootPose(base[0], 0.1, 0.0), "right": FootPose(base[0], -0.1, 0.0)}
    return State(
        time=time,
        cycle=round(time * 1000),
        joint_positions=np.array(joints),
        joint_velocities=np.zeros(3),
        joint_torques=np.array([1.0, 2.0, 3.0]),
        setpoint_positions=np.array(setpoints),
        setpoint_velocities=np.zeros(3),
        base_position=position,
        base_quaternion=np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]),
        base_linear_velocity=velocity,
        base_angular_velocity=velocity,
        base_covariance=np.zeros((9, 9)),
        com=position,
        com_velocity=np.array([0.3, 0.0, 0.0]),
        hands={"left": np.array([0.2, 0.2, 1.0]), "right": np.array([0.2, -0.2, 1.0])},
        feet=feet,
        stance=np.array([base[0], 0.0, 0.0]),
        gaze_position=np.array([0.0, 0.0, 1.2]),
        gaze_direction=np.array([1.0, 0.0, 0.0]),
        foot_force=foot_force or {"left": 200.0, "right": 200.0},
        gait=Gait.STAND,
        footsteps=footsteps,
        base_settled=True,
        mode=mode,
        stop_reason="",
        stop_source="",
        command_sequence=0,
        command_sources={},
        targets=targets or {},
        hand_errors={},
        hand_orientations={},
        hand_turn_errors={},
        hand_obstacles={},
        limit_flags=(),
    )


def make_track(name: str = "target", *, position: tuple[float, float, float], confidence: float, age: float) -> Track:
    percept = Percept(name, 0.0, np.array(position), confidence)
    return Track(percept, percept.position, age, make_state())


def rows(path: Path, entity: str, component: str) -> list[tuple[float, Any]]:
    """Return a component of an entity as (time [s], value), sorted; static rows are at -inf."""
    found = []
    for chunk in rr.chunk.RrdReader(path).stream():
        batch = chunk.to_record_batch()
        if chunk.entity_path != entity or component not in batch.schema.names:
            continue
        times = [-math.inf] * batch.num_rows
        if "sim_time" in batch.schema.names:
            times = [time / 1e9 for time in batch.column("sim_time").cast(pa.int64()).to_pylist()]
        found += list(zip(times, batch.column(component).to_pylist(), strict=True))
    return sorted(((time, value) for time, value in found if value is not None), key=lambda row: row[0])


def entities(path: Path) -> set[str]:
    """Return all entities of a recording."""
    return {chunk.entity_path for chunk in rr.chunk.RrdReader(path).stream()}


def events(path: Path) -> list[tuple[float, str, str]]:
    """Return the lines of the event log as (time [s], level, text), in their order."""
    levels = rows(path, "/events", "TextLog:level")
    texts = rows(path, "/events", "TextLog:text")
    return [(time, level, text) for (time, (level,)), (_, (text,)) in zip(levels, texts, strict=True)]


def messages(data: bytes) -> list[int]:
    """Return where the messages with data begin."""
    begins, at = [], 12
    while at + 16 <= len(data):
        kind, size = struct.unpack_from("<QQ", data, at)
        if kind == 2:
            begins.append(at)
        elif kind == 0:
            break
        at += 16 + size
    return begins
