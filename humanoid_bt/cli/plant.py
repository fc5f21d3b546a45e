"""``humanoid-bt plant``: a simulated robot that control in another process drives."""

from __future__ import annotations

import argparse
import signal
import time
from types import FrameType

import numpy as np

from humanoid_bt.cable.address import read_address, read_key
from humanoid_bt.cable.cables import Cable, UdpCable
from humanoid_bt.cable.impairment import ImpairedCable, Impairment
from humanoid_bt.cable.server import PlantServer
from humanoid_bt.cable.watchdog import PlantWatchdog
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.messages import Level
from humanoid_bt.core.texts import one_line
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime.schedule import claim
from humanoid_bt.realtime.served_simulation import LOOKS, ServedSimulation, serve
from humanoid_bt.session.report import ExitCode

_GRAIN = round(SERVO_PERIOD * 1e9) // LOOKS  # ns


def plant(arguments: argparse.Namespace) -> int:
    """Serve a simulated robot until Ctrl-C; return the exit code."""
    address = read_address(arguments.listen)
    key = read_key(address, arguments.key)
    cable: Cable = UdpCable(address)  # before what takes a while: another plant there is told at once
    workspace = Workspace(arguments.workspace)
    robot, start = load_robot(workspace.find_robot(arguments.robot))
    scene = Scene(load_scene(workspace.find_scene(arguments.scene)), seed=0)
    served = ServedSimulation(robot, start, scene, arguments.watchdog, arguments.safe)
    impairment = Impairment(arguments.latency, arguments.jitter, arguments.loss / 100)
    if impairment != Impairment():
        cable = ImpairedCable(cable, impairment, time.monotonic_ns, _GRAIN, np.random.default_rng(arguments.seed))
    while cable.receive():  # whoever called meanwhile has given up, or calls again
        pass
    server = PlantServer(served, cable, PlantWatchdog(arguments.watchdog, arguments.safe), key, _tell)
    over = False

    def end(_number: int, _frame: FrameType | None) -> None:
        nonlocal over
        over = True

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    privileges = claim()
    for warning in privileges.warnings:
        _tell("warning", warning)
    _tell("info", f"{robot.config.name} stands in {scene.config.name} and waits for a driver at {address}")
    try:
        serve(server, cable, privileges.fifo, lambda: over)
    finally:
        server.close()
    return ExitCode.SUCCESS


def _tell(level: Level, text: str) -> None:
    stamp = time.strftime("%H:%M:%S")
    print(f"{stamp} {'' if level == 'info' else level + ': '}{one_line(text)}", flush=True)
