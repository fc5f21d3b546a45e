"""A plant behind a simulated cable, on simulated time: both ends in one process, the same every time."""

from __future__ import annotations

import numpy as np

from humanoid_bt.cable.address import PORT, Address
from humanoid_bt.cable.cables import MemoryNetwork
from humanoid_bt.cable.impairment import ImpairedCable, Impairment
from humanoid_bt.cable.payloads import Hello
from humanoid_bt.cable.remote_plant import RemotePlant
from humanoid_bt.cable.server import PlantServer, Served
from humanoid_bt.cable.watchdog import PlantWatchdog
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.messages import JointCommand, Level, Reading

_NANO = round(SERVO_PERIOD * 1e9)  # of a servo period
PLANT = Address("127.0.0.1", PORT)
DRIVER = Address("127.0.0.1", PORT + 1)


class LockstepPlant:
    """A plant that a :class:`~humanoid_bt.cable.remote_plant.RemotePlant` drives; each step is one period of both.

    Args:
        plant: at the far end.
        hello: of the driver.
        impairment: what becomes of frames.
        seed: of jitter and loss.
        key: with which frames are sealed.

    Attributes:
        remote: the near end.
        server: the far end.
        cable: the far end's; it can be pulled.
        network: on which others can reach the plant, too.
        told: what the far end told.
        cycle: servo periods so far.

    Raises:
        UserError: the plant refuses.
    """

    def __init__(
        self,
        plant: Served,
        hello: Hello,
        impairment: Impairment | None = None,
        seed: int = 0,
        key: bytes | None = None,
    ) -> None:
        self._plant, self._hello, self._impairment = plant, hello, impairment or Impairment()
        self._seed, self._key = seed, key
        self.restart()

    def restart(self) -> None:
        """Begin anew, at time 0, with new ends that know nothing of each other, and say hello."""
        self.cycle = 0
        self.network = MemoryNetwork()
        self.told: list[tuple[Level, str]] = []
        random = np.random.default_rng(self._seed)
        self.cable = ImpairedCable(self.network.cable(PLANT), self._impairment, self.now, _NANO, random)
        about = self._plant.description
        self.server = PlantServer(
            self._plant,
            self.cable,
            PlantWatchdog(about.watchdog, about.safe),
            self._key,
            lambda level, text: self.told.append((level, text)),
        )
        self.remote = RemotePlant(self.network.cable(DRIVER), PLANT, self._hello, self._key, self.now)
        self.remote.connect(self.pass_time)

    def now(self) -> int:
        """Return the time [ns]."""
        return self.cycle * _NANO

    def pass_time(self) -> None:
        """Let one servo period pass."""
        self.server.run_cycle()
        self.cable.move()
        self.cycle += 1

    @property
    def fault(self) -> str:
        """Why the plant cannot be relied on now."""
        return self.remote.fault

    def measure(self, into: Reading | None = None) -> Reading:
        """Return what the sensors are known to say."""
        return self.remote.measure(into)

    def step(self, command: JointCommand) -> None:
        """Send a command, and let a period pass."""
        self.remote.step(command)
        self.pass_time()
