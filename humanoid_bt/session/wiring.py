"""The loops below the tree, wired as a run asks for."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.perception.simulated import SimulatedPerception
from humanoid_bt.plant.scene import Scene
from humanoid_bt.realtime.decision_side import Realtime
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.options import RunOptions


def new_engine(options: RunOptions, robot_path: Path, scene: Scene, tree: str) -> Engine:
    """Return control, plant and perception of a run, not yet started.

    Args:
        options: in which mode.
        robot_path: the ``robot.yaml``.
        scene: what surrounds the robot.
        tree: name of the tree, for ``humanoid-bt status``.

    Raises:
        UserError: the robot has mistakes.
    """
    robot, start = load_robot(robot_path)
    if options.mode == "realtime":
        return Realtime(robot, scene, tree, options.hold)
    return Lockstep(robot, start, scene, SimulatedPerception(scene, options.seed))
