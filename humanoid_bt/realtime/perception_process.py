"""The perception process: sees what the scene has, at 10 Hz."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

from humanoid_bt.core.clock import PERCEPTION_PERIOD
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.link.wire import Sight, decode_truth, encode_percepts
from humanoid_bt.perception.simulated import SimulatedPerception
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.realtime.schedule import Schedule


def run(folder: RunFolder) -> None:
    """Publish percepts until decision ends the run or dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal's Ctrl-C is for decision
    spec = RunSpec.read(folder)
    perception = SimulatedPerception(Scene(load_scene(Path(spec.scene)), spec.seed), spec.seed)
    truths, percepts = channels.reader(folder, "truth"), channels.writer(folder, "percept")
    quit_flag = channels.quit_flag(folder)
    schedule = Schedule(PERCEPTION_PERIOD, spin=False)
    while not quit_flag.count and os.getppid() == spec.parent:
        schedule.wait()
        latest = truths.latest()
        if latest is not None:
            seen = perception.observe(decode_truth(latest[1]))
            percepts.write(encode_percepts(Sight(seen, perception.unseen)))


if __name__ == "__main__":
    run(channels.open_folder(sys.argv[1]))
