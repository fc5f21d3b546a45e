"""Scenes: what is where at which time, and what a mistake in a scene file is answered with."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.plant.floor import ANY, FLOOR, Floor
from humanoid_bt.plant.scene import Scene, load_scene

SCENES = Path(__file__).resolve().parents[2] / "sim" / "scenes"

BALL = "shape: ball, size: [8 cm]"


def scene(folder: Path, body: str, seed: int = 0) -> Scene:
    return Scene(load_scene(write(folder, body)), seed)


def write(folder: Path, body: str) -> Path:
    path = folder / "scene.yaml"
    path.write_text("format: 1\nname: scene\n" + body)
    return path


def problems(folder: Path, body: str) -> str:
    with pytest.raises(UserError) as error:
        load_scene(write(folder, body))
    return str(error.value)


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.yaml")), ids=lambda path: path.stem)
def test_every_scene_of_the_project_can_be_simulated(path: Path) -> None:
    config = load_scene(path)
    assert config.name == path.stem
    assert config.path == path
    spec = mujoco.MjSpec()
    Scene(config, 1).add_to(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    assert model.geom(FLOOR).contype[0] == ANY
    assert data.ncon == 0


def test_defaults_of_a_robots_model_are_none_of_the_scene(tmp_path: Path) -> None:
    path = write(tmp_path, f"objects: {{ball: {{{BALL}, position: [1, 0, 1], solid: true, stand: true}}}}\n")
    theirs = '<mujoco><default><geom margin="0.1" solref="1 1" priority="3"/></default></mujoco>'
    spec = mujoco.MjSpec.from_string(theirs)
    Scene(load_scene(path), 0, Floor(plates=0.01)).add_to(spec)
    model = spec.compile()
    assert not model.geom_margin.any()
    assert not model.geom_priority.any()
    np.testing.assert_allclose(model.geom_solref, [[0.02, 1]] * model.ngeom)


@pytest.mark.parametrize("name", ["floor", "sky", "lamp", "plate_0"])
def test_a_robot_has_names_of_its_own(tmp_path: Path, name: str) -> None:
    spec = mujoco.MjSpec()
    spec.worldbody.add_light(name=name)
    spec.worldbody.add_geom(name=name, size=[0.1] * 3)
    spec.add_texture(name=name, builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT, width=8, height=8)
    spec.add_material(name=name)
    Scene(load_scene(SCENES / "empty.yaml"), 0, Floor(plates=0.01)).add_to(spec)
    assert spec.compile().light(name).id == 0


def test_the_same_seed_gives_the_same_scene_and_another_seed_another() -> None:
    config = load_scene(SCENES / "random_target.yaml")
    first, again, other = (Scene(config, seed).object_position("ball", 0) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert np.linalg.norm(first - other) > 0.01


def test_random_places_lie_within_their_bounds_around_the_start(tmp_path: Path) -> None:
    text = f"""
robot: {{position: [2, 1], heading: 90 deg}}
objects:
  ball: {{{BALL}, random: {{distance: [1, 3], bearing: [-30 deg, 0 deg], height: [60 cm, 1]}}}}
"""
    config = load_scene(write(tmp_path, text))
    places = np.array([Scene(config, seed).object_position("ball", 0) for seed in range(200)])
    offset = places[:, :2] - [2, 1]
    distance, bearing = np.hypot(*offset.T), np.arctan2(offset[:, 1], offset[:, 0]) - math.pi / 2
    for values, low, high in ((distance, 1, 3), (bearing, -math.pi / 6, 0), (places[:, 2], 0.6, 1)):
        assert (values >= low - 1e-9).all()
        assert (values <= high + 1e-9).all()
        assert np.ptp(values) > 0.8 * (high - low)


def test_another_object_does_not_move_the_first(tmp_path: Path) -> None:
    place = "random: {distance: [1, 3], bearing: [-1, 1], height: [0, 1]}"
    one = scene(tmp_path, f"objects:\n  ball: {{{BALL}, {place}}}\n")
    two = scene(tmp_path, f"objects:\n  another: {{{BALL}, {place}}}\n  ball: {{{BALL}, {place}}}\n")
    np.testing.assert_array_equal(one.object_position("ball", 0), two.object_position("ball", 0))
    assert np.linalg.norm(two.object_position("another", 0) - two.object_position("ball", 0)) > 0.01


def test_objects_move_in_a_straight_line_and_a_later_move_takes_over(tmp_path: Path) -> None:
    moving = scene(
        tmp_path,
        f"""
objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}
events:
  - {{at: 5, move: ball, to: [1, 9, 1]}}
  - {{at: 1 s, move: ball, to: [4, 0, 1], over: 4 s}}
  - {{at: 3 s, move: ball, to: [2, 0, 2], over: 1000 ms}}
""",
    )
    expected: dict[float, list[float]]
    expected = {0: [0, 0, 1], 1: [0, 0, 1], 2: [1, 0, 1], 3: [2, 0, 1], 3.5: [2, 0, 1.5], 4.5: [2, 0, 2], 5: [1, 9, 1]}
    for time, position in expected.items():
        np.testing.assert_allclose(moving.object_position("ball", time), position, err_msg=f"at {time} s")


def test_a_position_that_is_given_out_belongs_to_the_caller(tmp_path: Path) -> None:
    still = scene(tmp_path, f"objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}\n")
    still.object_position("ball", 0)[:] = 7
    np.testing.assert_array_equal(still.object_position("ball", 0), [0, 0, 1])


def test_the_demo_hides_its_ball_for_three_seconds() -> None:
    demo = Scene(load_scene(SCENES / "ball_on_stand.yaml"), 0)
    hidden = {time: demo.hidden("ball", time) for time in (0, 1.999, 2, 4.999, 5, 100)}
    assert hidden == {0: False, 1.999: False, 2: True, 4.999: True, 5: False, 100: False}
    assert demo.events(0, 100) == [(2.0, "ball hidden"), (5.0, "ball shown")]


def test_every_event_is_reported_once_by_consecutive_calls(tmp_path: Path) -> None:
    busy = scene(
        tmp_path,
        f"""
objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}
events: [{{at: 0, hide: ball}}, {{at: 2, move: ball, to: [1, 2, 0.5], over: 3}}]
""",
    )
    told = [event for time in range(4) for event in busy.events(time, time + 1)]
    assert told == [(0.0, "ball hidden"), (2.0, "ball moves to (1, 2, 0.5) over 3 s")]


def test_the_start_pose_is_the_files(tmp_path: Path) -> None:
    assert scene(tmp_path, "robot: {position: [1, -2], heading: 180 deg}").start_pose == (1, -2, math.pi)
    assert scene(tmp_path, "").start_pose == (0, 0, 0)


def contacts_of_a_probe(target: Scene, position: list[float], contype: int = 1, conaffinity: int = 1) -> int:
    spec = mujoco.MjSpec()
    target.add_to(spec)
    probe = spec.worldbody.add_body(name="probe", pos=position)
    probe.add_freejoint()
    probe.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.02, 0, 0], contype=contype, conaffinity=conaffinity)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return int(data.ncon)


@pytest.mark.parametrize(("contype", "conaffinity"), [(1, 0), (0, 1), (2, 2), (4, 0), (0, 1 << 30)])
def test_floor_and_solid_things_touch_what_touches_anything(tmp_path: Path, contype: int, conaffinity: int) -> None:
    ball = scene(tmp_path, f"objects: {{ball: {{{BALL}, position: [1, 0, 0.8], solid: true, stand: true}}}}\n")
    for place in ([0, 0, 0.01], [1, 0, 0.8], [1, 0, 0.4]):
        assert contacts_of_a_probe(ball, place, contype, conaffinity)
        assert not contacts_of_a_probe(ball, place, 0, 0)


@pytest.mark.parametrize(("solid", "expected"), [("true", True), ("false", False)])
@pytest.mark.parametrize("shape", [BALL, "shape: box, size: [0.1, 0.1, 0.1]", "shape: cylinder, size: [0.1, 0.1]"])
def test_only_a_solid_object_is_bumped_into(tmp_path: Path, shape: str, solid: str, expected: bool) -> None:
    target = scene(tmp_path, f"objects: {{thing: {{{shape}, position: [1, 0, 0.8], solid: {solid}}}}}\n")
    assert bool(contacts_of_a_probe(target, [1, 0, 0.83])) == expected
    assert not contacts_of_a_probe(target, [1, 0, 0.9])


def test_a_stand_is_solid_but_leaves_a_hand_room_below_a_marker(tmp_path: Path) -> None:
    target = scene(tmp_path, f"objects: {{ball: {{{BALL}, position: [1, 0, 0.8], stand: true}}}}\n")
    assert contacts_of_a_probe(target, [1, 0, 0.5])
    assert contacts_of_a_probe(target, [1.08, 0, 0.025])
    assert not contacts_of_a_probe(target, [1, 0, 0.7])
    low = scene(tmp_path, f"objects: {{ball: {{{BALL}, position: [1, 0, 0.04], stand: true}}}}\n")
    low.add_to(spec := mujoco.MjSpec())
    spec.compile()


def person(folder: Path, more: str = "") -> tuple[mujoco.MjModel, mujoco.MjData]:
    text = (
        f"robot: {{position: [1, 1]}}\nobjects: {{one: {{shape: person, size: [1.6], position: [1, 3, 0.8]{more}}}}}\n"
    )
    scene(folder, text).add_to(spec := mujoco.MjSpec())
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def test_a_person_stands_on_the_floor_as_tall_as_asked_for_and_faces_the_robot(tmp_path: Path) -> None:
    model, data = person(tmp_path)
    geoms = np.flatnonzero(model.geom_bodyid == model.body("object_one").id)
    boxes = model.geom_aabb[geoms]
    half = np.einsum("nij,nj->ni", np.abs(data.geom_xmat[geoms].reshape(-1, 3, 3)), boxes[:, 3:])
    assert (data.geom_xpos[geoms] - half)[:, 2].min() == pytest.approx(0, abs=0.01)
    assert (data.geom_xpos[geoms] + half)[:, 2].max() == pytest.approx(1.6, abs=0.02)
    hair, eye = data.geom("hair of one").xpos, data.geom("left eye of one").xpos
    assert eye[1] < hair[1]  # toward the robot
    assert eye[0] > hair[0]  # its left is the robot's right


@pytest.mark.parametrize(("more", "touches"), [("", 0), (", solid: true", ANY)])
def test_only_a_solid_person_is_bumped_into(tmp_path: Path, more: str, touches: int) -> None:
    model, _ = person(tmp_path, more)
    geoms = np.flatnonzero(model.geom_bodyid == model.body("object_one").id)
    assert set(model.geom_contype[geoms]) == set(model.geom_conaffinity[geoms]) == {touches}


def test_an_object_moves_with_its_body_and_its_stand_stays(tmp_path: Path) -> None:
    target = scene(tmp_path, f"objects: {{ball: {{{BALL}, position: [1, 0, 0.8], stand: true}}}}\n")
    target.add_to(spec := mujoco.MjSpec())
    model = spec.compile()
    data = mujoco.MjData(model)
    model.body("object_ball").pos[:] = [2, 1, 1]
    mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.geom("object_ball").xpos, [2, 1, 1])
    np.testing.assert_allclose(data.body("stand_ball").xpos, [1, 0, 0])


@pytest.mark.parametrize(
    ("body", "place", "message"),
    [
        ("objects: {ball: {shape: ball, size: [0.1]}}", "3:17", "this object has no position"),
        (f"objects: {{ball: {{{BALL}, position: [0, 0, 1], random: {{distance: [1, 2], bearing: [0, 1], "
         "height: [0, 1]}}}", "3:17", "both a position and a random one"),
        ("objects: {ball: {shape: bal, size: [0.1], position: [0, 0, 1]}}", "3:25", "did you mean 'ball'"),
        ("objects: {ball: {shape: box, size: [0.1], position: [0, 0, 1]}}", "3:36", "[length, width, height]"),
        ("objects: {one: {shape: person, size: [0.5, 1.7], position: [0, 0, 1]}}", "3:38", "[height]"),
        (f"objects: {{ball: {{{BALL}, random: {{distance: [3, 1], bearing: [0, 1], height: [0, 1]}}}}}}",
         "3:64", "from 3 down to 1"),
        (f"objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}\npercepts: {{target: {{object: bal}}}}",
         "4:29", "did you mean 'ball'"),
        (f"objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}\nevents:\n  - {{at: 1, hide: bll}}",
         "5:19", "did you mean 'ball'"),
        (f"objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}\nevents:\n  - {{at: 1, hide: ball, show: ball}}",
         "5:5", "not hide and show"),
        ("events:\n  - {at: 1}", "4:5", "write hide: OBJECT"),
        (f"objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}\nevents:\n  - {{at: 1, move: ball}}",
         "5:5", "to: [x, y, z]"),
        (f"objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}\nevents:\n  - {{at: 1, hide: ball, over: 2}}",
         "5:25", "'over' belongs to a move"),
        ("percepts: {target: {object: ball}}", "3:29", "this scene has no objects"),
        ("robot: {heading: 10 m}", "3:18", "valid: rad, deg"),
        ("object: {}", "3:1", "did you mean 'objects'"),
    ],
)  # fmt: skip
def test_a_mistake_is_answered_with_its_place_and_the_fix(tmp_path: Path, body: str, place: str, message: str) -> None:
    told = problems(tmp_path, body + "\n")
    assert f"scene.yaml:{place}: " in told
    assert message in told


def test_all_mistakes_are_told_at_once(tmp_path: Path) -> None:
    told = problems(tmp_path, "percepts: {a: {object: x}, b: {object: y}}\nevents: [{at: 1}]\n")
    assert told.count("scene.yaml:") == 3


def test_a_mistake_in_a_value_hides_no_other(tmp_path: Path) -> None:
    cup = "{shape: ball, size: [8 sm], position: [0, 0, 1]}"
    body = f"robot: {{heading: 1 m}}\nobjects: {{cup: {cup}, mug: {cup}}}\npercepts: {{target: {{object: cap}}}}\n"
    told = problems(tmp_path, body + "events: [{at: 1, hide: cop}, {at: 2 m, show: cup}]\n")
    assert told.count("scene.yaml:") == 6


def test_what_does_not_go_together_is_told_whatever_else_is_wrong(tmp_path: Path) -> None:
    told = problems(
        tmp_path,
        """\
