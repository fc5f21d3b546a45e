"""MuJoCo's model of a robot standing in a scene."""

from __future__ import annotations

import mujoco

from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.errors import Place, UserError, relative
from humanoid_bt.plant.scene import Scene
from humanoid_bt.robot.model import RobotModel


def scene_model(robot: RobotModel, scene: Scene) -> mujoco.MjModel:
    """Return the model; the robot's coordinates come first.

    Args:
        robot: the robot.
        scene: what surrounds it.

    Raises:
        UserError: robot and scene do not go together.
    """
    spec = robot.spec()
    spec.option.timestep = SERVO_PERIOD
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # a state that blew up must be seen
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # the sparse solver of MuJoCo 4.0.0 converges slowly
    try:
        scene.add_to(spec)
        return spec.compile()
    except ValueError as error:
        where = Place(relative(scene.config.path))
        raise UserError(f"the scene does not compile: {' '.join(str(error).split())}", where, code="model") from error
