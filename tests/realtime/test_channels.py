"""Whatever robot, scene and tree are called, what their processes say fits into the channels."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.core.messages import RESOURCES, Command, HandTarget, Percept
from humanoid_bt.link import wire
from humanoid_bt.link.run_folder import RunFolder, RunInfo
from humanoid_bt.link.wire import Sight
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.timing import StopRecord
from humanoid_bt.session.options import Mode
from humanoid_bt.session.session import Session
from tests.tree.helpers import make_state

PATHS = dict.fromkeys(RESOURCES, "t/" + "ö" * 70_000 + "/reach")
PERCEPTS = [f"percept {number} {'ö' * 100}" for number in range(400)]
JOINTS = [f"joint {number}" for number in range(300)]


def test_the_longest_messages_fit_their_slots(tmp_path: Path) -> None:
    joints = np.zeros(len(JOINTS))
    state = replace(
        make_state(1.0),
        joint_positions=joints,
        joint_velocities=joints,
        joint_torques=joints,
        setpoint_positions=joints,
        setpoint_velocities=joints,
        limit_flags=tuple(JOINTS),
        command_sources=PATHS,
        stop_reason="r" * 5000,
        stop_source="s" * 5000,
    )
    command = Command(0, 0.0, {"left_hand": HandTarget(np.zeros(3))}, PATHS)
    event = wire.encode_event(wire.Event(1.0, "error", "ö" * 5000))
    sources = wire.decode_command(wire.encode_command(command)).sources
    messages = [
        ("command", wire.encode_command(command)),
        ("state", wire.encode_state(state)),
        ("notice", event),
        ("request", event),
        ("percept", wire.encode_percepts(Sight([Percept(name, 1.0, np.zeros(3), 1.0) for name in PERCEPTS], {}))),
        ("percept", wire.encode_percepts(Sight([], dict.fromkeys(PERCEPTS, "w" * 5000)))),
        ("stop", StopRecord(1, 1.0, "damp", "\0" * 5000, "\0" * 5000, sources).to_bytes()),
    ]
    with RunFolder.create(RunInfo("t", "r"), tmp_path / "runs") as folder:
        channels.create_channels(folder, state=wire.state_room(JOINTS), percept=wire.percepts_room(PERCEPTS))
        for name, message in messages:
            ring = channels.writer(folder, name)
            ring.write(message)
            ring.close()
    assert sources["base"].startswith("t/öö") and "/.../" in sources["base"] and sources["base"].endswith("ö/reach")


SCENE = "format: 1\nname: crowd\nobjects: {ball: {shape: ball, size: [8 cm], position: [0.7, 0.05, 0.85]}}\npercepts:\n"
TREE = """
format: 1
scene: crowd
root:
  emergency_stop:
    watchdog:
      percept: p399
      max_age: 1 s
      timeout:
        duration: 0.3 s
        look_at: {target: p399, name: NAME}
"""


@pytest.mark.trials
@pytest.mark.realtime
def test_both_modes_take_long_names_and_many_percepts(tmp_path: Path) -> None:
    (tmp_path / "sim" / "scenes").mkdir(parents=True)
    percepts = "".join(f"  p{number}: {{object: ball}}\n" for number in range(400))
    (tmp_path / "sim" / "scenes" / "crowd.yaml").write_text(SCENE + percepts, encoding="utf-8")
    tree = tmp_path / "long.yaml"
    tree.write_text(TREE.replace("NAME", "n" * 7474), encoding="utf-8")
    modes: tuple[Mode, ...] = ("lockstep", "realtime")
    outcomes = {}
    for mode in modes:
        report = Session(tree, workspace=tmp_path, mode=mode, duration=20).run()
        outcomes[mode] = report.outcome
        assert report.outcome in ("success", "failure"), report.reason
        assert len(report.percepts) == 400
    assert outcomes["lockstep"] == outcomes["realtime"]
