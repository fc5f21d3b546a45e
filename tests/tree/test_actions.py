from __future__ import annotations

from humanoid_bt.errors import HumanoidBtError
from humanoid_bt.messages import Mode
from humanoid_bt.robot import Robot
from humanoid_bt.tree import NodeError
from humanoid_bt.workspace import Workspace
from tests.tree.helpers import Run, run

RAISE = "{raise_emergency_stop: {reason: too warm}}"


def ready(workspace: Workspace, root: str) -> tuple[Run, list[tuple[str, str]]]:
    """Return a tree whose robot has an emergency stop, and what is raised there."""
    tree, raised = run(workspace, root), []
    tree.robot = Robot(tree.robot.config, tree.clock, lambda source, reason: raised.append((source, reason)))
    tree.executor.robot = tree.robot
    tree.executor.setup()
    return tree, raised


def test_it_raises_once_with_its_path_as_the_source(workspace: Workspace) -> None:
    tree, raised = ready(workspace, RAISE)
    tree.tick()
    tree.tick()
    assert raised == [("t/raise_emergency_stop", "too warm")]
    assert tree.executor.status.name == "RUNNING"
    assert tree.feedback("raise_emergency_stop") == "raised the emergency stop: too warm"


def test_it_succeeds_when_the_stop_was_reset_and_raises_again_when_it_is_ticked_again(workspace: Workspace) -> None:
    tree, raised = ready(workspace, RAISE)
    tree.tick()
    tree.tick(mode=Mode.EMERGENCY_STOP, reason="too warm")
    assert tree.executor.status.name == "RUNNING"
    tree.tick()
    assert tree.executor.status.name == "SUCCESS"
    tree.tick()
    assert len(raised) == 2


def test_a_robot_without_an_emergency_stop_is_an_error(workspace: Workspace) -> None:
    tree = run(workspace, RAISE)
    try:
        tree.tick()
    except NodeError as error:
        assert isinstance(error.error, HumanoidBtError)
        assert "of a robot that has none: too warm" in str(error)
    else:
        raise AssertionError("no error")
