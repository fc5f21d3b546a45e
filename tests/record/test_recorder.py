"""What a recording holds, read back from its file."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import FootPose, HandTarget, Pointing
from humanoid_bt.record.recorder import Recorder
from tests.record.helpers import entities, events, make_state, make_track, rows

Maker = Callable[..., Recorder]

PERCEPT_PLOTS = {"confidence": 1.0, "age": 0.1, "distance": math.hypot(1, 2)}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.rrd"


def poses(file: Path, frame: str) -> list[tuple[float, list[float]]]:
    frames = rows(file, "/poses", "Transform3D:child_frame")
    places = rows(file, "/poses", "Transform3D:translation")
    return [(time, place[0]) for (time, place), (_, name) in zip(places, frames, strict=True) if name == [frame]]


def test_drawn_geoms_are_there_and_collision_geoms_are_not(record: Maker, file: Path) -> None:
    record().close()
    found = entities(file)
    assert {"/world/scene/floor", "/world/robot/pelvis/belly", "/world/robot/head/skull"} <= found
    assert {"/world/scene/table/plate", "/world/scene/object_ball/ball"} <= found
    assert "/world/robot/pelvis/hull" not in found


def test_a_fixed_geom_has_its_place_in_the_world(record: Maker, file: Path) -> None:
    record().close()
    ((_, frame),) = rows(file, "/world/scene/table/plate", "CoordinateFrame:frame")
    ((_, place),) = rows(file, "/world/scene/table/plate", "InstancePoses3D:translations")
    ((_, turn),) = rows(file, "/world/scene/table/plate", "InstancePoses3D:quaternions")
    assert frame == ["world"]
    assert place[0] == pytest.approx([2, 0, 0.5])
    assert np.abs(turn[0]) == pytest.approx([0, 0, math.sqrt(0.5), math.sqrt(0.5)], abs=1e-6)


def test_bodies_move_with_base_and_joints(record: Maker, file: Path) -> None:
    with record() as recorder:
        recorder.sample(make_state(0.0), {}, {})
        recorder.sample(make_state(0.04, base=(0.5, 0.0, 0.8), yaw=math.pi / 2, joints=(0.3, 0.0, 0.0)), {}, {})
    (start, at_start), (end, at_end) = poses(file, "left_leg")
    assert (start, end) == (0.0, 0.04)
    assert at_start == pytest.approx([0.0, 0.1, 0.8], abs=1e-6)
    assert at_end == pytest.approx([0.4, 0.0, 0.8], abs=1e-6)


def test_a_moved_object_moves_and_the_callers_model_does_not(record: Maker, file: Path, model) -> None:
    with record() as recorder:
        recorder.sample(make_state(0.0), {}, {})
        recorder.sample(make_state(0.04), {}, {"ball": np.array([1.5, 0.2, 1.1])})
    assert [place for _, place in poses(file, "object_ball")] == [
        pytest.approx([1.0, 0.0, 1.0], abs=1e-6),
        pytest.approx([1.5, 0.2, 1.1], abs=1e-6),
    ]
    assert list(model.body("object_ball").pos) == [1, 0, 1]


def test_an_unknown_object_is_named_with_the_known_ones(record: Maker) -> None:
    with record() as recorder, pytest.raises(HumanoidBtError, match=r"'bal'.*ball"):
        recorder.sample(make_state(), {}, {"bal": np.zeros(3)})


def test_joints_are_recorded_every_tick_and_poses_less_often(record: Maker, file: Path) -> None:
    with record() as recorder:
        for tick in range(60):
            recorder.sample(make_state(tick * 0.02, joints=(tick * 0.01, 0.0, 0.0), setpoints=(0.1, 0.2, 0.3)), {}, {})
    position = rows(file, "/joints/both\\ legs/position", "Scalars:scalars")
    assert [time for time, _ in position] == pytest.approx([tick * 0.02 for tick in range(60)])
    assert position[25][1] == pytest.approx([0.25, 0.0])
    assert rows(file, "/joints/both\\ legs/setpoint", "Scalars:scalars")[0][1] == pytest.approx([0.1, 0.2])
    assert rows(file, "/joints/other/torque", "Scalars:scalars")[0][1] == [3.0]
    assert len(poses(file, "pelvis")) == 30
    assert not any("arms" in entity for entity in entities(file))


def test_a_soft_limit_is_drawn_only_near_it(record: Maker, file: Path) -> None:
    upper = math.radians(60)
    with record() as recorder:
        recorder.sample(make_state(0.0, joints=(0.0, 0.0, 9.0)), {}, {})
        recorder.sample(make_state(0.02, joints=(upper - 0.05, 0.0, 9.0)), {}, {})
    (_, far), (_, near) = rows(file, "/joints/both\\ legs/soft_limit", "Scalars:scalars")
    assert np.isnan(far).all()
    assert near == pytest.approx([upper - 0.02, math.nan], nan_ok=True)
    assert all(np.isnan(value).all() for _, value in rows(file, "/joints/other/soft_limit", "Scalars:scalars"))


@pytest.mark.parametrize(("path", "status"), [("root/reech", "RUNNING"), ("root", "DONE")])
def test_unknown_nodes_and_statuses_are_refused(record: Maker, path: str, status: str) -> None:
    with record() as recorder, pytest.raises(HumanoidBtError, match=r"did you mean|valid"):
        recorder.node_changed(0.0, path, status, "")


def test_events_have_levels(record: Maker, file: Path) -> None:
    with record() as recorder:
        recorder.event(0.1, "info", "started")
        recorder.event(0.2, "error", "fell → ✗ \U0001f600")
        with pytest.raises(HumanoidBtError, match="warning"):
            recorder.event(0.3, "warn", "")  # type: ignore[arg-type]  # the mistake that is tried
    assert events(file) == [(0.1, "INFO", "started"), (0.2, "ERROR", "fell → ✗ ?")]


def test_percepts_have_a_place_a_colour_and_numbers(record: Maker, file: Path) -> None:
    with record() as recorder:
        recorder.sample(make_state(0.0), {}, {})
        recorder.sample(make_state(0.04), {"target": make_track(position=(1, 2, 3), confidence=1.0, age=0.1)}, {})
        recorder.sample(make_state(0.08), {"target": make_track(position=(1, 2, 3), confidence=1.0, age=2.0)}, {})
    places = rows(file, "/world/percepts/target", "Points3D:positions")
    assert places == [(0.04, [[1, 2, 3]]), (0.08, [[1, 2, 3]])]
    fresh, old = (color for _, (color,) in rows(file, "/world/percepts/target", "Points3D:colors"))
    assert fresh != old
    first = {name: rows(file, f"/percepts/{name}/target", "Scalars:scalars")[0] for name in PERCEPT_PLOTS}
    assert first == {name: (0.04, [pytest.approx(value)]) for name, value in PERCEPT_PLOTS.items()}


def test_targets_and_footsteps_come_and_go(record: Maker, file: Path) -> None:
    steps = (("left", FootPose(0.2, 0.1, 0.0)), ("right", FootPose(0.4, -0.1, 0.0)))
    target = {"left_hand": HandTarget(np.array([0.5, 0.2, 1.0]))}
    with record() as recorder:
        recorder.sample(make_state(0.0), {}, {})
        recorder.sample(make_state(0.04, targets=target, footsteps=steps), {}, {})
        recorder.sample(make_state(0.08, targets=target, footsteps=steps), {}, {})
        recorder.sample(make_state(0.12), {}, {})
    hands = rows(file, "/world/targets/hands", "Points3D:positions")
    assert [len(points) for _, points in hands] == [0, 1, 1, 0]
    boxes = rows(file, "/world/footsteps", "Boxes3D:centers")
    assert [(time, len(value)) for time, value in boxes] == [(0.0, 0), (0.04, 2), (0.12, 0)]


def test_axes_show_how_a_hand_is_to_be_turned(record: Maker, file: Path) -> None:
    """All three of an orientation, one of a direction; what is relative to the other palm is drawn where that is."""
    half = np.sqrt(0.5)
    hands = {"left": np.array([0.3, 0.2, 0.9]), "right": np.array([0.3, -0.2, 0.9])}
    frames = {"left": np.array([half, 0, 0, half]), "right": np.array([1.0, 0, 0, 0])}
    turned = {"left_hand": HandTarget(hands["left"], np.array([half, 0, 0, half]))}
    along = Pointing(np.array([1.0, 0, 0]), "facing")
    both = {
        "left_hand": HandTarget(hands["left"]),
        "right_hand": HandTarget(np.array([0.1, 0, 0]), along, relative=True),
    }
    with record() as recorder:
        for time, targets in ((0.0, {}), (0.04, turned), (0.08, both), (0.12, {})):
            state = replace(make_state(time, targets=targets), hands=hands, hand_orientations=frames)
            recorder.sample(state, {}, {})
    path = "/world/targets/turns"
    origins, vectors, colors = (rows(file, path, f"Arrows3D:{part}") for part in ("origins", "vectors", "colors"))
    assert [len(arrows) for _, arrows in vectors] == [0, 3, 1, 0]
    x, y, z = np.array(vectors[1][1]) / np.linalg.norm(vectors[1][1][0])
    np.testing.assert_allclose([x, y, z], [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-6)
    np.testing.assert_allclose(origins[2][1][0], [0.3, 0.3, 0.9], atol=1e-6)
    np.testing.assert_allclose(vectors[2][1][0] / np.linalg.norm(vectors[2][1][0]), [0, 1, 0], atol=1e-6)
    assert colors[2][1][0] == colors[1][1][2]
    points = rows(file, "/world/targets/hands", "Points3D:positions")
    np.testing.assert_allclose(points[2][1][1], [0.3, 0.3, 0.9], atol=1e-6)


def test_the_support_polygon_is_that_of_the_loaded_feet(record: Maker, file: Path) -> None:
    with record() as recorder:
        recorder.sample(make_state(0.0), {}, {})
        recorder.sample(make_state(0.04, foot_force={"left": 400.0, "right": 0.0}), {}, {})
        recorder.sample(make_state(0.08, foot_force={"left": 0.0, "right": 0.0}), {}, {})
    both, one, none = (value for _, value in rows(file, "/world/balance/support", "LineStrips3D:strips"))
    assert {round(point[1], 6) for point in both[0]} == {0.15, -0.15}
    assert {round(point[1], 6) for point in one[0]} == {0.15, 0.05}
    assert none == []


def test_documents_hold_the_tree_file_and_the_parameters(record: Maker, file: Path) -> None:
    record().close()
    assert "root: {selector: []}" in rows(file, "/documents/tree", "TextDocument:text")[0][1][0]
    run = rows(file, "/documents/run", "TextDocument:text")[0][1][0]
    assert "| seed | 7 |" in run
    assert "a: 1\nb: 2" in run


def test_a_tree_may_be_called_what_is_no_text(record: Maker, file: Path) -> None:
    """As a file whose name has bytes of another encoding."""
    with record(info={"tree": "gr\udcfc\udcdfe"}) as recorder:
        recorder.sample(make_state(0.0), {}, {})
    assert len(poses(file, "pelvis")) == 1


def test_it_writes_as_it_goes_and_flush_writes_the_rest(record: Maker, file: Path) -> None:
    recorder = record()
    recorder.event(0.0, "info", "first")
    recorder.flush()
    recorder.flush()
    recorder.close()
    assert events(file) == [(0.0, "INFO", "first")]


def test_the_file_is_whole_after_an_exception(record: Maker, file: Path) -> None:
    def run() -> None:
        with record() as recorder:
            recorder.sample(make_state(0.0), {}, {})
            raise RuntimeError("a skill broke")

    with pytest.raises(RuntimeError, match="a skill broke"):
        run()
    assert len(poses(file, "pelvis")) == 1


def test_closing_twice_is_harmless_and_writing_afterwards_is_not(record: Maker) -> None:
    recorder = record()
    recorder.close()
    recorder.close()
    recorder.flush()
    with pytest.raises(HumanoidBtError, match="closed"):
        recorder.sample(make_state(), {}, {})
