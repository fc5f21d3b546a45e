"""A workspace in which everything goes wrong that can stop a robot, one tree for each."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from tests.projects import make_project

ROOT = Path(__file__).resolve().parents[2]

SKILLS = '''
import math
import time

import numpy as np
from humanoid_bt import Skill, Status, param
from humanoid_bt.core.messages import HandTarget


class Alarm(Skill):
    """Raise the emergency stop after a while."""

    def initialise(self) -> None:
        self._since = self.robot.clock.now()

    def update(self) -> Status:
        if self.robot.clock.now() - self._since >= 0.3:
            self.robot.raise_estop("somebody is too near")
        return self.running("watching")


class Wild(Skill):
    """Walk, and after a while ask for something that is none."""

    resources = ("base", "left_hand")
    target: str = param("far", doc="far or nan.")

    def initialise(self) -> None:
        self._since = self.robot.clock.now()

    def update(self) -> Status:
        self.robot.walk_to((3.0, 0.0), 0.0)
        if self.robot.clock.now() - self._since >= 0.3:
            self.robot.move_hand("left", (math.nan if self.target == "nan" else 1.0, 0.0, 0.0))
            if self.target == "far":  # past what looks at targets
                self.robot._set("left_hand", HandTarget(np.array([1e6, 0.0, 0.0])))
        return self.running("walking")


class Thief(Skill):
    """Take the base without saying so before."""

    resources = ("base",)

    @classmethod
    def resources_for(cls, values):
        return ()

    def update(self) -> Status:
        self.robot.walk_to((0.0, 0.0), 0.0)
        return self.running("stealing")


class Sleepy(Skill):
    """Walk, and once take much too long."""

    resources = ("base",)

    def initialise(self) -> None:
        self._since = self.robot.clock.now()

    def update(self) -> Status:
        self.robot.walk_to((3.0, 0.0), 0.0)
        if not getattr(self, "_slept", False) and self.robot.clock.now() - self._since >= 0.3:
            self._slept = True
            time.sleep(0.5)
        return self.running("walking")
'''

HIDDEN = """
format: 1
name: hidden
description: A ball that is hidden soon.
robot: {position: [0, 0], heading: 0 deg}
objects:
  ball: {shape: ball, size: [8 cm], color: orange, position: [1.9, 0.5, 0.85], stand: true}
percepts:
  target: {object: ball}
events:
  - {at: 0.4 s, hide: ball}
"""

NEVER = HIDDEN.replace("name: hidden", "name: never").replace("at: 0.4 s", "at: 0 s")
FLICKER = (
    HIDDEN.replace("name: hidden", "name: flicker").split("events:")[0]
    + "events:\n"
    + "".join(f"  - {{at: {0.3 * number:.1f} s, {'hide' if number % 2 else 'show'}: ball}}\n" for number in range(1, 9))
)
_LATE = {
    "late_hidden": (HIDDEN, 3.4),
    "late_flicker": (FLICKER, 3.6),
}  # a realtime run begins with the robot standing up
BUMPED = """
format: 1
name: bumped
description: Something comes from behind, and through where the robot stands.
robot: {position: [0, 0], heading: 0 deg}
objects:
  ram: {shape: box, size: [30 cm, 20 cm, 20 cm], position: [-3, 0, 1], solid: true}
events:
  - {at: 3 s, move: ram, to: [3, 0, 1], over: 3 s}
"""

WATCHED = "{watchdog: {percept: target, max_age: 0.3 s, "
SURE = "{confident: {percept: target, above: 0.6, hysteresis: 0.1}}"
TREES = {
    "alarm": ("empty", "{parallel: [walk, alarm]}"),
    "nan": ("empty", "{wild: {target: nan}}"),
    "refused": ("empty", "wild"),
    "thieves": ("empty", "{parallel: [walk, thief]}"),
    "sleepy": ("empty", "sleepy"),
    "behind": (
        "empty",
        "{sequence: [{wait: 0.1 s}, {force_success: give_up}, "
        "{condition: {name: culprit, expression: state.x > 5 m}}]}",
    ),
    "late": ("empty", "{timeout: {duration: 0.5 s, walk: {}}}"),
    "fails_when_lost": ("ball_on_stand", WATCHED + "approach: {target: target}}}"),
    "waits_when_lost": (
        "ball_on_stand",
        WATCHED + "on_stale: {pause: {name: blind, duration: 60}}, approach: {target: target}}}",
    ),
    "looks_when_lost": (
        "ball_on_stand",
        "{reactive_selector: [" + WATCHED + "approach: {target: target}}}, idle]}",
    ),
    "looks_when_doubtful": (
        "hidden",
        "{reactive_selector: ["
        + WATCHED
        + f"reactive_sequence: [{SURE}, {{approach: {{target: target}}}}]}}}}, idle]}}",
    ),
    "unseen": ("never", WATCHED + "approach: {target: target}}}"),
    "doubtful": (
        "hidden",
        WATCHED + f"reactive_sequence: [{SURE}, {{approach: {{target: target}}}}]}}}}",
    ),
    "flapping": (
        "flicker",
        WATCHED + f"reactive_selector: [{{reactive_sequence: [{SURE}, idle]}}, {{wait: 60 s}}]}}}}",
    ),
    "gives_way": (
        "hidden",
        WATCHED + f"reactive_selector: [{{reactive_sequence: [{{inverter: {SURE}}}, {{wait: 60 s}}]}}, walk]}}}}",
    ),
    "late_doubtful": (
        "late_hidden",
        WATCHED + f"reactive_sequence: [{SURE}, {{approach: {{target: target}}}}]}}}}",
    ),
    "late_flapping": (
        "late_flicker",
        WATCHED + f"reactive_selector: [{{reactive_sequence: [{SURE}, idle]}}, {{wait: 60 s}}]}}}}",
    ),
    "bumped": ("bumped", "{wait: 60 s}"),
    "far": ("ball_on_stand", WATCHED + "reach: {target: target, hand: left, patience: 0.2 s}}}"),
}
"""Tree -> its scene, and what stands below its emergency stop."""


def _later(name: str, scene: str, by: float) -> str:
    """Return a scene in which everything happens later [s]."""
    renamed = re.sub(r"name: \w+", f"name: {name}", scene, count=1)
    return re.sub(r"at: ([\d.]+) s", lambda at: f"at: {float(at[1]) + by:.1f} s", renamed)


def make_stage(folder: Path) -> Path:
    """Make the workspace; return its folder."""
    make_project(folder)
    (folder / "skills" / "staged.py").write_text(SKILLS, encoding="utf-8")
    scenes = folder / "sim" / "scenes"
    scenes.mkdir(parents=True)
    made = {name: _later(name, *of) for name, of in _LATE.items()}
    for name, text in {"hidden": HIDDEN, "never": NEVER, "flicker": FLICKER, "bumped": BUMPED, **made}.items():
        (scenes / f"{name}.yaml").write_text(text, encoding="utf-8")
    for name, (scene, root) in TREES.items():
        text = f"format: 1\nscene: {scene}\nroot:\n  emergency_stop: {root}\n"
        (folder / "trees" / f"{name}.yaml").write_text(text, encoding="utf-8")
    weak = folder / "sim" / "weak"
    shutil.copytree(ROOT / "sim" / "humanoid", weak)
    robot = weak / "robot.yaml"
    text = robot.read_text(encoding="utf-8")
    strong, feeble = "damping: 6, torque: 40", "damping: 6, torque: 2"
    assert strong in text
    robot.write_text(text.replace(strong, feeble).replace("name: humanoid", "name: weak"), encoding="utf-8")
    return folder
