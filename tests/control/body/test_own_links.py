"""Which links are kept apart at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.control.body.own_links import OwnLinks
from humanoid_bt.core.messages import Array
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.robot.config import CapsuleConfig, load_robot_config
from humanoid_bt.robot.model import RobotModel

CONFIG = load_robot_config(Workspace(builtin_root()).find_robot("humanoid"))


def between(body: str, others: Sequence[str], shapes: list[CapsuleConfig]) -> list[Array]:
    """Return how far the shapes of a body are kept from those of each of the others [m].

    Args:
        body, others: their names.
        shapes: given in place of the model's.
    """
    collision = replace(CONFIG.collision, capsules=shapes)
    links = OwnLinks(RobotModel(replace(CONFIG, collision=collision)), near=0.02)
    model = links.model
    bodies = np.array([model.body(one).name for one in model.geom_bodyid.tolist()])
    ours = np.array([model.geom(geom).name.startswith("hbt_") for geom in range(model.ngeom)])
    return [links.margins[np.ix_(ours & (bodies == body), ours & (bodies == other))] for other in others]


def margins(low: float) -> list[Array]:
    """Return how far the torso is kept from the left and the right thigh, as it reaches down on the left to a height.

    Args:
        low: its lowest point, in its own frame [m]; a second shape of it is on the right, and high.
    """
    left = CapsuleConfig(body="torso", start=(0, 0.085, 0.1), end=(0, 0.085, low), radius=0.03)
    right = CapsuleConfig(body="torso", start=(0, -0.085, 0.1), end=(0, -0.085, 0.05), radius=0.03)
    return between("torso", ("left_thigh", "right_thigh"), [left, right])


@pytest.mark.parametrize("low", [-0.35, -0.06], ids=["in each other", "nearer than the margin"])
def test_a_trunk_and_a_hip_that_meet_at_home_are_left_alone_whichever_shapes_meet(low: float) -> None:
    left, right = margins(low)
    assert (left < 0).all()
    assert (right > 0).all()


def test_a_trunk_is_kept_from_legs_that_it_does_not_meet_at_home() -> None:
    left, right = margins(low=0.05)
    assert (left > 0).all() and (right > 0).all()


def test_a_head_that_is_near_the_trunk_at_home_may_nod() -> None:
    under = CapsuleConfig(body="waist_yaw_link", start=(0.01, 0, 0.35), end=(0.01, 0, 0.35), radius=0.02)  # 2 cm
    before = CapsuleConfig(body="waist_yaw_link", start=(0.15, 0, 0.40), end=(0.15, 0, 0.40), radius=0.02)  # 5 cm
    (near,), (far,) = (between("waist_yaw_link", ["head"], shapes) for shapes in ([under, before], [before]))
    assert near.size > far.size > 0
    assert (near < 0).all()
    assert (far > 0).all()
    assert (far < 0.01).all()
