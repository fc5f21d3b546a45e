"""What the 3D view shows beside the robot: where its eye is, hidden things, stops."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.messages import Array, BaseTarget, Contact, HandTarget, Mode, Percept, State
from humanoid_bt.perception.track import Track
from humanoid_bt.record import eye, stop_sign
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.route_view import OBSTACLES, ROUTE
from tests.record.helpers import make_state, make_track, rows

Maker = Callable[..., Recorder]

HALF_ANGLE = math.radians(55 / 2)  # the viewer's, up and down; it is wider than high
BALL = "/world/scene/object_ball/ball"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.rrd"


def facing(time: float, heading: float, **targets: Any) -> State:
    return replace(make_state(time, targets=targets), stance=np.array([0.0, 0.0, heading]))


def seen_from(
    states: list[State], tracks: dict[str, Track], points: Array, file: Path, record: Maker, *ways: Array
) -> Array:
    """Return where points are for the eye at the last state: to the right, up and ahead [m]."""
    with record() as recorder:
        recorder.routes(0.0, [way.tolist() for way in ways])
        for state in states:
            recorder.sample(state, tracks, {})
    (_, origin), (_, turn) = (rows(file, "/eye", f"Transform3D:{part}")[-1] for part in ("translation", "quaternion"))
    heading = 2 * math.atan2(turn[0][2], turn[0][3])
    c, s = math.cos(heading), math.sin(heading)
    in_frame = (points - origin[0]) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    place = np.array(eye.position(0.8))
    ahead = -place / np.linalg.norm(place)
    right = np.cross(ahead, [0, 0, 1]) / math.hypot(*ahead[:2])
    return (in_frame - place) @ np.stack([right, np.cross(right, ahead), ahead], axis=-1)


@pytest.mark.parametrize("heading", [0.0, 1.5, math.pi, -2.5])
@pytest.mark.parametrize("bearing", [0.0, 1.2, 2.4, math.pi, -1.2])
def test_what_the_robot_sees_and_goes_for_is_in_the_picture(
    record: Maker, file: Path, heading: float, bearing: float
) -> None:
    direction = np.array([math.cos(heading + bearing), math.sin(heading + bearing)])
    ball, goal, hand = np.array([*2.5 * direction, 0.9]), 1.8 * direction, np.array([*0.4 * direction, 1.1])
    state = facing(0.0, heading, base=BaseTarget(goal, heading), left_hand=HandTarget(hand))
    tracks = {"target": make_track(position=tuple(ball), confidence=0.9, age=0.1)}
    points = np.array([[0, 0, 0], [0, 0, 1.4], ball, [*goal, 0], hand])
    right, up, ahead = seen_from([state], tracks, points, file, record).T
    assert (ahead > 1).all()
    assert (np.abs(up) < math.tan(HALF_ANGLE) * ahead).all()
    assert (np.abs(right) < 1.5 * math.tan(HALF_ANGLE) * ahead).all()


def test_the_way_that_is_left_is_in_the_picture(record: Maker, file: Path) -> None:
    way = np.array([[-2.0, 0.0], [0.0, 0.0], [0.5, -2.0], [2.0, -1.5]])
    on_floor = np.column_stack([way, np.zeros(len(way))])
    right, up, ahead = seen_from([facing(0.0, 0.0)], {}, on_floor, file, record, way).T
    seen = (np.abs(up) < math.tan(HALF_ANGLE) * ahead) & (np.abs(right) < 1.5 * math.tan(HALF_ANGLE) * ahead)
    assert seen[1:].all()


def test_the_eye_looks_at_the_hands_side_whatever_the_heading(record: Maker, file: Path) -> None:
    ahead_of_it = np.array([[math.cos(2.0), math.sin(2.0), 0.9], [-math.cos(2.0), -math.sin(2.0), 0.9]])
    front, back = seen_from([facing(0.0, 2.0)], {}, ahead_of_it, file, record)
    assert front[2] < back[2]
    assert front[0] > back[0]


def test_the_eye_turns_smoothly_the_short_way_round(record: Maker, file: Path) -> None:
    with record() as recorder:
        for frame in range(200):
            recorder.sample(facing(frame * 0.04, 3.0 if frame < 20 else -3.0), {}, {})
    turns = rows(file, "/eye", "Transform3D:quaternion")
    headings = np.unwrap([2 * math.atan2(turn[0][2], turn[0][3]) for _, turn in turns])
    steps = np.diff(headings)
    assert headings[-1] - headings[0] == pytest.approx(math.tau - 6.0, abs=0.01)
    assert (steps > -1e-6).all()
    assert np.abs(np.diff(steps)).max() < 0.005  # nothing jerks


def test_a_hidden_thing_is_an_outline_until_it_is_shown_again(record: Maker, file: Path) -> None:
    ball = {"ball": np.array([1.0, 0.0, 1.0])}
    with record() as recorder:
        for frame, hidden in enumerate([(), (), ("ball",), ("ball",), ()]):
            recorder.sample(make_state(frame * 0.04), {}, ball, hidden)
    fills = rows(file, BALL, "Ellipsoids3D:fill_mode")
    colors = rows(file, BALL, "Ellipsoids3D:colors")
    assert [time for time, _ in fills] == [time for time, _ in colors] == pytest.approx([0.0, 0.08, 0.16])
    (solid, *_), (ghost, *_), (again, *_) = (
        [fill, color] for (_, (fill,)), (_, (color,)) in zip(fills, colors, strict=True)
    )
    assert solid == again != ghost
    assert colors[0][1] == colors[2][1] != colors[1][1]


def test_a_stop_has_a_disc_and_its_reason_until_it_is_over(record: Maker, file: Path) -> None:
    stop = replace(make_state(mode=Mode.EMERGENCY_STOP, base=(0.5, 0.0, 0.8)), stop_reason="light curtain ä")
    with record() as recorder:
        for frame, state in enumerate([make_state(), stop, stop, make_state(), make_state()]):
            recorder.sample(replace(state, time=frame * 0.04, cycle=frame), {}, {})
    labels = rows(file, f"/{stop_sign.REASON}", "Points3D:labels")
    discs = rows(file, f"/{stop_sign.DISC}", "Cylinders3D:centers")
    expected = ["EMERGENCY STOP\nlight curtain ?"]
    assert labels == [(0.04, expected), (0.08, expected), (pytest.approx(0.12), [])]
    assert [len(centers) for _, centers in discs] == [1, 1, 0]
    assert discs[0][1][0][:2] == pytest.approx([0.5, 0.0])


@pytest.mark.parametrize("mode", [Mode.PROTECTIVE_STOP, Mode.EMERGENCY_STOP, Mode.DAMP])
def test_every_kind_of_stop_has_a_colour_of_its_own(record: Maker, file: Path, mode: Mode) -> None:
    with record() as recorder:
        recorder.sample(make_state(0.0, mode=mode), {}, {})
    ((_, (color,)),) = rows(file, f"/{stop_sign.RIM}", "LineStrips3D:colors")
    red, green, blue = stop_sign.MODE_COLORS[mode.value]
    assert color == (red << 24) + (green << 16) + (blue << 8) + 255


def test_a_run_without_stops_has_no_sign(record: Maker, file: Path) -> None:
    with record() as recorder:
        recorder.sample(make_state(0.0), {}, {})
    assert rows(file, f"/{stop_sign.DISC}", "Cylinders3D:centers") == []


def test_what_pushes_the_robot_is_an_arrow_while_it_does(record: Maker, file: Path) -> None:
    quiet = make_state(base=(0.5, 0.0, 0.8))
    pushed = replace(quiet, contacts={"torso": Contact(np.array([-60.0, 0.0, 0.0]), 60.0)})
    with record() as recorder:
        for frame, state in enumerate([quiet, pushed, pushed, quiet]):
            recorder.sample(replace(state, time=frame * 0.04, cycle=frame), {}, {})
    vectors = [value for _, value in rows(file, "/world/contacts", "Arrows3D:vectors")]
    origins = [value for _, value in rows(file, "/world/contacts", "Arrows3D:origins")]
    assert [len(arrows) for arrows in vectors if arrows] == [1, 1]
    (way,), (begin,) = (next(filter(None, values)) for values in (vectors, origins))
    assert way == pytest.approx([-0.3, 0.0, 0.0])
    assert begin[0] + way[0] == pytest.approx(0.5)


def test_obstacles_and_the_way_round_them_are_drawn(record: Maker, file: Path) -> None:
    table = Percept("table", 0.0, np.zeros(3), 0.9, np.array([0.6, 1.2, 0.7]))
    with record() as recorder:
        for time, routes in ((0.0, []), (0.04, [[[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]]), (0.08, [])):
            state = facing(time, 0.0)
            recorder.routes(time, routes)
            seen = replace(table, confidence=0.0) if time > 0.05 else table
            recorder.sample(state, {"table": Track(seen, np.array([1.0, 0.0, 0.35]), 0.1, state)}, {})
    (_, sizes), (_, gone) = rows(file, f"/{OBSTACLES}", "Boxes3D:half_sizes")
    assert sizes[0] == pytest.approx([0.3, 0.6, 0.35])
    assert len(gone) == 0
    ways = [way for _, way in rows(file, f"/{ROUTE}", "LineStrips3D:strips")]
    assert [len(way) for way in ways] == [0, 1, 0]
    assert np.array(ways[1][0])[:, :2].tolist() == [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]
