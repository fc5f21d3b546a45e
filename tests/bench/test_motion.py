"""What costs are measured beside: the motion of the robot itself, without what surrounds it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from humanoid_bt.bench import figures
from humanoid_bt.bench.control import CommandedRobot
from humanoid_bt.bench.motion import Motion
from humanoid_bt.core.messages import BaseTarget

FAR = {"base": BaseTarget(np.array([100.0, 0.0]), 0.0)}


def test_bare_physics_repeats_the_motion_to_the_bit() -> None:
    robot = CommandedRobot(dict(FAR))
    robot.run(700)
    motion = Motion(robot.plant, lambda: robot.run(500))
    assert motion.time == 0.5
    assert np.abs(robot.plant.data.qvel).max() > 0.5, "it does not walk"
    np.testing.assert_array_equal(motion.repeat(), robot.plant.data.qpos)


def test_the_run_that_only_begins_and_ends_hardly_moves(tmp_path: Path) -> None:
    run = figures._short_run(tmp_path / "short.rrd")
    run.run()
    assert 0 < run.engine.clock.now() < 0.5
