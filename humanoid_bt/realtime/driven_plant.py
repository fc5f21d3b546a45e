"""What control drives in realtime mode, and what it tells besides what sensors say: a simulation here, or a cable."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Protocol

from humanoid_bt.cable.address import read_address, read_key
from humanoid_bt.cable.cables import UdpCable
from humanoid_bt.cable.payloads import MOST_SEED, Hello
from humanoid_bt.cable.remote_plant import RemotePlant
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Array, JointCommand, Level, Reading, Target, Truth
from humanoid_bt.plant.interface import Plant
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.robot.model import RobotModel

_HELLO_PERIOD = 0.02  # s


class DrivenPlant(Plant, Protocol):
    """A plant for a run."""

    @property
    def simulated(self) -> bool:
        """Whether it tells where the robot really is."""

    @property
    def lost(self) -> bool:
        """Whether it cannot be driven any more, for good; its fault says why."""

    def surround(self, targets: Mapping[str, Target]) -> None:
        """Let what surrounds the robot move, once in a decision period.

        Args:
            targets: in force, which tell what the robot is sent to touch.
        """

    def truth(self) -> Truth | None:
        """Return where the robot really is, None if nobody says so, or nobody has since the last time."""

    def take_news(self) -> Sequence[tuple[Level, str]]:
        """Return what happened since the last time, for people."""

    def result(self) -> Mapping[str, Any]:
        """Return what the report says of it in the end."""

    @property
    def cable(self) -> str:
        """What the cable to it was like so far, "" without one."""

    def close(self) -> None:
        """Let go of it."""


class Simulation:
    """A robot in a scene, simulated in this process.

    Args:
        robot: the robot.
        start: configuration to start in, shape (7 + nj,).
        scene: what surrounds it.

    Attributes:
        plant: the simulation.
        fault: "", always.
        simulated: always.
        lost: never.
        cable: "", always.
    """

    fault = cable = ""
    simulated = True
    lost = False

    def __init__(self, robot: RobotModel, start: Array, scene: Scene) -> None:
        self.plant, self._start = MujocoPlant(robot, scene), start
        self.restart()

    def restart(self) -> None:
        """Stand at the start again."""
        self.plant.place(self._start)
        self._told = 0

    def surround(self, targets: Mapping[str, Target]) -> None:
        """Move the scene's things."""
        self.plant.move_objects()
        self.plant.touches.targets = targets

    def measure(self, into: Reading | None = None) -> Reading:
        """Return what the sensors say now."""
        return self.plant.measure(into)

    def step(self, command: JointCommand) -> None:
        """Drive the joints for one servo period."""
        self.plant.step(command)

    def truth(self) -> Truth:
        """Return where the robot really is."""
        return self.plant.truth()

    def take_news(self) -> Sequence[tuple[Level, str]]:
        """Return what the robot has touched since the last time."""
        touches = self.plant.touches.all[self._told :]
        self._told += len(touches)
        return [("info", touch.text) for touch in touches]

    def result(self) -> Mapping[str, Any]:
        """Return the largest external force, and what the robot has touched."""
        self.plant.note_external_force()
        touches = [asdict(touch) for touch in self.plant.touches.all]
        return {"external_force_max": self.plant.external_force_max, "touches": touches}

    def close(self) -> None:
        """Nothing is to be let go of."""


class CablePlant:
    """A plant at the other end of a cable, as a run drives it.

    Args:
        robot: the robot that is expected there.
        scene: that a simulated one is to stand in, with its seed.
        address: where it is.
        key: file with the key; None for none.

    Raises:
        UserError: nobody answers there, or the plant refuses.
    """

    def __init__(self, robot: RobotModel, scene: Scene, address: str, key: Path | None) -> None:
        where = read_address(address)
        if scene.seed > MOST_SEED:
            raise UserError(f"a plant in another process takes seeds up to {MOST_SEED}, not {scene.seed}")
        config = scene.config
        hello = Hello(robot.config.name, tuple(robot.joint_names), config.name, scene.seed, config.digest)
        self._remote = RemotePlant(UdpCable(peer=where), where, hello, read_key(where, key), time.monotonic_ns)
        try:
            self._remote.connect(lambda: time.sleep(_HELLO_PERIOD))
        except UserError:
            self._remote.close()
            raise
        self.step, self.measure, self.surround = self._remote.step, self._remote.measure, self._remote.surround

    @property
    def simulated(self) -> bool:
        """Whether it tells where the robot really is."""
        return self._remote.description is not None and self._remote.description.simulated

    @property
    def fault(self) -> str:
        """Why it cannot be relied on now."""
        return self._remote.fault

    @property
    def lost(self) -> bool:
        """Whether it has let go of this run, or was silent for so long that it has."""
        return self._remote.lost

    def truth(self) -> Truth | None:
        """Return where the robot really is, if the plant has told it since the last time."""
        return self._remote.take_truth()

    def take_news(self) -> Sequence[tuple[Level, str]]:
        """Return what the plant has told."""
        return self._remote.take_news()

    def result(self) -> Mapping[str, Any]:
        """Return the largest external force, and what the robot has touched; nobody knows that of a real one."""
        touches = [asdict(touch) for touch in self._remote.touches]
        return {"external_force_max": self._remote.external_force_max, "touches": touches}

    @property
    def cable(self) -> str:
        """What the cable was like so far."""
        return str(self._remote.figures)

    def close(self) -> None:
        """Leave: the plant goes to its safe state."""
        self._remote.close()
