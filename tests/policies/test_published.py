"""Published learned walkers on their robots: the same commands as for every other body."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.messages import BaseTarget, GazeTarget, HandTarget, Mode
from humanoid_bt.testing.check_body import check_body
from tests.control.control_rig import ControlRig
from tests.policies.published import write_robot

pytest.importorskip("onnxruntime", reason="learned walkers need onnxruntime: pip install 'humanoid-bt[policy]'")
pytestmark = pytest.mark.policy


@pytest.mark.parametrize("algorithm", ["fastsac", "ppo"])
@pytest.mark.parametrize("robot", ["g1", "t1"])
def test_keeps_every_rule_of_a_body(tmp_path: Path, robot: str, algorithm: str) -> None:
    check_body(write_robot(tmp_path, robot, algorithm)).assert_passed()


@pytest.mark.parametrize(("robot", "place"), [("g1", [0.4, -0.1, 0.85]), ("t1", [0.4, -0.1, 0.8])])
def test_a_hand_reaches_as_the_policy_stands(tmp_path: Path, robot: str, place: list[float]) -> None:
    rig = ControlRig(*load_robot(write_robot(tmp_path, robot, "fastsac")))
    rig.run(1, {})
    targets = {"right_hand": HandTarget(np.array(place)), "gaze": GazeTarget(np.array(place))}
    assert rig.run(8, targets, until=lambda state: state.hand_errors["right"] < 0.01)
    rig.run(2, targets)
    assert rig.state.mode is Mode.RUN
    assert rig.state.hand_errors["right"] < 0.01


def test_withstands_a_push_that_knocks_a_stiff_robot_over(tmp_path: Path) -> None:
    rig = ControlRig(*load_robot(write_robot(tmp_path, "g1", "fastsac")))
    rig.run(1, {})
    rig.plant.push(rig.robot.config.torso, np.array([0.0, 250.0, 0.0]), 0.1)
    rig.run(4, {})
    assert (rig.state.mode, rig.state.base_settled) == (Mode.RUN, True)


@pytest.mark.parametrize("robot", ["g1", "t1"])
def test_knows_how_far_it_has_walked(tmp_path: Path, robot: str) -> None:
    """Soles of these gaits slide as they land and roll as they lift off, and T1's legs share a waist."""
    rig = ControlRig(*load_robot(write_robot(tmp_path, robot, "fastsac")))
    rig.run(1, {})
    rig.run(4, {"base": BaseTarget(np.array([3.0, 0.0]), 0.0)})
    way = rig.plant.data.qpos[:2]
    assert np.linalg.norm(way) > 1.5
    assert np.linalg.norm(rig.state.base_position[:2] - way) < 0.015 * np.linalg.norm(way)
