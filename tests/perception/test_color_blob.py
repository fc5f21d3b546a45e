"""The built-in source color_blob: where it puts what it sees, and what its confidence means."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import humanoid_bt as hbt
from humanoid_bt import Moment, Percept, SourceRig, UserError
from humanoid_bt.core.geometry import quaternion_product, rotation_matrix
from tests.perception.opengl import opengl

__all__ = ["opengl"]

WIDTH, HEIGHT = 320, 225
ORANGE, GREY, BLUE = (247, 127, 20), (120, 122, 125), (30, 100, 220)
FOCAL = WIDTH / 2 / math.tan(1.745 / 2)


def disc(
    rig: SourceRig,
    column: float,
    row: float,
    radius: float,
    *,
    time: float = 0.0,
    covered: float = 0.0,
    depth: float = 1.5,
) -> Moment:
    """A ball 1.5 m ahead before a wall 3 m ahead; something nearer covers a share of it, from the left."""
    color = np.full((HEIGHT, WIDTH, 3), GREY, dtype=np.uint8)
    depths = np.full((HEIGHT, WIDTH), 3.0, dtype=np.float32)
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH]
    ball = (rows - row) ** 2 + (columns - column) ** 2 <= radius**2
    color[ball], depths[ball] = ORANGE, 1.5
    hand = (columns < column - radius + covered * 2 * radius) & (columns > column - 3 * radius) & (covered > 0)
    color[hand], depths[hand] = GREY, 1.2
    return rig.drawn(color, depths, time=time)


def seen(rig: SourceRig, moment: Moment, **values: object) -> Percept | None:
    return rig.load("color_blob", **values).look(moment).get("target")


def test_depth_and_pixel_say_where_it_is(source_rig: SourceRig) -> None:
    moment = disc(source_rig, 200.0, 150.0, 8.0)
    found = seen(source_rig, moment)
    assert found is not None
    radius = 8.0 * 1.5 / FOCAL
    assert found.position == pytest.approx(moment.picture.point(200.0, 150.0, 1.5 + 2 / 3 * radius), abs=0.003)
    assert (found.class_name, found.stamp) == ("ball", 0.0)
    assert np.sqrt(np.linalg.eigvalsh(found.covariance)).max() < 0.05


def test_confidence_falls_with_pixels_edge_cover_and_colour(source_rig: SourceRig) -> None:
    def confidence(*where: float, **more: float) -> float:
        found = seen(source_rig, disc(source_rig, *where, **more))
        return 0.0 if found is None else found.confidence

    large, small, tiny = confidence(160, 110, 12), confidence(160, 110, 2.5), confidence(160, 110, 1)
    assert large > 0.9 > small > 0.75 > tiny > 0.4
    assert confidence(0, 110, 12) < 0.6 * large
    halves = [confidence(160, 110, 12, covered=share) for share in (0.0, 0.3, 0.6, 0.9)]
    assert halves == sorted(halves, reverse=True)
    assert halves[2] < 0.6
    assert confidence(160, 110, 0.4) == 0.0
    red = np.full((HEIGHT, WIDTH, 3), GREY, dtype=np.uint8)
    red[100:120, 150:170] = (247, 80, 20)
    off = seen(source_rig, source_rig.drawn(red, 1.5))
    assert off is None or off.confidence < 0.75 * large


@pytest.mark.parametrize(
    ("color", "depth", "told"),
    [
        ([[[300, 0, 0]]], 1.0, "'color' goes from 0 to 300\n    valid: from 0 to 255"),
        ([[[0, 0, 0]], [[0, 0, 0], [0, 0, 0]]], 1.0, "'color' is no array of numbers\n    rows of one length"),
        ([[["red", "green", "blue"]]], 1.0, "'color' is no array of numbers"),
        ([[[0, 0, 0]]], None, "'depth' is no array of numbers"),
        ([[[0, 0, 0]]], [1.0, 2.0], r"'depth' has the shape \(2,\)"),
    ],
)
def test_a_picture_is_drawn_in_whole_bytes_and_metres(
    source_rig: SourceRig, color: object, depth: object, told: str
) -> None:
    with pytest.raises(UserError, match=told):
        source_rig.drawn(color, depth)


def test_other_colours_and_grey_are_not_it(source_rig: SourceRig) -> None:
    color = np.full((HEIGHT, WIDTH, 3), GREY, dtype=np.uint8)
    color[100:120, 150:170] = BLUE
    moment = source_rig.drawn(color, 1.5)
    assert seen(source_rig, moment) is None
    assert seen(source_rig, moment, color="blue") is not None
    assert seen(source_rig, moment, color="blue", farthest="1 m") is None


def test_what_something_nearer_covers_stays_where_it_was_and_is_forgotten(source_rig: SourceRig) -> None:
    trial = source_rig.load("color_blob", memory="4 s")
    first = trial.look(disc(source_rig, 160, 110, 10))["target"]
    later = trial.look(disc(source_rig, 160, 110, 10, covered=1.2, time=1.0))["target"]
    assert later.position == pytest.approx(first.position, abs=1e-6)
    assert later.confidence == pytest.approx(0.75 * first.confidence)
    assert not trial.look(disc(source_rig, 160, 110, 10, covered=1.2, time=5.0))


def test_what_is_covered_stays_where_it_was_in_the_world_and_so_does_its_covariance(source_rig: SourceRig) -> None:
    trial = source_rig.load("color_blob")
    before, after = disc(source_rig, 160, 110, 10), disc(source_rig, 160, 110, 10, covered=1.2, time=1.0)
    left = np.array(
        [math.cos(math.pi / 12), 0.0, 0.0, math.sin(math.pi / 12)]
    )  # so the base turns, and the eyes do not
    turn = rotation_matrix(left)
    eyes = replace(after.picture, position=turn.T @ after.picture.position, rotation=turn.T @ after.picture.rotation)
    quaternion = quaternion_product(left, after.state.base_quaternion)
    turned = replace(after, state=replace(after.state, base_quaternion=quaternion), picture=eyes)
    first, later = trial.look(before)["target"], trial.look(turned)["target"]
    old, new = rotation_matrix(before.state.base_quaternion), rotation_matrix(quaternion)
    assert new @ later.position == pytest.approx(old @ first.position)
    assert new @ later.covariance @ new.T == pytest.approx(old @ first.covariance @ old.T)


def test_what_is_gone_is_not_published(source_rig: SourceRig) -> None:
    trial = source_rig.load("color_blob")
    assert trial.look(disc(source_rig, 160, 110, 10))
    assert not trial.look(disc(source_rig, 160, 110, 0.1, time=0.2))


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("seed", [1, 4])
def test_finds_the_ball_in_a_real_picture(source_rig: SourceRig, seed: int) -> None:
    moment = source_rig.moment("ball_on_stand", seed=seed)
    found = seen(source_rig, moment)
    assert found is not None
    assert found.confidence > 0.7
    state = moment.state
    place = state.base_position + rotation_matrix(state.base_quaternion) @ found.position
    assert place == pytest.approx([1.9, 0.5, 0.85], abs=0.03)


@pytest.mark.usefixtures("opengl")
def test_depth_is_that_of_the_scene_and_hidden_things_are_not_in_the_picture(source_rig: SourceRig) -> None:
    moment = source_rig.moment("ball_on_stand")
    picture = moment.picture
    bottom = picture.size[1] - 1
    rotation = rotation_matrix(moment.state.base_quaternion)
    floor = moment.state.base_position + rotation @ picture.point(20, bottom, picture.depth[bottom, 20])
    assert floor[2] == pytest.approx(0.0, abs=0.01)
    assert seen(source_rig, source_rig.moment("ball_on_stand", time=4.0)) is None


@pytest.mark.usefixtures("opengl")
def test_what_is_seen_is_placed_where_control_believes_the_robot_to_be_not_where_it_is(source_rig: SourceRig) -> None:
    moment = source_rig.moment("ball_on_stand")
    assert moment.state is not None
    assert moment.truth is not None
    eyes = source_rig._eyes["ball_on_stand", 0]
    aside = replace(moment.truth, base_position=moment.truth.base_position + np.array([0.0, 0.3, 0.0]))
    found = seen(source_rig, replace(moment, picture=eyes.look(aside, moment.state)))
    assert found is not None
    place = moment.state.base_position + rotation_matrix(moment.state.base_quaternion) @ found.position
    assert place == pytest.approx([1.9, 0.5 - 0.3, 0.85], abs=0.03)
    joints = moment.state.joint_positions.copy()
    joints[source_rig._robot.joint_names.index("neck_yaw")] += 0.1  # an encoder that is off
    wrong = seen(
        source_rig, replace(moment, picture=eyes.look(moment.truth, replace(moment.state, joint_positions=joints)))
    )
    assert wrong is not None
    assert math.atan2(wrong.position[1], wrong.position[0]) == pytest.approx(math.atan2(0.5, 1.9) + 0.1, abs=0.03)


@pytest.mark.usefixtures("opengl")
def test_a_picture_is_the_same_each_time(source_rig: SourceRig) -> None:
    first, again = (source_rig.moment("ball_on_stand").picture for _ in range(2))
    assert np.array_equal(first.color, again.color)
    assert np.array_equal(first.depth, again.depth)


@pytest.mark.trials
@pytest.mark.usefixtures("opengl")
def test_fetch_by_sight_is_deterministic() -> None:
    reports = [hbt.run("fetch", scene="random_target", seed=4, perception="color_blob") for _ in range(2)]
    assert [report.outcome for report in reports] == ["success", "success"]
    assert reports[0].trace_hash == reports[1].trace_hash


@pytest.mark.trials
@pytest.mark.usefixtures("opengl")
def test_a_ball_that_was_hidden_until_the_robot_stood_before_it_is_found_again() -> None:
    report = hbt.run("fetch", seed=1, perception="color_blob", duration=20)
    assert report.outcome == "success", report.reason