objects:
  cup: {shape: box, size: [0.4, 0.4], colour: red, position: [0, 0, 1], random: {distance: [2, 1], baring: [0, 1]}}
  mug: {shape: ball, size: [0], solid: 1}
percepts:
  cup: {object: cup, nois: 0.1, drop_out: 2}
events:
  - {at: -1 s, show: cup, hide: box}
  - {at: 1 s, ovr: 2 s}
  - {at: 1 s, move: cup, ovr: 2 s}
  - {att: 1 s, hide: cup, to: [0, 0, 1]}
""",
    )
    expected = [
        ("4:8", "this object has both a position and a random one"),
        ("4:27", "a box's size is [length, width, height]"),
        ("4:39", "unknown key 'colour' of the object 'cup'"),
        ("4:92", "'distance' runs from 2 down to 1"),
        ("4:100", "unknown key 'baring' of 'random'"),
        ("4:81", "the key 'height' of 'random' is missing"),
        ("5:8", "this object has no position"),
        ("5:29", "'size' must be >= 0.0001, not 0"),
        ("5:40", "'solid' must be true or false"),
        ("7:22", "unknown key 'nois' of the percept 'cup'"),
        ("7:43", "'drop_out' must be >= 0 and <= 1, not 2"),
        ("9:5", "an event is one of hide, show, move, not hide and show"),
        ("9:10", "'at' must be >= 0, not '-1 s'"),
        ("9:33", "there is no object 'box'"),
        ("10:5", "this event does nothing"),
        ("10:15", "unknown key 'ovr' of an event"),
        ("11:5", "a move needs where it goes"),
        ("11:26", "unknown key 'ovr' of an event"),
        ("12:6", "unknown key 'att' of an event"),
        ("12:27", "'to' belongs to a move"),
    ]
    for place, message in expected:
        assert f"scene.yaml:{place}: error: {message}" in told
    assert told.count("scene.yaml:") == len(expected)
    assert "\n    a number from 0 to 1" in told
    assert "\n    a number from 0, in s" in told
    assert "\n    a number from 0.0001, in m" in told


def test_a_solid_object_is_not_hidden_behind_a_percept_of_its_name(tmp_path: Path) -> None:
    body = """objects:
  box: {shape: box, size: [1, 1, 1], position: [2, 0, 0.5], solid: true}
  ball: {shape: ball, size: [0.1], position: [1, 0, 1]}
percepts:
  box: {object: ball}
