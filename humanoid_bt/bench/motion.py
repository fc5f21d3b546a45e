"""A robot's motion, repeated by bare physics: what costs of control and of the whole stack are measured beside."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np

from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.messages import Array, JointCommand
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene_model import scene_model

_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)  # all that the next step depends on


class Motion:
    """What a plant does, to be done once more by ``mj_step`` with the whole model, as MuJoCo reads it.

    Args:
        plant: the plant.
        run: lets it move; the gains of its drives stay as they are.

    Attributes:
        time: how long it moves [s].
    """

    def __init__(self, plant: MujocoPlant, run: Callable[[], object]) -> None:
        self._model = scene_model(plant.robot, plant.scene)
        self._model.actuator_biasprm[:] = plant.model.actuator_biasprm
        self._start: Array = np.empty(mujoco.mj_stateSize(plant.model, _STATE))
        mujoco.mj_getState(plant.model, plant.data, self._start, _STATE)
        self._controls: list[Array] = []
        step = plant.step

        def note(command: JointCommand) -> None:
            step(command)
            self._controls.append(plant.data.ctrl.copy())

        plant.step = note  # type: ignore[method-assign]  # note what is commanded
        run()
        plant.step = step  # type: ignore[method-assign]  # as it was
        self.time = len(self._controls) * SERVO_PERIOD

    def repeat(self) -> Array:
        """Do it once more; return where it ends, MuJoCo's coordinates."""
        data = mujoco.MjData(self._model)
        mujoco.mj_setState(self._model, data, self._start, _STATE)
        for control in self._controls:
            data.ctrl[:] = control
            mujoco.mj_step(self._model, data)
        return np.array(data.qpos)
