"""A user's project folder with good and bad skills, for tests that run it."""

from __future__ import annotations

from pathlib import Path

SKILLS = '''
import asyncio
import math
import signal

from humanoid_bt.core.params import param
from humanoid_bt.decision.skill import Skill, Status


class Pause(Skill):
    """Stand for a while."""

    duration: float = param(0.2, unit="s", above=0, doc="How long.")

    def initialise(self) -> None:
        self._since = self.robot.clock.now()

    def update(self) -> Status:
        elapsed = self.robot.clock.now() - self._since
        return self.succeed("waited") if elapsed >= self.duration else self.running("waiting")


class GiveUp(Skill):
    """Fail."""

    def update(self) -> Status:
        return self.fail("the thing is not there")


class Walk(Skill):
    """Walk ahead for ever, and raise after a while if asked to."""

    resources = ("base",)
    raise_after: float | None = param(None, unit="s", doc="When to raise.")

    def initialise(self) -> None:
        self._since = self.robot.clock.now()

    def update(self) -> Status:
        if self.raise_after is not None and self.robot.clock.now() - self._since >= self.raise_after:
            raise KeyError("missing")
        # What ends within half a second need not come to a stand, which takes longer than that.
        ahead = 3.0 if self.robot.clock.now() - self._since >= 0.5 else 0.0
        self.robot.walk_to((ahead, 0.0), 0.0)
        return self.running("walking")


class Leave(Skill):
    """Walk, and after a while raise what usually ends a program."""

    resources = ("base",)
    after: float = param(1.0, unit="s", minimum=0, doc="When.")
    error: str = param("SystemExit", doc="What is raised.")

    def update(self) -> Status:
        if self.robot.clock.now() >= self.after:
            known = (SystemExit, KeyboardInterrupt, GeneratorExit, asyncio.CancelledError)
            raise {error.__name__: error for error in known}[self.error](7)
        self.robot.walk_to((3.0, 0.0), 0.0)
        return self.running("walking")


class Hang(Skill):
    """Loop for ever, as far as the person at the keyboard allows."""

    def update(self) -> Status:
        while True:
            signal.raise_signal(signal.SIGINT)


class Stubborn(Skill):
    """Raise when halted."""

    def update(self) -> Status:
        return self.running("on")

    def terminate(self, new_status: Status) -> None:
        raise RuntimeError("not now")


class Nowhere(Skill):
    """Send a hand to a place that is none."""

    resources = ("left_hand",)

    def update(self) -> Status:
        import numpy as np
        from humanoid_bt.core.messages import HandTarget
        self.robot._set("left_hand", HandTarget(np.array([1e6, 0.0, 0.0])))  # past what looks at it
        return self.running("sending")
'''

TREES = {
    "wait": "pause",
    "give_up": "give_up",
    "walk": "walk",
    "raise": "{walk: {raise_after: 1.0}}",
    "leave": "leave",
    "hang": "hang",
    "stubborn": "stubborn",
    "nowhere": "nowhere",
}


def make_project(folder: Path) -> Path:
    """Make a project with one tree per skill; return its folder."""
    (folder / "skills").mkdir(parents=True)
    (folder / "skills" / "mine.py").write_text(SKILLS, encoding="utf-8")
    (folder / "trees").mkdir()
    for name, root in TREES.items():
        (folder / "trees" / f"{name}.yaml").write_text(
            f"format: 1\nroot:\n  emergency_stop: {root}\n", encoding="utf-8"
        )
    return folder
