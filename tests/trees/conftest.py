"""A project with small trees that use the library, run on the built-in humanoid."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.session.helpers import Ran, ran

SKILLS = '''
"""Skills that fail as they are told to."""

from humanoid_bt.core.params import param
from humanoid_bt.decision.skill import Skill, Status


class Stumble(Skill):
    """Fail some times, then succeed."""

    times: int = param(1, doc="How often it fails.")
    failed = 0

    def update(self) -> Status:
        self.failed += 1
        return self.fail("not yet") if self.failed <= self.times else self.succeed("at last")
'''

BALL_BEHIND = """
format: 1
name: ball_behind
robot: {position: [0, 0], heading: 0 deg}
objects: {ball: {shape: ball, size: [8 cm], position: [-1.2, -0.9, 0.85], stand: true}}
percepts: {target: {object: ball}}
"""

BALL_STRAIGHT_BEHIND = """
format: 1
name: ball_straight_behind
objects: {ball: {shape: ball, size: [8 cm], position: [-1.0, 0, 0.6], stand: true}}
percepts: {target: {object: ball}}
"""

VISITOR_AHEAD = """
format: 1
name: visitor_ahead
robot: {position: [0, 0], heading: 0 deg}
objects: {visitor: {shape: cylinder, size: [35 cm, 1.7 m], position: [0.9, 0.15, 0.85]}}
percepts: {person: {object: visitor}}
"""

TWO_BALLS = """
format: 1
name: two_balls
robot: {position: [0, 0], heading: 0 deg}
objects:
  left: {shape: ball, size: [8 cm], position: [0.42, 0.18, 0.95]}
  right: {shape: ball, size: [8 cm], position: [0.42, -0.18, 0.95]}
percepts: {left: {object: left}, right: {object: right}}
"""

SCENES = {
    "ball_behind": BALL_BEHIND,
    "ball_straight_behind": BALL_STRAIGHT_BEHIND,
    "visitor_ahead": VISITOR_AHEAD,
    "two_balls": TWO_BALLS,
}

RunTree = Callable[..., Ran]


@pytest.fixture
def run_tree(tmp_path: Path) -> RunTree:
    """Return what runs the text below the root's emergency stop of a tree."""
    for folder in ("trees", "skills", "sim/scenes"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "skills" / "stumble.py").write_text(SKILLS, encoding="utf-8")
    for name, text in SCENES.items():
        (tmp_path / "sim" / "scenes" / f"{name}.yaml").write_text(text, encoding="utf-8")

    def run(text: str, scene: str = "empty", *, seed: int = 0, duration: float = 30.0) -> Ran:
        head = f"format: 1\nscene: {scene}\nroot:\n  emergency_stop:\n"
        body = textwrap.indent(textwrap.dedent(text), "    ")
        (tmp_path / "trees" / "used.yaml").write_text(head + body, encoding="utf-8")
        return ran("used", tmp_path, seed=seed, duration=duration)

    return run


def stance(run: Ran) -> tuple[float, float, float]:
    """Return where the robot stands at the end: x, y [m], heading [rad]."""
    x, y, heading = run.session.engine.sense()[0].stance
    return float(x), float(y), float(heading)


def ended(run: Ran, name: str) -> list[str]:
    """Return what a node came to each time it ended, in order."""
    return [
        change.status.name.lower()
        for change in run.told.changes
        if change.path.rsplit("/", 1)[-1].split("#")[0] == name and change.status.name in ("SUCCESS", "FAILURE")
    ]
