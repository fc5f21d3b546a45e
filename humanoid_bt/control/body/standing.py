"""Where a robot begins: loaded, and standing with flat feet."""

from __future__ import annotations

import functools
from dataclasses import replace
from pathlib import Path

import mink
import numpy as np

from humanoid_bt.control.body.mink_terms import SOLVER, frame_task, planar_se3, within_soft_limits
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import SIDES, Array
from humanoid_bt.robot.config import RobotConfig, Walk, load_robot_config
from humanoid_bt.robot.files import model_files
from humanoid_bt.robot.model import RobotModel, learned_walker, sole_site
from humanoid_bt.robot.policy.policy import Policy

_TOLERANCE = 0.02  # m and rad


def load_robot(path: Path, walk: Walk | None = None) -> tuple[RobotModel, Array]:
    """Return a robot and the configuration it starts in, shape (7 + nj,); the same one until its files change.

    Args:
        path: its ``robot.yaml``.
        walk: what walks and balances; what ``robot.yaml`` says if None.

    Raises:
        UserError: ``robot.yaml`` or the model is not valid.
    """
    config = _config(path, walk, _version(path))
    return _loaded(path, walk, _version(path, *model_files(config.model_file)), learned_walker(config))


def _version(*files: Path) -> tuple[tuple[int, int], ...]:
    """Return what changes with the files: when each was written, and its size; whoever reads it misses one."""
    return tuple((file.stat().st_mtime_ns, file.stat().st_size) for file in files if file.exists())


@functools.lru_cache(maxsize=4)
def _config(path: Path, walk: Walk | None, _written: tuple[tuple[int, int], ...]) -> RobotConfig:
    config = load_robot_config(path)
    return config if walk is None else replace(config, body=replace(config.body, walk=walk))


@functools.lru_cache(maxsize=4)
def _loaded(
    path: Path, walk: Walk | None, version: tuple[tuple[int, int], ...], _policy: Policy | None
) -> tuple[RobotModel, Array]:
    robot = RobotModel(_config(path, walk, version[:1]))
    return robot, standing_posture(robot)


def standing_posture(robot: RobotModel, steps: int = 200) -> Array:
    """Return the configuration in which the robot starts: feet flat on the ground, the weight over their middle.

    The middle between the feet is the origin, heading along x.

    Returns:
        shape (7 + nj,).

    Raises:
        UserError: the home posture and the numbers of the legs do not let it stand like that.
    """
    config, weights = robot.config, robot.config.whole_body
    model = within_soft_limits(robot)
    configuration = mink.Configuration(model, robot.home_qpos)
    lowest = min(configuration.data.site(sole_site(side)).xpos[2] for side in SIDES)
    lifted = robot.home_qpos.copy()
    lifted[2] -= lowest
    configuration.update(lifted)
    ahead = configuration.data.site(sole_site("left")).xpos[0]
    height = configuration.data.subtree_com[model.body(config.base).id][2]
    com = mink.ComTask(cost=[20.0, 20.0, 20.0])
    com.set_target([ahead, 0.0, height])
    posture = mink.PostureTask(model, cost=0.1)
    posture.set_target(lifted)
    soles = [frame_task(sole_site(side), "site", weights.foot_position, weights.foot_orientation) for side in SIDES]
    for sole, sign in zip(soles, (1.0, -1.0), strict=True):
        sole.set_target(planar_se3(0.0, (ahead, sign * config.gait.stance_width / 2, 0.0)))
    tasks = [com, posture, *soles]
    for body in (config.base, config.torso):
        upright = frame_task(body, "body", 0.0, 5.0)
        upright.set_target(planar_se3(0.0))
        tasks.append(upright)
    limits = [mink.ConfigurationLimit(model)]
    for _ in range(steps):
        velocity = mink.solve_ik(configuration, tasks, 0.01, solver=SOLVER, damping=1e-3, limits=limits)
        configuration.integrate_inplace(velocity, 0.01)
    errors = [com.compute_error(configuration)[:2], *(sole.compute_error(configuration) for sole in soles)]
    if np.abs(np.concatenate(errors)).max() > _TOLERANCE:
        hint = "look at home, gait.stance_width and the soles' bodies and positions"
        message = f"{config.name} cannot stand with flat feet in its home posture"
        raise UserError(message, config.place("home"), hint, code="model")
    qpos: Array = configuration.q.copy()
    qpos[0] -= ahead
    return qpos
