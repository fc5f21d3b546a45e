"""Published learned walkers on their robots: the same commands as for every other body."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.checking.robot_motion import tried
from humanoid_bt.control.body.policy.learned_body import LearnedBody
from humanoid_bt.control.body.policy.lending import WAIST
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.messages import BaseTarget, GazeTarget, HandTarget, Mode
from humanoid_bt.testing.check_body import check_body
from humanoid_bt.testing.rig import Rig
from tests.control.control_rig import ControlRig
from tests.policies.published import write_robot
from tests.safety.trials import trial

pytest.importorskip("onnxruntime", reason="learned walkers need onnxruntime: pip install 'humanoid-bt[policy]'")
pytestmark = pytest.mark.policy


@pytest.mark.parametrize("algorithm", ["fastsac", "ppo"])
@pytest.mark.parametrize("robot", ["g1", "t1"])
def test_keeps_every_rule_of_a_body(tmp_path: Path, robot: str, algorithm: str) -> None:
    file = write_robot(tmp_path, robot, algorithm)
    check_body(file).assert_passed()
    assert not [found for found in tried(load_robot(file)[0]) if found.severity == "error"]


@pytest.mark.parametrize(("robot", "place"), [("g1", [0.4, -0.1, 0.85]), ("t1", [0.4, -0.1, 0.8])])
def test_a_hand_reaches_as_the_policy_stands(tmp_path: Path, robot: str, place: list[float]) -> None:
    rig = ControlRig(*load_robot(write_robot(tmp_path, robot, "fastsac")))
    rig.run(1, {})
    targets = {"right_hand": HandTarget(np.array(place)), "gaze": GazeTarget(np.array(place))}
    assert rig.run(8, targets, until=lambda state: state.hand_errors["right"] < 0.01)
    rig.run(2, targets)
    assert rig.state.mode is Mode.RUN
    assert rig.state.hand_errors["right"] < 0.01


@pytest.mark.parametrize("aside", [0.0, -0.12])
def test_leans_aside_for_what_is_low(tmp_path: Path, aside: float) -> None:
    """A view that was kept level held the hand back; a trunk that leans fast makes the walker step back."""
    rig = ControlRig(*load_robot(write_robot(tmp_path, "g1", "fastsac")))
    rig.run(1, {})
    place = np.array([0.38, aside, 0.62])
    rig.run(10, {"right_hand": HandTarget(place), "gaze": GazeTarget(place)})
    assert rig.state.hand_errors["right"] < 0.01
    assert rig.state.mode is Mode.RUN


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


def test_approaches_what_it_looks_at_without_dithering_before_it(tmp_path: Path) -> None:
    """Where to stand once followed from where the robot stood: one that slides aside as it turns walked round it."""
    rig = Rig(robot=str(write_robot(tmp_path, "g1", "fastsac")))
    result = rig.run("approach", target=(1.2, -1.0, 1.0), timeout=10)
    assert result.succeeded, result.feedback


@pytest.mark.parametrize("robot", ["g1", "t1"])
def test_what_stays_in_its_way_stops_it_each_time(tmp_path: Path, robot: str) -> None:
    """An arm that was pushed to its stops once was felt to swing to and fro there, and the robot walked on."""
    outcome = trial("... and again, and again", "standing still", 1, str(write_robot(tmp_path, robot, "fastsac")))
    assert outcome.as_told, outcome


def test_its_waist_is_for_hands_that_reach_not_for_arms_that_yield(tmp_path: Path) -> None:
    rig = ControlRig(*load_robot(write_robot(tmp_path, "g1", "fastsac")))
    body = rig.controller.body
    assert isinstance(body, LearnedBody)
    rig.run(1, {})
    rig.plant.push(rig.robot.config.hands["left"].body, np.array([-40.0, 0.0, 0.0]), 0.2)
    lent: list[bool] = []
    rig.run(2.0, {}, cycle=lambda: lent.append(body.lending.lends(WAIST)))
    assert body.lending.lends("left_hand")
    assert not any(lent)
    rig.run(0.1, {"right_hand": HandTarget(np.array([0.4, -0.1, 0.85]))})
    assert body.lending.lends(WAIST)


@pytest.mark.parametrize(("aside", "turned"), [(0.5, 0.0), (1.3, 0.7)])
def test_its_trunk_turns_no_farther_than_a_view_needs(tmp_path: Path, aside: float, turned: float) -> None:
    rig = ControlRig(*load_robot(write_robot(tmp_path, "g1", "fastsac")))
    rig.run(1, {})
    yaw = float(rig.state.stance[2]) + aside
    rig.run(3, {"gaze": GazeTarget(np.array([2 * np.cos(yaw), 2 * np.sin(yaw), 1.0]))})
    waist = rig.robot.joint("waist_yaw_joint")
    assert rig.state.joint_positions[waist] == pytest.approx(turned, abs=0.12)


@pytest.mark.parametrize("aside", [1.9, -2.2])
def test_looking_behind_moves_no_foot(tmp_path: Path, aside: float) -> None:
    """A trunk that was turned by 1.2 rad threw the robot, and from 0.8 rad on the walker steps."""
    rig = ControlRig(*load_robot(write_robot(tmp_path, "g1", "fastsac")))
    rig.run(1, {})
    x, y, yaw = rig.state.stance.tolist()
    rig.run(6, {"gaze": GazeTarget(np.array([x + 2 * np.cos(yaw + aside), y + 2 * np.sin(yaw + aside), 1.0]))})
    assert rig.state.mode is Mode.RUN
    assert np.linalg.norm(rig.state.stance[:2] - [x, y]) < 0.02
