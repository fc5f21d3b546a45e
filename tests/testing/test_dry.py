"""Dry runs: no physics, the robot is at once where it is told to be; the supervisor and perception are real."""

from __future__ import annotations

import threading
from dataclasses import fields

import numpy as np
import pytest

from humanoid_bt import Stage, UserError, Workspace, rotation_matrix
from humanoid_bt.core.messages import Mode


def test_the_robot_is_in_the_next_tick_where_it_is_told_to_be(dry):
    run = dry.run("fetch")
    goal = run.commands[0].targets["base"]
    first, second = run.states[:2]
    np.testing.assert_array_equal(first.stance, [0, 0, 0])
    np.testing.assert_array_equal(second.stance, [*goal.position, goal.heading])
    assert not second.stance[:2] @ second.stance[:2] < 1
    for state, command in zip(run.states[1:], run.commands, strict=False):
        if "right_hand" in command.targets:
            np.testing.assert_array_equal(state.hands["right"], command.targets["right_hand"].position)
        looked = command.targets["gaze"].point - state.gaze_position
        np.testing.assert_allclose(state.gaze_direction, looked / np.linalg.norm(looked))


def test_hands_turn_follow_each_other_and_arms_bend_at_once(tmp_path):
    (tmp_path / "skills").mkdir()
    (tmp_path / "skills" / "ask.py").write_text(ASK)
    (tmp_path / "trees").mkdir()
    (tmp_path / "trees" / "ask.yaml").write_text("format: 1\nscene: empty\nroot: {emergency_stop: {ask: {}}}\n")
    run = Stage(workspace=Workspace(tmp_path), dry=True).run("ask")
    assert run.succeeded, run.report
    both, bent = run.states[1], run.states[2]
    frames = {side: rotation_matrix(turn) for side, turn in both.hand_orientations.items()}
    np.testing.assert_allclose(frames["left"], np.eye(3), atol=1e-9)
    np.testing.assert_allclose(both.hands["right"], [0.4, 0.1, 1.2], atol=1e-9)
    np.testing.assert_allclose(frames["right"][:, 2], [0, 0, -1], atol=1e-9)
    assert (both.hand_errors, both.hand_turn_errors) == ({"left": 0, "right": 0}, {"left": 0, "right": 0})
    assert bent.hand_errors == {}
    np.testing.assert_array_equal(bent.hands["right"], run.states[0].hands["right"])
    assert bent.hands["left"][2] > run.states[0].hands["left"][2] + 0.05


ASK = """
import numpy as np

from humanoid_bt import Skill, Status


class Ask(Skill):
    \"\"\"Turn both hands, then bend an arm.\"\"\"

    resources = ("left_hand", "right_hand")

    def initialise(self) -> None:
        self.ticks = 0

    def update(self) -> Status:
        self.ticks += 1
        if self.ticks == 1:
            self.robot.move_hand("left", (0.4, 0.1, 0.9), np.eye(3))
            self.robot.move_hand("right", (0, 0, 0.3), direction=(0, 0, -1), axis="facing", relative=True)
            return self.running("turning")
        if self.ticks == 2:
            palm = self.robot.pose("right_palm")
            assert palm.position.tolist() == [0.4, 0.1, 1.2], palm
            self.robot.move_arm("left", {"left_elbow": -1.8})
            return self.running("bending")
        assert abs(self.robot.arm_joints("left")["left_elbow"].angle + 1.8) < 1e-9
        return self.succeed("bent")
"""


def test_it_stands_as_the_simulated_robot_does(dry, stage):
    one, other = dry.run("stand", duration=0.02).states[0], stage.run("stand", duration=0.02).states[0]
    for name in ("joint_positions", "base_position", "base_quaternion", "com", "stance", "gaze_position"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), atol=5e-3, err_msg=name)
    for side in ("left", "right"):
        np.testing.assert_allclose(one.hands[side], other.hands[side], atol=5e-3)
        assert one.feet[side].x == pytest.approx(other.feet[side].x, abs=5e-3)


def test_it_begins_where_the_scene_says(tmp_path):
    scene = tmp_path / "corner.yaml"
    scene.write_text("format: 1\nname: corner\nrobot: {position: [2, -1], heading: 90 deg}\n")
    state = Stage(scene=str(scene), dry=True).run("stand", duration=0.02).states[0]
    np.testing.assert_allclose(state.stance, [2, -1, np.pi / 2])
    np.testing.assert_allclose(state.gaze_direction[:2] / np.linalg.norm(state.gaze_direction[:2]), [0, 1], atol=1e-6)
    assert state.feet["left"].x < 2 < state.feet["right"].x


def test_it_is_deterministic_and_seeded(dry):
    one = dry.run("fetch", seed=1).trace
    assert dry.run("fetch", seed=1).trace == one != dry.run("fetch", seed=2).trace


def test_another_command_is_another_run_even_if_nothing_has_followed_from_it_yet(dry):
    one, other = (dry.run("fetch", duration=0.01, parameters={"stop_distance": near}) for near in (0.4, 0.35))
    assert len(one.commands) == 1
    assert one.trace != other.trace


def test_a_stopped_robot_does_not_do_what_it_is_told(dry):
    run = dry.run("fetch", script=[{"at": 0, "estop": {}}, {"at": 0.3, "reset": {}}])
    assert run.states[5].mode is Mode.EMERGENCY_STOP
    np.testing.assert_array_equal(run.states[5].stance, [0, 0, 0])
    assert run.succeeded


def test_a_stopped_robot_stays_as_it_is(dry):
    run = dry.run("fetch", script=[{"at": 0.1, "estop": {}}, {"at": 0.3, "reset": {}}])
    at = {round(state.time, 2): state for state in run.states}
    assert at[0.2].mode is Mode.EMERGENCY_STOP
    assert at[0.1].hands["right"][2] > 0.8
    np.testing.assert_array_equal(at[0.28].hands["right"], at[0.1].hands["right"])


def test_states_cannot_be_written_to(dry):
    state = dry.run("fetch").states[-1]
    arrays = [value for field in fields(state) if isinstance(value := getattr(state, field.name), np.ndarray)]
    assert len(arrays) > 10
    assert not any(array.flags.writeable for array in [*arrays, *state.hands.values()])


def test_it_is_never_dry_unless_somebody_asks_for_it(rig, stage):
    assert not stage.dry
    assert stage.run("stand", duration=0.02).report.staged is None
    assert rig.run_tree("stand", duration=0.02).report.staged is None
    assert rig.run_tree("stand", duration=0.02, dry=True).report.staged["dry"]


def test_no_body_can_be_pushed(dry):
    with pytest.raises(UserError, match="'push' needs a body, and a dry run simulates none"):
        dry.run("stand", script=[{"at": 0, "push": {"force": [1, 0, 0]}}])
    with pytest.raises(UserError, match="'weaken' needs a body"):
        dry.run("stand", script=[{"at": 0, "weaken": {"joints": ["*"], "to": 0.5}}])


def test_a_run_starts_no_thread_and_opens_no_file(dry, monkeypatch):
    dry.run("fetch")
    monkeypatch.setattr(threading.Thread, "start", None)
    opened = []
    monkeypatch.setattr("builtins.open", lambda *arguments, **_: opened.append(arguments))
    monkeypatch.setattr("os.open", lambda *arguments, **_: opened.append(arguments))
    assert dry.run("fetch").succeeded
    assert not opened


def test_every_built_in_tree_runs_dry(dry):
    for tree in ("fetch", "stand", "tour"):
        run = dry.run(tree, duration=2)
        assert run.outcome in ("success", "failure", "unfinished"), (tree, run.reason)
