"""What of the scene the robot touches, as contacts come and go."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import HandTarget
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import load_scene
from humanoid_bt.plant.scene_model import FLOOR_CONTACTS
from humanoid_bt.plant.touches import Touches
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel

SIM = Path(__file__).resolve().parents[2] / "sim"
SCENE = """\
format: 1
name: wall
objects:
  wall: {shape: box, size: [0.2, 1.0, 1.0], position: [1.0, 0.0, 0.5], solid: true}
"""
AWAY = np.array([9.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def plant(tmp_path_factory: pytest.TempPathFactory) -> MujocoPlant:
    file = tmp_path_factory.mktemp("scenes") / "wall.yaml"
    file.write_text(SCENE)
    return MujocoPlant(RobotModel(load_robot_config(SIM / "humanoid" / "robot.yaml")), Scene(load_scene(file), 0))


@pytest.fixture
def touches(plant: MujocoPlant) -> Touches:
    touches = Touches(plant.model, plant.robot.config)
    assert touches.possible
    touches.note(contacts(plant, "world"), 0.0)
    assert not touches.all
    return touches


def contacts(plant: MujocoPlant, *bodies: str) -> Any:
    """Return what physics says when a hand touches these."""
    geom = {plant.model.body(int(body)).name: number for number, body in enumerate(plant.model.geom_bodyid)}
    hand = geom[plant.robot.config.hands["left"].body]
    pairs = np.array([[geom[body], hand] for body in bodies], dtype=np.int32).reshape(-1, 2)
    contact = SimpleNamespace(geom=pairs, pos=np.zeros((len(pairs), 3)))
    sites = plant.model.nsite
    turned = np.tile(np.eye(3).ravel(), (sites, 1))
    told = np.zeros(plant.model.nsensordata)
    told[plant.model.sensor(FLOOR_CONTACTS).adr] = bodies.count("world")
    places = np.zeros((sites, 3))
    return SimpleNamespace(ncon=len(pairs), contact=contact, site_xpos=places, site_xmat=turned, sensordata=told)


def test_a_touch_besides_the_other_contacts_is_noticed_at_once(plant: MujocoPlant, touches: Touches) -> None:
    touches.note(contacts(plant, "world", "object_wall"), 0.001)
    assert [touch.text for touch in touches.all] == ["left hand touches wall"]


def test_a_touch_in_the_place_of_another_contact_is_noticed_at_once(plant: MujocoPlant, touches: Touches) -> None:
    touches.note(contacts(plant, "object_wall"), 0.001)
    assert [touch.thing for touch in touches.all] == ["wall"]


def test_after_it_was_placed_anew_a_touch_is_noticed_at_once(plant: MujocoPlant, touches: Touches) -> None:
    touches.clear()
    touches.note(contacts(plant, "object_wall"), 0.0)
    assert [touch.thing for touch in touches.all] == ["wall"]


def robot_with(link: str, folder: Path) -> RobotModel:
    """Return the built-in robot with another name of a link."""
    for file in ("robot.yaml", "humanoid.xml"):
        text = (SIM / "humanoid" / file).read_text()
        (folder / file).write_text(text.replace("waist_roll_link", link))
    return RobotModel(load_robot_config(folder / "robot.yaml"))


def test_a_link_is_no_thing_whatever_its_name_is(tmp_path: Path) -> None:
    empty = Scene(load_scene(SIM / "scenes" / "empty.yaml"), 0)
    assert not MujocoPlant(robot_with("stand_link", tmp_path), empty).touches.possible


def test_a_link_cannot_have_the_name_of_a_thing(plant: MujocoPlant, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"wall\.yaml: error: the scene does not compile: .* 'object_wall' in body"):
        MujocoPlant(robot_with("object_wall", tmp_path), plant.scene)


def test_a_hand_still_touches_what_it_was_sent_to_until_they_part(plant: MujocoPlant, touches: Touches) -> None:
    touches.targets = {"left_hand": HandTarget(AWAY, press=10.0)}
    touches.note(contacts(plant, "world", "object_wall"), 0.0)
    touches.targets = {"left_hand": HandTarget(AWAY)}
    for moment in range(1, 1000):
        touches.note(contacts(plant, *(() if moment % 50 else ("object_wall",))), 0.001 * moment)  # it bounces
    assert [touch.meant for touch in touches.all] == [True]
    touches.note(contacts(plant, "object_wall"), 2.0)
    assert [touch.meant for touch in touches.all] == [True, False]


@pytest.mark.parametrize(("distance", "meant"), [(0.05, True), (0.5, False)])
def test_a_hand_that_is_led_by_the_other_is_sent_somewhere_too(
    plant: MujocoPlant, touches: Touches, distance: float, meant: bool
) -> None:
    led = HandTarget(np.array([0.0, 0.0, distance]), relative=True)
    touches.targets = {"right_hand": HandTarget(AWAY), "left_hand": led}
    touches.note(contacts(plant, "world", "object_wall"), 0.0)
    assert [touch.meant for touch in touches.all] == [meant]


def test_nothing_is_known_of_the_touches_before_it_was_placed_anew(plant: MujocoPlant, touches: Touches) -> None:
    touches.targets = {"left_hand": HandTarget(AWAY, press=10.0)}
    touches.note(contacts(plant, "object_wall"), 0.05)
    for _ in range(2):
        touches.clear()
        assert not touches.all
        touches.note(contacts(plant, "object_wall"), 0.0)
        assert [touch.meant for touch in touches.all] == [False]


def test_it_does_not_matter_which_one_of_a_contact_comes_first(plant: MujocoPlant, touches: Touches) -> None:
    found = contacts(plant, "object_wall")
    found.contact.geom = found.contact.geom[:, ::-1]
    touches.note(found, 0.0)
    assert [touch.text for touch in touches.all] == ["left hand touches wall"]


def test_what_a_hand_carries_is_the_hand(plant: MujocoPlant) -> None:
    config = plant.robot.config
    left = config.hands["left"]
    wrist = plant.model.body(int(plant.model.body(left.body).parentid[0])).name
    touches = Touches(plant.model, replace(config, hands={"left": replace(left, body=wrist)}))
    touches.targets = {"left_hand": HandTarget(AWAY, press=10.0)}
    touches.note(contacts(plant, "object_wall"), 0.0)
    assert [(touch.link, touch.meant) for touch in touches.all] == [(left.body, True)]


def test_placing_the_robot_anew_forgets_what_it_touched(plant: MujocoPlant) -> None:
    plant.touches.note(contacts(plant, "object_wall"), 0.0)
    assert plant.touches.all
    plant.place(plant.robot.home_qpos)
    assert not plant.touches.all
