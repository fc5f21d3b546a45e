"""What simulated eyes do not see, and how far they see things that are large."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.perception.simulated import SimulatedPerception
from tests.perception.test_simulated import EXACT, LEAVES, robot, scene, solid, watch


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
