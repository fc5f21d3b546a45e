"""The same tree does the same in lockstep and in realtime mode."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.common import Status

from humanoid_bt.session.listener import Listener
from humanoid_bt.session.options import Mode
from humanoid_bt.session.session import Session
from humanoid_bt.tree.ticking.executor import NodeChange

NEAR = """
format: 1
name: near
objects:
  ball: {shape: ball, size: [8 cm], color: orange, position: [0.7, 0.05, 0.85]}
percepts:
  target: {object: ball}
"""


class Skills(Listener):
    """Notes which skills started and how they ended, in order."""

    def __init__(self) -> None:
        self.told: list[tuple[str, Status]] = []

    def node_changed(self, change: NodeChange) -> None:
        name = change.path.rsplit("/", 1)[-1]
        if name in ("approach", "reach", "idle") and change.status is not Status.INVALID:
            self.told.append((name, change.status))


@pytest.mark.trials
@pytest.mark.realtime
def test_the_same_tree_gives_the_same_sequence_of_skills(tmp_path: Path) -> None:
    (tmp_path / "sim" / "scenes").mkdir(parents=True)
    (tmp_path / "sim" / "scenes" / "near.yaml").write_text(NEAR, encoding="utf-8")
    told: dict[Mode, list[tuple[str, Status]]] = {}
    modes: tuple[Mode, ...] = ("lockstep", "realtime")
    for mode in modes:
        skills = Skills()
        report = Session("fetch", workspace=tmp_path, scene="near", mode=mode, duration=30, listener=skills).run()
        assert (report.outcome, report.fell, report.external_force_max) == ("success", False, 0.0), report.reason
        told[mode] = skills.told
    assert told["lockstep"] == told["realtime"]
    assert [name for name, status in told["lockstep"] if status is Status.SUCCESS] == ["approach", "reach"]


HIDDEN = """
format: 1
name: hidden
objects: {ball: {shape: ball, size: [8 cm], position: [0.7, 0.05, 0.85]}}
percepts: {target: {object: ball}}
events: [{at: 0, hide: ball}]
"""

WATCHED = """
format: 1
scene: hidden
root: {emergency_stop: {watchdog: {percept: target, max_age: 0.5 s, on_stale: idle, reach: {target: target}}}}
"""


@pytest.mark.realtime
@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_a_percept_that_was_never_seen_says_why(tmp_path: Path, mode: Mode) -> None:
    for folder, name, text in (("sim/scenes", "hidden", HIDDEN), ("trees", "watched", WATCHED)):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    with Session("watched", workspace=tmp_path, mode=mode) as session:
        session.run_until(0.5)
        assert session.node("watchdog").feedback == "'target' was never seen: hidden"
    assert session.report.unseen == {"target": "hidden"}