"""
    assert "scene.yaml:7:3: error: the solid object 'box' is not seen: the percept of this name" in problems(
        tmp_path, body
    )
    seen = load_scene(write(tmp_path, body + "  crate: {object: box}\n"))
    assert set(seen.percepts) == {"box", "crate"}


@pytest.mark.parametrize(
    ("shape", "size"),
    [("ball, size: [0.2]", [0.2, 0.2, 0.2]), ("cylinder, size: [0.3, 0.8]", [0.3, 0.3, 0.8])],
)
def test_the_box_around_a_solid_object(tmp_path: Path, shape: str, size: list[float]) -> None:
    box = scene(tmp_path, f"objects: {{thing: {{shape: {shape}, position: [1, 0, 0.8], solid: true}}}}\n").box("thing")
    assert box is not None
    assert box.size.tolist() == size


def test_the_box_around_a_person_holds_every_part_of_it(tmp_path: Path) -> None:
    person = "objects: {guest: {shape: person, size: [1.7], position: [1, 2, 0.85], solid: true}}\n"
    target = scene(tmp_path, person)
    box, spec = target.box("guest"), mujoco.MjSpec()
    target.add_to(spec)
    model = spec.compile()
    assert box is not None
    for geom in np.flatnonzero(model.geom_bodyid == model.body("object_guest").id):
        assert np.all(np.abs(model.geom_pos[geom]) < box.size / 2), model.geom(geom).name


def test_an_object_may_be_named_like_a_part_of_a_person(tmp_path: Path) -> None:
    ball = f"{{{BALL}, position: [1, 0, 1]}}"
    person = "{shape: person, size: [0.1 mm], position: [2, 0, 0.85]}"
    body = f'objects: {{p: {person}, "p:head": {ball}, head: {ball}, "head of p": {ball}, "object_p:head": {ball}}}\n'
    scene(tmp_path, body).add_to(spec := mujoco.MjSpec())
    assert spec.compile().body("object_p:head").geomnum == 1


@pytest.mark.parametrize(
    ("body", "place", "message"),
    [
        ("robot: {position: [5000, 0]}", "3:20", "'position' must be >= -900 and <= 900, not 5000"),
        (f"objects: {{ball: {{{BALL}, position: [0, -1.0e+9, 1]}}}}", "3:59", "'position' must be >= -900 and <= 900"),
        (f"objects: {{ball: {{{BALL}, random: {{distance: [1, 2000], bearing: [0, 1], height: [0, 5000]}}}}}}",
         "3:68", "'distance' must be >= 0 and <= 50, not 2000"),
        (f"objects: {{ball: {{{BALL}, random: {{distance: [1, 2], bearing: [0, 1], height: [0, 5000]}}}}}}",
         "3:101", "'height' must be >= -900 and <= 900, not 5000"),
        (f"objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}\nevents: [{{at: 1, move: ball, to: [1.0e+308, 0, 0]}}]",
         "4:35", "'to' must be >= -900 and <= 900"),
        (f"objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}\npercepts: {{ball: {{object: ball, noise: 1.0e+308}}}}",
         "4:40", "'noise' must be >= 0 and <= 10"),
        (f"objects: {{ball: {{{BALL}, position: [0, 0, 1]}}}}\npercepts: {{ball: {{object: ball, range: 10000}}}}",
         "4:40", "'range' must be > 0 and <= 1000, not 10000"),
        ("objects: {one: {shape: person, size: [1.0e-9], position: [0, 0, 1]}}", "3:39", "'size' must be >= 0.0001"),
    ],
)  # fmt: skip
def test_nothing_is_where_the_robot_cannot_look(tmp_path: Path, body: str, place: str, message: str) -> None:
    assert f"scene.yaml:{place}: error: {message}" in problems(tmp_path, body + "\n")


def test_scenes_of_one_name_are_told_apart_by_what_is_in_them(tmp_path: Path) -> None:
    text = "format: 1\nname: mine\nobjects:\n  ball: {shape: ball, size: [8 cm], position: [1, 0, 0.85]}\n"
    digests = []
    for number, change in enumerate((text, text + "# as before\n", text.replace("0.85", "0.95"))):
        file = tmp_path / f"{number}.yaml"
        file.write_text(change)
        digests.append(load_scene(file).digest)
    assert digests[0] == digests[1] != digests[2]
