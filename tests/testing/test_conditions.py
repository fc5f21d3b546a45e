"""Conditions: what is different from the beginning is felt by the simulated body, or seen, and by nothing else."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import humanoid_bt
from humanoid_bt import Stage, UserError, check
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import SIDES, JointCommand
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.robot.model import sole_site
from humanoid_bt.testing.conditions import Conditions

WALK = Path(humanoid_bt.__file__).with_name("bench") / "walk.yaml"


@pytest.fixture(scope="module")
def plant(stage):
    robot, start = load_robot(stage.workspace.find_robot("humanoid"))
    plant = MujocoPlant(robot, Scene(load_scene(stage.workspace.find_scene("empty")), 0))
    plant.start = start
    return plant


def arrays(model):
    found = {name: getattr(model, name) for name in dir(model) if not name.startswith("_")}
    return {name: value.copy() for name, value in found.items() if isinstance(value, np.ndarray)}


def test_a_plant_that_was_altered_is_as_before_when_it_is_no_more(plant):
    plant.place(plant.start)
    before = arrays(plant.model)
    plant.alter(friction=0.3, payload=5.0, hand_payload=2.0, drives=0.7)
    plant.place(plant.start)
    changed = {name for name, value in arrays(plant.model).items() if not np.array_equal(value, before[name])}
    assert {"geom_friction", "body_mass", "actuator_forcerange"} < changed
    plant.alter()
    plant.place(plant.start)
    for name, value in arrays(plant.model).items():
        np.testing.assert_array_equal(value, before[name], err_msg=name)


def test_drives_that_were_let_go_hold_the_robot_when_it_is_placed_again(plant):
    plant.place(plant.start)
    before, zeros = arrays(plant.model), np.zeros_like(plant.start[7:])
    plant.step(JointCommand(plant.start[7:], zeros, zeros, plant.robot.damping, zeros))
    assert not np.array_equal(plant.model.actuator_biasprm, before["actuator_biasprm"])
    plant.place(plant.start)
    np.testing.assert_array_equal(plant.model.actuator_biasprm, before["actuator_biasprm"])


def test_a_payload_is_carried_by_the_feet(stage):
    def weight(run):
        return sum(run.states[-1].foot_force.values())

    light = stage.run("stand", duration=0.2)
    heavy = stage.run("stand", duration=0.2, conditions={"payload": "4 kg"})
    assert weight(heavy) - weight(light) == pytest.approx(4 * 9.81, rel=0.3)
    assert heavy.report.staged["conditions"] == {"payload": 4.0}
    assert "staged: payload 4 kg" in [event["text"] for event in heavy.report.events]


def test_what_hands_carry_is_carried_by_the_feet(stage):
    def weight(**conditions):
        run = stage.run("stand", duration=0.2, conditions=conditions)
        return sum(run.states[-1].foot_force.values())

    assert weight(hand_payload="2 kg") - weight() == pytest.approx(4 * 9.81, rel=0.3)


def test_commands_that_come_late_are_followed_late(stage):
    def moved(delay):
        run = stage.run("stand", duration=0.3, conditions={"drive_delay": delay})
        return [state.joint_positions.copy() for state in run.states]

    at_once, late = moved("0 s"), moved("60 ms")
    differs = [bool(np.abs(one - other).max() > 1e-12) for one, other in zip(at_once, late, strict=True)]
    assert differs[-1]
    np.testing.assert_array_equal(moved("60 ms"), late)


def test_one_encoder_of_a_leg_is_off_and_the_seed_says_which(stage):
    def off(seed, error):
        run = stage.run("stand", duration=0.02, seed=seed, conditions={"encoder_error": error})
        true = stage.run("stand", duration=0.02, seed=seed)
        return run.states[0].joint_positions - true.states[0].joint_positions

    robot, _ = load_robot(stage.workspace.find_robot("humanoid"))
    joints = [int(np.flatnonzero(off(seed, "0.5 deg")).item()) for seed in range(6)]
    assert len(set(joints)) > 2
    assert all(robot.joint_names[joint].split("_")[1] in ("hip", "knee", "ankle") for joint in joints)
    assert off(3, "-0.5 deg").sum() == pytest.approx(-np.radians(0.5), abs=2e-5)  # what an encoder resolves


def test_the_floor_is_as_steep_as_it_is_to_be(stage):
    steep = stage.run("stand", duration=0.02, conditions={"slope": "4 deg", "uphill": "90 deg"})
    up = rotation_matrix(steep.states[0].base_quaternion)[:, 2]
    level = rotation_matrix(stage.run("stand", duration=0.02).states[0].base_quaternion)[:, 2]
    assert np.degrees(np.arccos(up @ level)) == pytest.approx(4, abs=0.1)
    assert up[1] < -0.06  # away from where the floor rises


@pytest.mark.trials
def test_feet_step_on_plates(stage, monkeypatch):
    heights = []
    step = MujocoPlant.step

    def watched(plant, command):
        step(plant, command)
        heights.append(min(plant.data.site(sole_site(side)).xpos[2].item() for side in SIDES))

    monkeypatch.setattr(MujocoPlant, "step", watched)

    def highest(plates):
        heights.clear()
        stage.run(WALK, parameters={"x": 1.2}, duration=5, conditions={"plates": plates})
        return max(heights)

    assert highest("0 mm") < 0.0055  # m: for a moment, as one foot lands by its heel and the other leaves by its toe
    assert highest("10 mm") > 0.007


def test_each_seed_has_its_own_plates_on_one_stage(stage):
    def places(seed):
        stage.run("stand", duration=0.02, seed=seed, conditions={"plates": "10 mm"})
        return [stage.plant.data.geom(f"hbt_plate_{number}").xpos.copy() for number in range(20)]

    first, other = places(0), places(1)
    assert not np.array_equal(first, other)
    np.testing.assert_array_equal(places(0), first)


def test_drives_give_their_part_of_what_they_are_asked_for_and_of_their_largest(plant):
    robot, joints = plant.robot, plant.start[7:]
    zeros, far = np.zeros_like(joints), np.where(np.arange(len(joints)) % 2, 0.01, 10.0)  # rad from where it stands
    command = JointCommand(joints + far, zeros, robot.stiffness, robot.damping, zeros)

    def torque(drives):
        plant.alter(drives=drives)
        plant.place(plant.start)
        plant.step(command)
        return plant.data.actuator_force.copy()

    whole, half = torque(1.0), torque(0.5)
    plant.alter()
    np.testing.assert_allclose(half, 0.5 * whole)
    whole_of_it = np.minimum(robot.stiffness * far, robot.torque_limit)
    np.testing.assert_allclose(whole, whole_of_it, atol=1.0)  # encoders are a little off


def test_on_ice_a_push_slides_what_else_would_tip(stage):
    push = [{"at": 0.02, "push": {"force": [0, 60, 0], "duration": "0.1 s"}}]

    def slid(friction):
        run = stage.run("stand", duration=0.2, script=push, conditions={"friction": friction})
        return run.states[-1].feet["left"].y - run.states[0].feet["left"].y

    assert slid(1.0) < 0.002
    assert slid(0.02) > 0.005


def test_percepts_are_noisier_by_a_factor_with_the_same_random_numbers(dry):
    def offset(factor):
        run = dry.run("fetch", duration=0.02, seed=5, conditions={"perception_noise": factor})
        return np.array(run.report.percepts["target"]["position_world"]) - [1.9, 0.5, 0.85]

    np.testing.assert_allclose(offset(3.0), 3 * offset(1.0))
    np.testing.assert_allclose(offset(0.0), 0, atol=1e-12)


@pytest.mark.parametrize(
    ("conditions", "message"),
    [
        ({"frict": 1}, "did you mean 'friction'"),
        ("ice", "the conditions must be a mapping, not text"),
        ({"payload": "3 m"}, "'payload' has the unit 'm'"),
        ({"drives": -1}, "'drives' must be >= 0"),
        ({"slope": "4 mm"}, "'slope' has the unit 'mm'"),
        ({"plates": "1 m"}, "'plates' must be .* <= 0.1"),
    ],
)
def test_wrong_conditions_say_what_is_valid(stage, conditions, message):
    with pytest.raises(UserError, match=message):
        stage.run("stand", conditions=conditions)


@pytest.mark.parametrize("condition", ["friction", "hand_payload", "drive_delay", "encoder_error", "slope", "plates"])
def test_a_dry_run_has_no_body_that_could_feel_them(dry, condition):
    with pytest.raises(UserError, match=f"the condition '{condition}' needs a body"):
        dry.run("stand", conditions={condition: 0.05})


def test_hands_carry_nothing_where_there_are_none(stage, tmp_path):
    robot = tmp_path / "sim" / "armless"
    shutil.copytree(stage.workspace.find_robot("humanoid").parent, robot)
    written = (robot / "robot.yaml").read_text()
    hands = written[written.index("hands:") : written.index("gaze:")]
    (robot / "robot.yaml").write_text(written.replace(hands, "").replace("name: humanoid", "name: armless"))
    with pytest.raises(UserError, match="'hand_payload' needs hands, and armless has none"):
        Stage(tmp_path, robot="armless").run("stand", conditions={"hand_payload": 1})
    scenario = tmp_path / "scenarios" / "laden.yaml"
    scenario.parent.mkdir()
    scenario.write_text(
        "format: 1\ntree: stand\nrobot: armless\nconditions: {hand_payload: 1}\nexpect: {never: fell}\n"
    )
    (problem,) = check(scenario, workspace=tmp_path)
    assert "needs hands, and armless has none" in problem.message
    assert str(problem.place).endswith("laden.yaml:4:28")


def test_one_stage_serves_all_conditions_with_one_model(stage):
    own = Stage(scene="empty")
    for friction in (0.5, 0.9, 1.0):
        run = own.run("stand", duration=0.02, conditions={"friction": friction})
    assert run.trace == own.run("stand", duration=0.02).trace
    assert run.time == pytest.approx(20 * SERVO_PERIOD)


UNTRACKED = {
    "another source": ("color_blob", "percepts come from 'color_blob'"),
    "the tracker has nothing left": (["tracker", "color_blob"], "percepts come from 'color_blob'"),
}


@pytest.mark.parametrize(("perception", "why"), UNTRACKED.values(), ids=list(UNTRACKED))
def test_noise_that_nobody_sees_is_refused(stage, tmp_path, perception, why):
    refused = f"'perception_noise' is noise of the simulated tracker, and here {why}"
    with pytest.raises(UserError, match=refused):
        Stage(stage.workspace, perception=perception).run("fetch", conditions={"perception_noise": 2})
    scenario = tmp_path / "scenarios" / "noisy.yaml"
    scenario.parent.mkdir()
    scenario.write_text(
        f"format: 1\ntree: fetch\nperception: {perception}\n"
        "conditions: {perception_noise: 2}\nexpect: {never: fell}\n"
    )
    (problem,) = check(scenario, workspace=tmp_path)
    assert refused in problem.message
    assert str(problem.place).endswith("noisy.yaml:4:32")


def test_noise_of_no_percepts_is_refused(dry):
    with pytest.raises(UserError, match="and here there are no percepts"):
        dry.run("stand", conditions={"perception_noise": 2})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (Conditions(friction=-1), "'friction' must be >= 0 and <= 10, not -1"),
        ({"payload": object()}, "'payload' cannot be <object"),
        ("slope", "the conditions must be a mapping, not text"),
    ],
)
def test_conditions_that_no_file_could_say_are_refused_in_python(given, message):
    with pytest.raises(UserError, match=message):
        Conditions.of(given)


@pytest.mark.parametrize("given", [Conditions(payload="2 kg"), {"payload": np.int64(2)}, {"payload": np.float32(2)}])
def test_conditions_made_in_python_are_those_of_a_file(given):
    assert Conditions.of(given) == Conditions.of({"payload": 2.0})
