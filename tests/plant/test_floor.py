"""Floors: level ones, tilted ones on which a robot begins with flat feet, and plates that lie on them."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.messages import SIDES
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.floor import FLOOR, Floor
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig, StartConfig
from humanoid_bt.robot.model import sole_site

STEEP = math.radians(8)


def placed(floor: Floor, heading: float = 0.0, seed: int = 0) -> MujocoPlant:
    robot, start = load_robot(Workspace(builtin_root()).find_robot("humanoid"))
    config = SceneConfig(format=1, name="empty", robot=StartConfig(position=(0.7, -0.4), heading=heading))
    plant = MujocoPlant(robot, Scene(config, seed, floor))
    plant.place(floor.under(start, heading))
    return plant


def geoms(plant: MujocoPlant, prefix: str) -> list[int]:
    return [geom for geom in range(plant.model.ngeom) if plant.model.geom(geom).name.startswith(prefix)]


@pytest.mark.parametrize("uphill", [0.0, 2.0, -1.2])
def test_a_tilted_floor_rises_where_it_says_and_goes_through_the_start(uphill: float) -> None:
    plant = placed(Floor(STEEP, uphill))
    turn, origin = plant.data.geom(FLOOR).xmat.reshape(3, 3), plant.data.geom(FLOOR).xpos
    normal = turn[:, 2]
    assert normal @ (np.array([0.7, -0.4, 0.0]) - origin) == pytest.approx(0.0, abs=1e-12)
    ahead = np.array([math.cos(uphill), math.sin(uphill)])
    assert -normal[:2] @ ahead / normal[2] == pytest.approx(math.tan(STEEP))  # rise per metre there,
    assert -normal[:2] @ [-ahead[1], ahead[0]] == pytest.approx(0.0, abs=1e-12)  # and across


@pytest.mark.parametrize(("uphill", "heading"), [(0.0, 0.0), (2.0, 0.5), (-1.2, -3.0)])
def test_a_robot_begins_with_flat_feet_on_a_tilted_floor(uphill: float, heading: float) -> None:
    plant = placed(Floor(STEEP, uphill), heading)
    turn, origin = plant.data.geom(FLOOR).xmat.reshape(3, 3), plant.data.geom(FLOOR).xpos
    for side in SIDES:
        sole = plant.data.site(sole_site(side))
        assert turn[:, 2] @ (sole.xpos - origin) == pytest.approx(0.0, abs=2e-3)
        assert turn[:, 2] @ sole.xmat.reshape(3, 3)[:, 2] == pytest.approx(1.0, abs=1e-4)
    facing = plant.data.xmat[plant.model.body("pelvis").id].reshape(3, 3)[:2, 0]
    assert math.atan2(facing[1], facing[0]) == pytest.approx(heading, abs=0.02)


def test_plates_lie_flat_on_the_floor_beside_each_other_and_not_under_the_feet() -> None:
    floor = Floor(STEEP, 1.0, plates=0.01)
    plant = placed(floor, heading=0.4)
    plates = geoms(plant, "hbt_plate_")
    assert len(plates) > 50
    turn, origin = plant.data.geom(FLOOR).xmat.reshape(3, 3), np.array([0.7, -0.4, 0.0])
    places = (plant.data.geom_xpos[plates] - origin) @ turn
    np.testing.assert_allclose(places[:, 2], 0.005, atol=1e-12)
    for plate in plates:
        np.testing.assert_allclose(plant.data.geom_xmat[plate].reshape(3, 3)[:, 2], turn[:, 2], atol=1e-12)
    halves = np.linalg.norm(plant.model.geom_size[plates][:, :2], axis=1)
    between = np.linalg.norm(places[:, None, :2] - places[None, :, :2], axis=2) + 9 * np.eye(len(plates))
    assert (between.min(axis=1) > halves).all()
    assert (np.linalg.norm(places[:, :2], axis=1) - halves > 0.3).all()
    touched = {int(geom) for contact in plant.data.contact for geom in contact.geom} & set(plates)
    assert not touched


def test_the_seed_says_where_plates_lie() -> None:
    def places(seed: int) -> np.ndarray:
        plant = placed(Floor(plates=0.01), seed=seed)
        return np.asarray(plant.data.geom_xpos[geoms(plant, "hbt_plate_")])

    np.testing.assert_array_equal(places(3), places(3))
    assert not np.array_equal(places(3)[:20], places(4)[:20])


def test_a_level_floor_without_plates_is_a_plane_and_nothing_else() -> None:
    plant = placed(Floor())
    static = [geom for geom in range(plant.model.ngeom) if plant.model.geom_bodyid[geom] == 0]
    assert [plant.model.geom(geom).type.item() for geom in static] == [mujoco.mjtGeom.mjGEOM_PLANE]
    np.testing.assert_array_equal(plant.data.geom(FLOOR).xmat.reshape(3, 3), np.eye(3))
