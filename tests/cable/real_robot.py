"""A stand-in for a real robot: behind the cable it is one that nobody knows more of than its sensors say.

python -m tests.cable.real_robot PORT
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from humanoid_bt.cable.address import Address
from humanoid_bt.cable.cables import UdpCable
from humanoid_bt.cable.payloads import Hello
from humanoid_bt.cable.server import PlantServer
from humanoid_bt.cable.watchdog import PlantWatchdog
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime.schedule import claim
from humanoid_bt.realtime.served_simulation import ServedSimulation, serve


class RealRobot(ServedSimulation):
    """Tells nothing of the truth, and asks for no scene."""

    def begin(self, hello: Hello) -> str:
        self.description = replace(self.description, simulated=False)
        return super().begin(replace(hello, scene="", digest=""))

    def truth(self) -> None:  # type: ignore[override]  # no truth of a real one
        return None


def main() -> int:
    workspace = Workspace(builtin_root())
    robot, start = load_robot(Path(workspace.find_robot("humanoid")))
    served = RealRobot(robot, start, Scene(load_scene(workspace.find_scene("empty")), 0))
    cable = UdpCable(Address("127.0.0.1", int(sys.argv[1])))
    server = PlantServer(served, cable, PlantWatchdog())
    serve(server, cable, claim().fifo, lambda: False)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
