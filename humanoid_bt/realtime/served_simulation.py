"""The simulated robot behind a cable: one that begins anew for every driver, and the loop that serves it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from humanoid_bt.cable.cables import Cable
from humanoid_bt.cable.impairment import ImpairedCable
from humanoid_bt.cable.payloads import Description, Hello, Simulated
from humanoid_bt.cable.safe_state import WATCHDOG, SafeState
from humanoid_bt.cable.server import PlantServer
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Array, JointCommand, Level, Reading, Target
from humanoid_bt.plant.scene import Scene
from humanoid_bt.realtime.driven_plant import Simulation
from humanoid_bt.realtime.schedule import Schedule
from humanoid_bt.robot import mujoco_warnings
from humanoid_bt.robot.model import RobotModel

LOOKS = 4
"""Times in a servo period that a cable which delays frames is looked at."""


class ServedSimulation:
    """A robot in a scene, as a driver at the other end of a cable sees it.

    Args:
        robot: the robot.
        start: configuration to start in, shape (7 + nj,).
        scene: what surrounds it; each driver says of which seed.
        watchdog: silence after which it goes to its safe state [s].
        safe: which one.

    Attributes:
        fault: "", always.
        description: what it is.
    """

    fault = ""

    def __init__(
        self, robot: RobotModel, start: Array, scene: Scene, watchdog: float = WATCHDOG, safe: SafeState = "hold"
    ) -> None:
        self._robot, self._start, self._scene = robot, start, scene
        self._simulation = Simulation(robot, start, scene)
        names = tuple(robot.joint_names)
        self.description = Description(robot.config.name, names, True, safe, watchdog, SERVO_PERIOD)

    @property
    def simulation(self) -> Simulation:
        """The one of the last driver."""
        return self._simulation

    def begin(self, hello: Hello) -> str:
        """Stand in the scene as it was in the beginning, as the driver's seed has it."""
        config = self._scene.config
        if hello.scene not in ("", config.name):
            return f"this plant stands in the scene {config.name!r}, not {hello.scene!r}"
        if hello.digest not in ("", config.digest):
            return f"the scene {config.name!r} of this plant is not that of the run: its file says something else"
        try:
            if hello.seed == self._scene.seed:
                self._simulation.restart()
            else:
                self._scene = Scene(config, hello.seed)
                self._simulation = Simulation(self._robot, self._start, self._scene)
        except UserError as error:
            return str(error)
        return ""

    def measure(self, into: Reading | None = None) -> Reading:
        """Return what the sensors say now."""
        return self._simulation.measure(into)

    def step(self, command: JointCommand) -> None:
        """Drive the joints for one servo period."""
        self._simulation.step(command)

    def surround(self, targets: Mapping[str, Target]) -> None:
        """Move the scene's things; the targets tell what the robot is sent to touch."""
        self._simulation.surround(targets)

    def truth(self) -> Simulated:
        """Return where the robot really is, the largest external force so far, and what it has touched."""
        plant = self._simulation.plant
        plant.note_external_force()
        return Simulated(plant.truth(), plant.external_force_max, plant.touches.all)

    def take_news(self) -> Sequence[tuple[Level, str]]:
        """Return what the robot has touched, and what the simulator warns of."""
        warnings: list[tuple[Level, str]] = [("warning", text) for text in mujoco_warnings.taken()]
        return [*self._simulation.take_news(), *warnings]


def serve(server: PlantServer, cable: Cable, fifo: bool, ended: Callable[[], bool]) -> None:
    """Serve a plant on the wall clock, one servo cycle a millisecond.

    Args:
        server: of the plant.
        cable: its cable.
        fifo: whether the process has realtime priority.
        ended: is asked in every cycle whether it is over.
    """
    looks = LOOKS if isinstance(cable, ImpairedCable) else 1
    schedule = Schedule(SERVO_PERIOD / looks, spin=fifo and looks == 1)
    while not ended():
        for _ in range(looks - 1):
            schedule.wait()
            if isinstance(cable, ImpairedCable):
                cable.move()
        schedule.wait()
        server.run_cycle()
