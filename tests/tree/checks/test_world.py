"""Whether a tree goes with its robot and its scene."""

from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.tree.nodes import EmergencyStop, Watchdog
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.source.compose import make_tree
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.tree import Tree
from tests.tree.helpers import found, load
from tests.tree.source.test_load import one


@pytest.fixture
def handless(workspace: Workspace) -> Workspace:
    """A workspace with a robot without hands."""
    folder, humanoid = workspace.root / "sim" / "handless", builtin_root() / "sim" / "humanoid"
    folder.mkdir(parents=True)
    lines = (humanoid / "robot.yaml").read_text().splitlines(keepends=True)
    start = next(index for index, line in enumerate(lines) if line.startswith("hands:"))
    end = next(index for index, line in enumerate(lines) if index > start and line[0] not in " #\n")
    text = "".join([*lines[:start], *lines[end:]]).replace("name: humanoid", "name: handless")
    (folder / "robot.yaml").write_text(text)
    (folder / "humanoid.xml").write_text((humanoid / "humanoid.xml").read_text())
    return workspace


def tree(skill: str, header: str = "robot: handless") -> str:
    return f"{header}\nroot: {{emergency_stop: {{watchdog: {{percept: target, max_age: 1, {skill}}}}}}}"


def test_a_robot_must_have_what_its_tree_commands(handless: Workspace) -> None:
    message, hint = one(handless, tree("reach: {target: target, hand: left}"))
    assert message == "3:65 'reach' commands left_hand: the robot 'handless' has none"
    assert hint == "it has: base, gaze, posture"
    load(handless, tree("idle: "))
    load(handless, tree("reach: {target: target}", "robot: humanoid"))
    load(handless, tree("reach: {target: target}", ""))


def test_names_of_robots_and_scenes_are_looked_up(workspace: Workspace) -> None:
    text = "robot: humanod\nscene: ball\nroot: idel"
    assert [line.split(" ", 2)[:2] for line in found(workspace, text)] == [
        ["2:8", "unknown-robot"],
        ["3:8", "unknown-scene"],
        ["4:7", "unknown-node"],
    ]
    _, hint = one(workspace, "robot: humanod\nroot: act")
    assert hint.startswith("did you mean 'humanoid'?")


def test_a_percept_that_is_only_told_must_be_there_too(workspace: Workspace) -> None:
    head = "scene: ball_on_stand\n"
    (line,) = found(workspace, head + "root: {log: 'the ball is {distance(taget)} away'}")
    assert line == "3:13 unknown-percept the scene 'ball_on_stand' does not publish the percept 'taget'"
    assert not found(workspace, head + "root: {log: 'the ball is {distance(target)} away'}")


def test_a_percept_that_is_a_parameter_without_a_value_is_not_known(workspace: Workspace) -> None:
    head = "subtree: true\nscene: ball_on_stand\n"
    assert not found(workspace, head + "parameters: {p: {type: percept}}\nroot: {condition: seen(p)}")
    assert found(workspace, head + "parameters: {p: ball}\nroot: {condition: seen(p)}", "unknown-percept")


def test_a_percept_that_the_scene_does_not_publish_is_told_once(workspace: Workspace) -> None:
    text = tree("idle: ", "scene: ball_on_stand").replace("target", "taget")
    (warning,) = load(workspace, text).warnings
    assert (warning.code, warning.severity) == ("unknown-percept", "warning")
    assert warning.message == "the scene 'ball_on_stand' does not publish the percept 'taget'"
    assert warning.hint == "did you mean 'target'? valid: target"
    (warning,) = load(workspace, tree("reach: {target: target}", "scene: empty")).warnings
    assert warning.hint == "this scene publishes none; used in 1 more place"
    assert not load(workspace, tree("reach: {target: target}", "scene: ball_on_stand")).warnings


def test_a_percept_that_a_sub_tree_is_given_is_told_where_it_is_given(workspace: Workspace) -> None:
    path = workspace.root / "trees" / "touch.yaml"
    path.write_text("format: 1\nsubtree: true\nparameters: {it: {type: percept}}\nroot: {reach: {target: $it}}\n")
    text = tree("subtree: {tree: touch, it: taget}", "scene: ball_on_stand").replace(
        "percept: target", "percept: taget"
    )
    (warning,) = load(workspace, text).warnings
    assert warning.place is not None and warning.place.file.endswith("t.yaml")
    assert warning.hint.endswith("used in 1 more place")


def given(workspace: Workspace, text: str, robot: str | None = None, scene: str | None = None) -> Tree:
    path = workspace.root / "trees" / "t.yaml"
    path.write_text(f"format: 1\n{text}")
    return load_tree(path, workspace, robot=robot, scene=scene)


def test_what_is_run_counts_and_not_what_the_header_names(handless: Workspace) -> None:
    text = tree("reach: {target: target}", "robot: nobody\nscene: nowhere")
    assert not given(handless, text, "humanoid", "ball_on_stand").warnings
    with pytest.raises(UserError, match="the robot 'handless' has none"):
        given(handless, text, "handless", "ball_on_stand")
    with pytest.raises(
        UserError, match=r"robot=humanod: error: no robot named 'humanod' \[unknown-robot\]\n.*did you mean 'humanoid'"
    ):
        given(handless, text, "humanod", "ball_on_stand")


def test_a_robot_with_mistakes_is_one_mistake_of_its_tree(workspace: Workspace) -> None:
    folder = workspace.root / "sim" / "broken"
    folder.mkdir(parents=True)
    (folder / "robot.yaml").write_text("format: 1\nname: broken\n")
    with pytest.raises(UserError, match=r"robot.yaml:1:1: error: the key 'model' of the robot is missing"):
        load(workspace, "robot: broken\nroot: act")


@pytest.mark.parametrize("name", ['""', '"\\0"', "sim", "x" * 5000])
def test_a_name_that_can_be_none_is_a_mistake(workspace: Workspace, name: str) -> None:
    assert [line.split()[1] for line in found(workspace, f"scene: {name}\nroot: act")] == ["unknown-scene"]


def test_a_tree_made_in_python_is_checked_for_its_robot(handless: Workspace) -> None:
    reach = Registry.of(handless)["reach"].cls(name="reach", target="p")
    root = EmergencyStop("stop", Watchdog("dog", reach, percept="p", max_age=1.0))
    with pytest.raises(UserError, match="the robot 'handless' has none"):
        make_tree(root, handless, robot="handless")
    with pytest.raises(UserError, match="no scene named 'nowhere'"):
        make_tree(root, handless, scene="nowhere")


def test_an_edited_robot_is_read_again(handless: Workspace) -> None:
    text = tree("reach: {target: target}")
    assert found(handless, text)
    folder = handless.root / "sim" / "handless"
    (folder / "robot.yaml").write_text((builtin_root() / "sim" / "humanoid" / "robot.yaml").read_text())
    assert not found(handless, text)


def test_the_built_in_trees_have_no_warnings() -> None:
    workspace = Workspace(builtin_root())
    for name, path in workspace.trees().items():
        warnings = load_tree(path, workspace).warnings
        assert [warning for warning in warnings if not allowed(path, warning.place)] == [], name


def allowed(path: Path, place: object) -> bool:
    return "# allow " in path.read_text().splitlines()[getattr(place, "line", 1) - 1]
