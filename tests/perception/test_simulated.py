"""Simulated perception: frames, visibility, noise, and what stays the same from run to run."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.core.messages import Percept, Truth
from humanoid_bt.perception.simulated import SimulatedPerception
from humanoid_bt.plant.scene import Scene, load_scene

EYES = np.array([0.1, 0.0, 0.5])  # from the base, in its frame
EXACT = "noise: 0, noise_per_meter: 0, drop_out: 0"


def scene(folder: Path, position: str, percept: str = EXACT, events: str = "[]") -> Scene:
    path = folder / "scene.yaml"
    path.write_text(
        f"format: 1\nname: scene\nobjects: {{ball: {{shape: ball, size: [0.1], position: {position}}}}}\n"
        f"percepts: {{target: {{object: ball{', ' * bool(percept)}{percept}}}}}\nevents: {events}\n"
    )
    return Scene(load_scene(path), 0)


def robot(time: float = 0.0, base: tuple[float, float, float] = (0, 0, 0.7), yaw: float = 0, gaze: float = 0) -> Truth:
    """A robot at ``base`` that faces ``yaw`` and looks ``gaze`` to the left of that."""
    c, s = math.cos(yaw), math.sin(yaw)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return Truth(
        time,
        base_position=np.array(base),
        base_quaternion=np.array([math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)]),
        gaze_position=np.array(base) + rotation @ EYES,
        gaze_direction=np.array([math.cos(yaw + gaze), math.sin(yaw + gaze), 0]),
    )


def watch(perception: SimulatedPerception, seconds: float, yaw: float = 0) -> list[Percept]:
    return [seen for step in range(round(seconds * 10)) for seen in perception.observe(robot(step / 10, yaw=yaw))]


def test_the_position_is_in_the_frame_of_a_turned_and_moved_base(tmp_path: Path) -> None:
    perception = SimulatedPerception(scene(tmp_path, "[2, 3, 0.9]"), 0)
    (seen,) = perception.observe(robot(time=1.5, base=(2, 1, 0.7), yaw=math.pi / 2))
    np.testing.assert_allclose(seen.position, [2, 0, 0.2], atol=1e-12)
    assert (seen.name, seen.stamp) == ("target", 1.5)
    assert seen.confidence > 0.9


def test_a_tilted_base_tilts_the_position(tmp_path: Path) -> None:
    perception = SimulatedPerception(scene(tmp_path, "[1, 0, 0.7]"), 0)
    half = math.pi / 12  # leaning forward by 30 degrees
    leaning = replace(robot(), base_quaternion=np.array([math.cos(half), 0, math.sin(half), 0]))
    (seen,) = perception.observe(leaning)
    np.testing.assert_allclose(seen.position, [math.cos(math.pi / 6), 0, 0.5], atol=1e-12)


def test_what_is_behind_is_not_published_before_it_was_seen(tmp_path: Path) -> None:
    perception = SimulatedPerception(scene(tmp_path, "[-1, 0, 0.9]"), 0)
    assert perception.observe(robot(0.0)) == []
    (seen,) = perception.observe(robot(0.1, yaw=math.pi))
    assert seen.confidence > 0.9
    (remembered,) = perception.observe(robot(0.2))
    assert remembered.confidence < 0.15
    assert remembered.stamp == 0.2
    np.testing.assert_allclose(remembered.position, [-1, 0, 0.2], atol=1e-12)


def test_what_is_hidden_stays_where_it_was_last_seen(tmp_path: Path) -> None:
    events = "[{at: 0.5, hide: ball}, {at: 0.6, move: ball, to: [1, 1, 1]}, {at: 1, show: ball}]"
    perception = SimulatedPerception(scene(tmp_path, "[1, 0, 0.9]", events=events), 0)
    percepts = watch(perception, 1.5)
    assert [seen.confidence > 0.6 for seen in percepts] == [True] * 5 + [False] * 5 + [True] * 5
    np.testing.assert_allclose(percepts[9].position, [1, 0, 0.2], atol=1e-12)
    np.testing.assert_allclose(percepts[10].position, [1, 1, 0.3], atol=1e-12)


LEAVES = "[{at: 0.2, move: ball, to: [-1, 0, 0.9]}, {at: 0.8, move: ball, to: [1, 0.2, 0.9]}]"


def test_what_left_unseen_is_not_believed_where_the_eyes_see_that_it_is_not(tmp_path: Path) -> None:
    perception = SimulatedPerception(scene(tmp_path, "[1, 0, 0.9]", events=LEAVES), 0)
    perception.observe(robot(0.0))
    (remembered,) = perception.observe(robot(0.3, yaw=math.pi / 2))  # nobody looks there
    assert remembered.confidence > 0
    (gone,) = perception.observe(robot(0.4))
    assert gone.confidence == 0
    np.testing.assert_allclose(gone.position, [1, 0, 0.2], atol=1e-12)
    (gone,) = perception.observe(robot(0.5, yaw=math.pi / 2))
    assert gone.confidence == 0
    (found,) = perception.observe(robot(0.9))
    assert found.confidence > 0.9
    (remembered,) = perception.observe(robot(1.0, yaw=math.pi))
    assert 0 < remembered.confidence < 0.15


@pytest.mark.parametrize("side", [-1, 1])
def test_at_the_edge_of_the_view_nothing_is_taken_for_gone(tmp_path: Path, side: int) -> None:
    for seed in range(50):
        perception = SimulatedPerception(scene(tmp_path, "[2.1, 0, 1.2]", "noise: 0.02"), seed)
        perception.observe(robot(0.0))
        for step in range(1, 40):
            for seen in perception.observe(robot(step / 10, gaze=side * (0.77 + 0.005 * step))):
                assert seen.confidence > 0


@pytest.mark.parametrize(
    ("position", "gaze", "visible"),
    [
        ("[2.1, 0, 1.2]", 48, True),
        ("[2.1, 0, 1.2]", 52, False),
        ("[2.1, 0, 1.2]", -48, True),
        ("[2.1, 0, 1.2]", -52, False),
        ("[1.1, 0, 1.99]", 0, True),  # 38 degrees up
        ("[1.1, 0, 2.09]", 0, False),  # 42 degrees up
        ("[1.1, 0, 0.41]", 0, True),
        ("[1.1, 0, 0.31]", 0, False),
        ("[4.0, 0, 1.2]", 0, True),
        ("[4.2, 0, 1.2]", 0, False),
    ],
)
def test_the_eyes_see_100_by_80_degrees_and_4_meters(tmp_path: Path, position: str, gaze: float, visible: bool) -> None:
    perception = SimulatedPerception(scene(tmp_path, position), 0)
    assert bool(perception.observe(robot(gaze=math.radians(gaze)))) == visible


def test_confidence_falls_with_distance_but_stays_clear_of_usual_thresholds(tmp_path: Path) -> None:
    means = []
    for distance in (0.3, 2.0, 3.0, 3.99):
        perception = SimulatedPerception(scene(tmp_path, f"[{distance + 0.1}, 0, 1.2]"), 1)
        values = [seen.confidence for seen in watch(perception, 50)]
        assert 0 <= min(values) < max(values) <= 1
        assert max(values) - min(values) < 0.05
        if distance <= 3:
            assert min(values) > 0.72
        means.append(np.mean(values))
    assert means == sorted(means, reverse=True)
    assert means[0] == pytest.approx(0.95, abs=0.01)
    assert means[-1] == pytest.approx(0.6, abs=0.01)


@pytest.mark.parametrize("distance", [0.5, 3.0])
def test_noise_is_unbiased_and_grows_with_distance(tmp_path: Path, distance: float) -> None:
    perception = SimulatedPerception(scene(tmp_path, f"[{distance + 0.1}, 0, 1.2]", ""), 2)
    percepts = watch(perception, 200)
    errors = np.array([seen.position for seen in percepts]) - [distance + 0.1, 0, 0.5]
    deviation = 0.003 + 0.004 * distance
    np.testing.assert_allclose(errors.std(axis=0), deviation, rtol=0.1)
    np.testing.assert_allclose(errors.mean(axis=0), 0, atol=4 * deviation / math.sqrt(len(errors)))
    assert 0.005 < 1 - len(percepts) / 2000 < 0.04  # one in fifty drops out


def test_the_seed_alone_decides_the_noise(tmp_path: Path) -> None:
    ahead = scene(tmp_path, "[2, 0, 1]", "drop_out: 0.2")
    runs = [watch(SimulatedPerception(ahead, seed), 5) for seed in (5, 5, 6)]
    first, again, other = ([(seen.stamp, *seen.position, seen.confidence) for seen in run] for run in runs)
    assert first == again
    assert first != other


def test_what_was_seen_before_does_not_change_later_noise(tmp_path: Path) -> None:
    ahead = scene(tmp_path, "[2, 0, 1]", "drop_out: 0.2")
    blind, seeing = SimulatedPerception(ahead, 5), SimulatedPerception(ahead, 5)
    watch(blind, 2, yaw=math.pi)
    watch(seeing, 2)
    first, second = blind.observe(robot(2.0)), seeing.observe(robot(2.0))
    assert [seen.confidence for seen in first] == [seen.confidence for seen in second]


def test_drop_outs_publish_nothing_and_remember_nothing(tmp_path: Path) -> None:
    perception = SimulatedPerception(scene(tmp_path, "[2, 0, 1]", "drop_out: 1"), 0)
    assert watch(perception, 1) == []
    assert perception.unseen == {"target": "every observation is dropped"}


def test_the_first_look_is_whole(tmp_path: Path) -> None:
    ahead = scene(tmp_path, "[2, 0, 1]", "drop_out: 0.9")
    looks = [watch(SimulatedPerception(ahead, seed), 1) for seed in range(20)]
    assert {run[0].stamp for run in looks} == {0.0}
    assert np.mean([len(run) for run in looks]) < 5  # of 10 and more


def test_looking_straight_down_still_sees_what_is_there(tmp_path: Path) -> None:
    down = replace(robot(), gaze_direction=np.array([0.0, 0.0, -1.0]))
    assert SimulatedPerception(scene(tmp_path, "[0.1, 0, 0.3]"), 0).observe(down)
    assert not SimulatedPerception(scene(tmp_path, "[1.5, 0, 1.2]"), 0).observe(down)


@pytest.mark.parametrize(
    ("position", "percept", "why"),
    [
        ("[4, 0, 1.2]", "range: 3 m", "out of range: 3.9 m away, seen up to 3 m"),
        ("[0.1, 1, 1.2]", "field_of_view: 80 deg", "out of view: 90 deg left of the gaze, seen up to 40 deg"),
        ("[0.1, -1, 1.2]", "field_of_view: 80 deg", "out of view: 90 deg right of the gaze, seen up to 40 deg"),
        ("[1.1, 0, 0.2]", "vertical_field_of_view: 60 deg", "out of view: 45 deg below the gaze, seen up to 30 deg"),
    ],
)
def test_what_was_never_seen_has_a_reason(tmp_path: Path, position: str, percept: str, why: str) -> None:
    perception = SimulatedPerception(scene(tmp_path, position, f"{EXACT}, {percept}"), 0)
    assert perception.unseen == {"target": "perception has not looked yet"}
    perception.observe(robot())
    assert perception.unseen == {"target": why}


def test_what_was_hidden_is_no_longer_unseen_once_it_was_seen(tmp_path: Path) -> None:
    events = "[{at: 0, hide: ball}, {at: 1, show: ball}, {at: 2, hide: ball}]"
    perception = SimulatedPerception(scene(tmp_path, "[1, 0, 0.9]", events=events), 0)
    perception.observe(robot(0.5))
    assert perception.unseen == {"target": "hidden"}
    perception.observe(robot(1.5))
    assert perception.unseen == {}
    perception.observe(robot(2.5))
    assert perception.unseen == {}


def solid(folder: Path, body: str, percepts: str = "") -> SimulatedPerception:
    path = folder / "scene.yaml"
    path.write_text(f"format: 1\nname: scene\nobjects: {{table: {{{body}, solid: true}}}}\n{percepts}\n")
    return SimulatedPerception(Scene(load_scene(path), 0), 0)


def test_the_size_of_a_solid_thing_is_seen_and_how_it_is_turned(tmp_path: Path) -> None:
    exact = f"percepts: {{desk: {{object: table, {EXACT}}}}}"
    perception = solid(tmp_path, "shape: box, size: [0.6, 1.2, 0.7], position: [2, 0, 0.35]", exact)
    (seen,) = perception.observe(robot(yaw=0.3))
    assert seen.size is not None
    assert seen.size.tolist() == [0.6, 1.2, 0.7]
    assert seen.heading == pytest.approx(-0.3)


def test_a_marker_has_no_size(tmp_path: Path) -> None:
    (seen,) = SimulatedPerception(scene(tmp_path, "[2, 0, 0.9]"), 0).observe(robot())
    assert seen.size is None


def test_a_solid_thing_without_a_percept_is_seen_under_its_own_name(tmp_path: Path) -> None:
    perception = solid(tmp_path, "shape: cylinder, size: [0.5, 0.8], position: [2, 0, 0.4]")
    assert {percept.name for percept in watch(perception, 1.0)} == {"table"}


def test_a_solid_thing_is_seen_when_a_corner_of_it_is_in_sight(tmp_path: Path) -> None:
    aside = "position: [1, 3.0, 0.5]"  # its middle is 73 degrees to the left, half of the view is 50
    assert not watch(solid(tmp_path, f"shape: box, size: [0.3, 0.3, 1], {aside}"), 1.0)
    assert watch(solid(tmp_path, f"shape: box, size: [3.4, 0.3, 1], {aside}"), 1.0)


@pytest.mark.parametrize(
    "wall",
    [
        "size: [0.1, 1.6, 1], position: [0.65, 0, 0.5]",  # its middle is below the view, its corners are beside it
        "size: [0.1, 12, 1], position: [1, 4, 0.5]",
        "size: [16, 0.1, 1], position: [-3, 0.7, 0.5]",  # it goes on beyond the range
    ],
)
def test_a_wall_is_seen_whose_corners_and_middle_are_all_out_of_sight(tmp_path: Path, wall: str) -> None:
    assert watch(solid(tmp_path, f"shape: box, {wall}"), 0.2)


def test_a_wall_behind_the_robot_or_too_far_away_is_not_seen(tmp_path: Path) -> None:
    for x in (-0.65, 4.2):
        assert not watch(solid(tmp_path, f"shape: box, size: [0.1, 12, 1], position: [{x}, 4, 0.5]"), 0.2)


# a thing that is covered while the eyes look at its place is still believed there
def test_what_is_hidden_before_the_eyes_is_not_gone(tmp_path: Path) -> None:
    perception = SimulatedPerception(scene(tmp_path, "[1, 0, 0.9]", events="[{at: 0.5, hide: ball}]"), 0)
    percepts = watch(perception, 1.0)
    assert all(0 < seen.confidence < 0.15 for seen in percepts[5:])


def test_a_solid_thing_that_is_hidden_is_not_seen_by_its_corners(tmp_path: Path) -> None:
    events = f"percepts: {{table: {{object: table, {EXACT}}}}}\nevents: [{{at: 0.5, hide: table}}]"
    percepts = watch(solid(tmp_path, "shape: box, size: [0.6, 1.2, 0.7], position: [2, 0, 0.35]", events), 1.0)
    assert [seen.confidence > 0.6 for seen in percepts] == [True] * 5 + [False] * 5


# what is as far away as the eyes see is not plainly in view
def test_at_the_end_of_the_range_nothing_is_taken_for_gone(tmp_path: Path) -> None:
    perception = SimulatedPerception(scene(tmp_path, "[4.05, 0, 1.2]", events=LEAVES), 0)
    (seen,) = perception.observe(robot(0.0))
    (remembered,) = perception.observe(robot(0.3))  # it went behind the robot
    assert seen.confidence > 0.5
    assert 0 < remembered.confidence < 0.15


# the eyes may come to be where a thing was
def test_a_place_right_at_the_eyes_is_not_plainly_in_view(tmp_path: Path) -> None:
    perception = SimulatedPerception(scene(tmp_path, "[1, 0, 1.2]", events=LEAVES), 0)
    perception.observe(robot(0.0))
    (remembered,) = perception.observe(robot(0.3, base=(0.85, 0, 0.7)))  # 5 cm before the eyes
    assert 0 < remembered.confidence < 0.15


@pytest.mark.parametrize("side", [-1, 1])
def test_at_the_upper_and_lower_edge_of_the_view_nothing_is_taken_for_gone(tmp_path: Path, side: int) -> None:
    perception = SimulatedPerception(scene(tmp_path, "[2.1, 0, 1.2]", events=LEAVES), 0)
    perception.observe(robot(0.0))
    nod = side * math.radians(38.5)  # of 40
    looking = replace(robot(0.3), gaze_direction=np.array([math.cos(nod), 0, math.sin(nod)]))
    (remembered,) = perception.observe(looking)
    assert 0 < remembered.confidence < 0.15
    (gone,) = perception.observe(robot(0.4))
    assert gone.confidence == 0
