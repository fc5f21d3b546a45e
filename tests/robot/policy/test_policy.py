"""walk.policy.yaml: what it says, what the model's metadata says, and how what does not fit is answered."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.cli import main
from humanoid_bt.core.errors import UserError
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.robot.policy.policy import load_policy, policy_files
from tests.onnx_models import INT64, write_affine
from tests.policy_files import DESCRIPTION, JOINTS, METADATA, write_standing_robot, write_walker

pytest.importorskip("onnxruntime", reason="learned walkers need onnxruntime: pip install 'humanoid-bt[policy]'")


def refused(path: Path) -> list[str]:
    with pytest.raises(UserError) as caught:
        load_policy(path)
    return [str(problem) for problem in caught.value.problems]


def changed(folder: Path, old: str, new: str) -> list[str]:
    assert old in DESCRIPTION
    return refused(write_walker(folder, DESCRIPTION.replace(old, new, 1)))


def test_takes_from_the_metadata_what_the_file_leaves_out(tmp_path: Path) -> None:
    policy = load_policy(write_walker(tmp_path))
    assert policy.joints == JOINTS
    assert policy.stiffness.tolist() == [10, 20, 30]
    assert policy.damping.tolist() == [1, 2, 3], "numbers with commas between them are read as a list"
    assert policy.width == 3 + 2 + 3 + 3
    assert policy.period == 4
    assert policy.ranges.tolist() == [[-1, -0.5, -1], [1, 0.5, 1]]


def test_a_description_can_be_checked_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(write_walker(tmp_path))]) == 0
    bare = write_walker(tmp_path, "format: 1\nmodel: walk.onnx\n")
    capsys.readouterr()
    assert main(["check", str(bare)]) == 2
    assert (
        "'observation' of the policy is missing [missing-key]\n    observation: {terms: ...}" in capsys.readouterr().out
    )


def test_reads_command_ranges_from_the_metadata(tmp_path: Path) -> None:
    path = write_walker(tmp_path, DESCRIPTION.replace("command: {vx: [-1, 1], vy: [-0.5, 0.5], wz: [-1, 1]}\n", ""))
    ranges = {"lin_vel_x": [-0.3, 0.8], "lin_vel_y": [-0.2, 0.2], "ang_vel_yaw": [-0.5, 0.5]}
    write_affine(tmp_path / "walk.onnx", np.zeros((11, 3)), np.zeros(3), {**METADATA, "command_ranges": ranges})
    assert load_policy(path).ranges.tolist() == [[-0.3, -0.2, -0.5], [0.8, 0.2, 0.5]]


def test_numbers_by_patterns_and_for_all(tmp_path: Path) -> None:
    text = DESCRIPTION.replace("default_pose: [0.1, 0.2, 0.3]", 'default_pose: {"*_hip": 10 deg}\nstiffness: 40')
    policy = load_policy(write_walker(tmp_path, text))
    assert policy.default_pose == pytest.approx([np.radians(10), np.radians(10), 0])
    assert policy.stiffness.tolist() == [40, 40, 40]


def test_what_is_added_to_the_answer_is_the_default_pose_unless_it_is_said(tmp_path: Path) -> None:
    assert load_policy(write_walker(tmp_path)).offset.tolist() == [0.1, 0.2, 0.3]
    policy = load_policy(write_walker(tmp_path, DESCRIPTION.replace("clip: 2", "clip: 2, offset: {c_knee: 0.5}")))
    assert policy.offset.tolist() == [0, 0, 0.5]
    assert policy.default_pose.tolist() == [0.1, 0.2, 0.3]


def test_a_wrong_number_of_terms_is_refused_with_the_size_of_each(tmp_path: Path) -> None:
    [message] = refused(write_walker(tmp_path, numbers=12))
    assert "walk.policy.yaml:7:5: error" in message
    assert "the terms have 11 numbers, the model's input 'obs' 12" in message
    assert "base_ang_vel 3, command 2, joint_pos_rel 3, last_action 3" in message
    assert "history" not in message


def test_a_multiple_of_the_terms_is_taken_for_a_history(tmp_path: Path) -> None:
    [message] = refused(write_walker(tmp_path, numbers=55))
    assert "is there a history: 5 of them?" in message


def test_terms_that_have_a_history_are_not_asked_for_one(tmp_path: Path) -> None:
    text = DESCRIPTION.replace("term: command", "term: command, history: 2")
    assert text != DESCRIPTION
    [message] = refused(write_walker(tmp_path, text, numbers=26))
    assert "the terms have 13 numbers, the model's input 'obs' 26" in message
    assert "is there a history" not in message


@pytest.mark.parametrize(
    ("old", "new", "line", "told"),
    [
        ("[0.1, 0.2, 0.3]", "[0.1, 0.2]", 3, "must be 3 numbers, one for each joint, not 2"),
        ("[0.1, 0.2, 0.3]", "{'*_elbow': 1}", 3, "no joint of the policy matches '*_elbow'"),
        ("scale: 0.5", "scale: {metadata: scales}", 4, "the model's metadata has no 'scales'"),
        (
            "scale: 0.5",
            "scale: 0.5, joints: [a_hip]",
            4,
            "it moves 1 joints, the model's output 'action' has 3 numbers",
        ),
        ("[0.1, 0.2, 0.3]", "{'*': 1, '*_hip': 2}", 3, "'*_hip' counts for no joint: earlier ones match all that it"),
        ("format: 1\n", "format: 1\nrate: 30\n", 2, "200 must be a whole multiple of it"),
        ("scale: 0.25", "scale: [1, 2]", 7, "the scale of base_ang_vel must have 3 numbers, not 2"),
        ("{term: joint_pos_rel}", "{term: joint_pos_rel, joints: [knee]}", 9, "no joint of the policy matches 'knee'"),
        ("{term: last_action}", "{term: phase_sin}", 10, "'phase_sin' needs a phase"),
        ("vx: [-1, 1]", "vx: [0.2, 1]", 11, "does not hold 0"),
        ("model: walk.onnx", "model: other.onnx", 2, "the model 'other.onnx' is missing"),
        ("clip: 2", "clip: 2, output: actions", 4, "the model has no output 'actions'"),
        ("  terms:", "  input: observation\n  terms:", 6, "the model has no input 'observation'"),
        ("scale: 0.25}", "clip: [1, -1]}", 7, "base_ang_vel cannot be clipped to [1, -1]"),
        ("scale: 0.25}", "clip: -2}", 7, "base_ang_vel cannot be clipped to -2"),
        ("scale: 0.5,", "scale: 0.5, offset: [1, 2],", 4, "must be 3 numbers, one for each joint, not 2"),
        ("term: joint_pos_rel", "term: joint_pos_rl", 9, "'term' cannot be 'joint_pos_rl'"),
        ("scale: 0.25}", "axes: [vx]}", 7, "'base_ang_vel' has no 'axes' [misplaced-key]\n    only of command"),
        ("scale: 0.25}", "joints: [a_hip]}", 7, "'base_ang_vel' has no 'joints'"),
        ("scale: 0.25}", "value: [1]}", 7, "'base_ang_vel' has no 'value'"),
        ("{term: last_action}", "{term: constant}", 10, "'constant' has no numbers"),
        ("format: 1\n", "format: 1\nphase: {period: 1}\n", 2, "no term observes the phase"),
        ("format: 1\n", "format: 1\nphase: {period: 1, start: []}\n", 2, "the phase begins nowhere"),
        ("format: 1\n", "format: 1\nphase: {period: 1 ms}\n", 2, "a period of 0.001 s is less than 2 answers at 50 Hz"),
        ("command: {", "command: {stand_below: 5, ", 11, "as slow as 'slowest', 0.12, would be one to stand"),
        ("vx: [-1, 1], vy: [-0.5, 0.5]", "vx: [0, 0], vy: [0, 0]", 11, "the ranges of vx and vy are 0"),
        ("vx: [-1, 1], vy: [-0.5, 0.5]", "vx: [0, 0.008], vy: [0, 0]", 11, "slower than 'stand_below', 0.01"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_line(tmp_path: Path, old: str, new: str, line: int, told: str) -> None:
    messages = changed(tmp_path, old, new)
    assert any(told in message and f"walk.policy.yaml:{line}:" in message for message in messages), messages


def test_what_neither_says_is_asked_for(tmp_path: Path) -> None:
    path = write_walker(tmp_path)
    write_affine(tmp_path / "walk.onnx", np.zeros((11, 3)), np.zeros(3), {"dof_names": list(JOINTS), "kd": 1})
    [message] = refused(path)
    assert "there is no 'stiffness', and the model's metadata has none" in message
    assert "it has dof_names, kd" in message


def test_a_memory_must_be_named(tmp_path: Path) -> None:
    messages = refused(write_walker(tmp_path, state=4))
    assert any("the model has 2 inputs: say which" in message for message in messages)
    text = DESCRIPTION + "state: [{input: h_in, output: h_out}]\n"
    policy = load_policy(write_walker(tmp_path, text, state=4))
    assert (policy.input, policy.states) == ("obs", {"h_in": "h_out"})


def test_a_memory_comes_back_as_it_goes_in(tmp_path: Path) -> None:
    text = DESCRIPTION + "state: [{input: h_in, output: h_out}]\n"
    (message,) = refused(write_walker(tmp_path, text, state=4, flat=True))
    assert "the state's input has the shape (1, 4), its output (4,)" in message


@pytest.mark.parametrize(
    ("old", "new", "line", "told"),
    [
        ("  terms:", "  input: h_in\n  terms:", 6, "input 'h_in' is a state's already [policy]\n    free: obs"),
        ("clip: 2", "clip: 2, output: h_out", 4, "the model's output 'h_out' is a state's already"),
        ("state: [", "state: [{input: h_in, output: action}, ", 12, "the model's input 'h_in' is a state's already"),
        ("state: [", "state: [{input: obs, output: h_out}, ", 12, "the model's output 'h_out' is a state's already"),
    ],
)
def test_a_tensor_has_one_use(tmp_path: Path, old: str, new: str, line: int, told: str) -> None:
    text = (DESCRIPTION + "state: [{input: h_in, output: h_out}]\n").replace(old, new)
    messages = refused(write_walker(tmp_path, text, state=4))
    assert any(told in message and f"walk.policy.yaml:{line}:" in message for message in messages), messages


def test_a_file_that_is_no_model_is_refused(tmp_path: Path) -> None:
    path = write_walker(tmp_path)
    (tmp_path / "walk.onnx").write_bytes(b"no model")
    [message] = refused(path)
    assert "not a model that onnxruntime can run" in message
    assert "walk.policy.yaml:2:8" in message


def test_without_onnxruntime_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    [message] = refused(write_walker(tmp_path))
    assert "needs onnxruntime, which is not installed" in message
    assert "pip install 'humanoid-bt[policy]'" in message


def test_a_link_to_nothing_beside_a_model_is_none_of_its_files(tmp_path: Path) -> None:
    path = write_walker(tmp_path)
    (tmp_path / "walk.onnx.data").symlink_to(tmp_path / "not_fetched")
    assert set(policy_files(path)) == {path, tmp_path / "walk.onnx"}
    assert load_policy(path).joints == JOINTS


def test_a_free_batch_is_one(tmp_path: Path) -> None:
    assert load_policy(write_walker(tmp_path, batch="n")).width == 11


@pytest.mark.parametrize("suffix", [".onnx", ".onnx.data"])
def test_a_model_that_was_exported_again_is_loaded_again(tmp_path: Path, suffix: str) -> None:
    path = write_walker(tmp_path)
    changed = (tmp_path / "walk.onnx").with_suffix(suffix)
    if not changed.exists():
        changed.write_bytes(b"weights")
    before = load_policy(path)
    assert load_policy(path) is before
    now = changed.stat().st_mtime_ns
    os.utime(changed, ns=(now + 1_000_000, now + 1_000_000))
    assert load_policy(path) is not before


def test_joints_in_another_order_than_the_metadata_has_them_are_doubtful(tmp_path: Path) -> None:
    names = "joints: [b_hip, a_hip, c_knee]\n"
    [problem] = load_policy(write_walker(tmp_path, DESCRIPTION + names)).warnings
    assert (problem.severity, problem.code) == ("warning", "joint-order")
    assert "walk.policy.yaml:12:9: warning: 'joints' are not as in 'dof_names' of the model's metadata" in str(problem)
    assert not load_policy(write_walker(tmp_path, DESCRIPTION + "joints: [a_hip, b_hip, c_knee]\n")).warnings


RANGES = {"lin_vel_x": [-1, 1], "lin_vel_y": [-1, 1], "ang_vel_yaw": [-1, 1]}


@pytest.mark.parametrize(
    ("known", "told"),
    [
        ({"kp": {"*": "hard"}}, "there must be numbers, not ['hard', 'hard', 'hard'] in 'kp' of the model's metadata"),
        ({"kp": {"*": 1, "a_hip": 2}}, "match all that it matches in 'kp' of the model's metadata"),
        ({"kp": {"*": float("nan")}}, "a number is not finite in 'kp' of the model's metadata"),
        ({"kp": [[1, 2, 3]]}, "must be 3 numbers, one for each joint, not a list of lists of 3 in 'kp'"),
        ({"kp": [1, -2, 3]}, "the stiffness of 'b_hip' is negative"),
        ({"kp": [1, 2]}, "must be 3 numbers, one for each joint, not 2 in 'kp' of the model's metadata"),
        ({"command_ranges": [[-1, 1]] * 3}, "command_ranges of the model's metadata is no mapping, but [[-1, 1]"),
        (
            {"command_ranges": {**RANGES, "lin_vel_y": 1}},
            "(lin_vel_y in command_ranges of the model's metadata) must be",
        ),
        ({"command_ranges": {**RANGES, "lin_vel_y": [-1, 0, 1]}}, "must be two finite numbers, not [-1, 0, 1]"),
        ({"command_ranges": {**RANGES, "lin_vel_y": ["a", "b"]}}, "must be two finite numbers, not [a, b]"),
        ({"command_ranges": {**RANGES, "lin_vel_y": [0, float("inf")]}}, "must be two finite numbers, not [0, inf]"),
        ({"command_ranges": {"lin_vel_x": [-1, 1]}}, "command_ranges of the model's metadata has no 'ang_vel_yaw'"),
    ],
)
def test_what_metadata_says_wrong_is_told_with_its_key(tmp_path: Path, known: dict[str, object], told: str) -> None:
    path = write_walker(tmp_path, DESCRIPTION.replace("command: {vx: [-1, 1], vy: [-0.5, 0.5], wz: [-1, 1]}\n", ""))
    metadata = {**METADATA, "command_ranges": RANGES, **known}
    write_affine(tmp_path / "walk.onnx", np.zeros((11, 3)), np.zeros(3), metadata)
    messages = refused(path)
    assert any("walk.policy.yaml:2:8: " in message and told in message for message in messages), "at the model's line"
    assert len(messages) == len(set(messages))


def test_numbers_of_joints_that_are_not_moved_are_left_out(tmp_path: Path) -> None:
    text = DESCRIPTION.replace("clip: 2", "clip: 2, joints: [c_knee, a_hip]").replace("axes: [wz, vx]", "axes: [wz]")
    path = write_walker(tmp_path, text)
    write_affine(tmp_path / "walk.onnx", np.zeros((9, 2)), np.zeros(2), METADATA)
    policy = load_policy(path)
    assert (policy.stiffness.tolist(), policy.damping.tolist()) == ([30, 10], [3, 1])


@pytest.mark.parametrize(
    ("joints", "chosen"),
    [
        ("[c_knee, b_hip]", ["c_knee", "b_hip"]),
        ('["*_knee", "*_hip"]', ["a_hip", "b_hip", "c_knee"]),
        ('[c_knee, "a_*"]', ["a_hip", "c_knee"]),
    ],
)
def test_names_count_in_their_order_and_patterns_in_that_of_the_policy(
    tmp_path: Path, joints: str, chosen: list[str]
) -> None:
    text = DESCRIPTION.replace("clip: 2", f"clip: 2, joints: {joints}")
    text = text.replace("{term: joint_pos_rel}", f"{{term: joint_pos_rel, joints: {joints}}}")
    count = len(chosen)
    path = write_walker(tmp_path, text)
    write_affine(tmp_path / "walk.onnx", np.zeros((5 + 2 * count, count)), np.zeros(count), METADATA)
    policy = load_policy(path)
    assert [JOINTS[index] for index in policy.moves] == chosen
    assert [JOINTS[index] for index in policy.terms[2].joints] == chosen


def test_numbers_by_patterns_are_of_joints_that_are_moved(tmp_path: Path) -> None:
    text = DESCRIPTION.replace("clip: 2", 'clip: 2, joints: ["*_hip"]') + "stiffness: {a_hip: 1, b_hip: 2, c_knee: 3}\n"
    messages = refused(write_walker(tmp_path, text))
    assert any("12:33: error: no joint that the policy moves matches 'c_knee'" in message for message in messages)


def test_a_size_that_is_left_open_is_told(tmp_path: Path) -> None:
    path = write_walker(tmp_path)
    write_affine(tmp_path / "walk.onnx", np.zeros((11, 3)), np.zeros(3), METADATA, batch="n", numbers="m")
    assert any("how many numbers the model's input 'obs' has is left open" in message for message in refused(path))


def test_an_answer_of_whole_numbers_is_refused(tmp_path: Path) -> None:
    path = write_walker(tmp_path)
    write_affine(tmp_path / "walk.onnx", np.zeros((11, 3)), np.zeros(3), METADATA, answer=INT64)
    [message] = refused(path)
    assert "walk.policy.yaml:2:8: error: the model's output 'action' is a tensor(int64)" in message


@pytest.mark.parametrize(
    ("lend", "message", "hint"),
    [
        (
            "{waist: [waist_yaw, '*_knee']}",
            "'left_knee' is no joint of the waist: it does not carry the torso, 'torso'",
            "those that do: waist_yaw, waist_roll, waist_pitch",
        ),
        (
            "{joints: ['*_elbow', '*_knee']}",
            "no joint of the arms and the neck of robot.yaml matches '*_knee'",
            "the nearest of 16: ",
        ),
        (
            "{joints: ['waist_*']}",
            "no joint of the arms and the neck of robot.yaml matches 'waist_*'",
            "waist: ['waist_*']",
        ),
    ],
)
def test_lends_nothing_that_hands_and_gaze_do_not_move(tmp_path: Path, lend: str, message: str, hint: str) -> None:
    joints = ("waist_yaw", "waist_pitch", "left_knee", "right_knee", "left_elbow")
    path = write_standing_robot(tmp_path, joints, np.zeros(len(joints)))
    with (tmp_path / "stand.policy.yaml").open("a") as description:
        description.write(f"lend: {lend}\n")
    with pytest.raises(UserError) as caught:
        RobotModel(load_robot_config(path))
    (problem,) = caught.value.problems
    assert problem.message == message
    assert problem.hint.startswith(hint)
    assert problem.place is not None
    assert problem.place.file.endswith("stand.policy.yaml")
