"""A robot's motion, repeated by bare physics: what costs of control and of the whole stack are measured beside."""

from __future__ import annotations

from collections.abc import Callable

import mujoco

from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.messages import Array, JointCommand
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene_model import scene_model


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
        self._start = plant.data.qpos.copy(), plant.data.qvel.copy()
        self._controls: list[Array] = []
        step = plant.step

        def note(command: JointCommand) -> None:
            step(command)
            self._controls.append(plant.data.ctrl.copy())

        plant.step = note  # type: ignore[method-assign]  # note what is commanded
        run()
        plant.step = step  # type: ignore[method-assign]  # as it was
        self.time = len(self._controls) * SERVO_PERIOD

    def repeat(self) -> None:
        """Do it once more."""
        data = mujoco.MjData(self._model)
        data.qpos[:], data.qvel[:] = self._start
        for control in self._controls:
            data.ctrl[:] = control
            mujoco.mj_step(self._model, data)
