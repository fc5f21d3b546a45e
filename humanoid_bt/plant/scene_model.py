"""MuJoCo's model of a robot standing in a scene."""

from __future__ import annotations

import mujoco

from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.errors import Place, UserError, relative
from humanoid_bt.plant.scene import Scene
from humanoid_bt.robot.model import RobotModel

FLOOR_CONTACTS = "hbt_floor_contacts"
"""Name of the sensor that counts the contacts of the robot with the floor, in a model of physics."""

_FOUND = 1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND)


def scene_model(robot: RobotModel, scene: Scene) -> mujoco.MjModel:
    """Return the model with everything that is drawn; the robot's coordinates come first.

    Args:
        robot: the robot.
        scene: what surrounds it.

    Raises:
        UserError: robot and scene do not go together.
    """
    return _compiled(robot, scene, bare=False)


def physics_model(robot: RobotModel, scene: Scene) -> mujoco.MjModel:
    """Return the model without what is only drawn, and without a search for islands of bodies that touch each other.

    It moves as the whole one does, to the bit, in five sixths of the time; everything but the geoms has the same place
    and number. Arguments and errors are those of :func:`scene_model`.
    """
    return _compiled(robot, scene, bare=True)


def _compiled(robot: RobotModel, scene: Scene, *, bare: bool) -> mujoco.MjModel:
    spec = robot.spec()
    spec.option.timestep = SERVO_PERIOD
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # a state that blew up must be seen
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # the sparse solver of MuJoCo 4.0.0 converges slowly
    try:
        scene.add_to(spec)
        if bare:
            spec.compiler.discardvisual = True
            spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND  # only the robot moves: there is one at most
            _count_floor_contacts(spec, robot.config.base)
        return spec.compile()
    except ValueError as error:
        where = Place(relative(scene.config.path))
        raise UserError(f"the scene does not compile: {' '.join(str(error).split())}", where, code="model") from error


def _count_floor_contacts(spec: mujoco.MjSpec, base: str) -> None:
    spec.add_sensor(
        name=FLOOR_CONTACTS,
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_XBODY,  # with all that it carries
        objname=base,
        reftype=mujoco.mjtObj.mjOBJ_BODY,
        refname="world",
        intprm=[_FOUND, 0, 1],
    )
