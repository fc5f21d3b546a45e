"""Percept sources that tests write."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import choose, written
from humanoid_bt.plant.scene import load_scene

HEAD = """
import time
from humanoid_bt import Moment, Percept, PerceptName, PerceptSource, param
"""

SIGN = '''
class DoorSign(PerceptSource):
    """See a sign two metres ahead of the base."""

    rate = 25.0
    sign: PerceptName = param("sign", doc="Percept that it publishes.")
    ahead: float = param(2.0, unit="m", above=0, doc="How far.")

    def look(self, now):
        noise = 0.01 * self.random.standard_normal()
        return [Percept(self.sign, now.time, (self.ahead + noise, 0, 0), 0.9, class_name="sign")]
'''

BAD = '''
class Raises(PerceptSource):
    """Raise after a while."""

    rate = 10.0
    name: PerceptName = param("raised", doc="Percept that it publishes.")

    def look(self, now):
        if now.time >= 0.5:
            raise KeyError("no detector")
        return [Percept(self.name, now.time, (1, 0, 0), 0.9)]


class Blocks(PerceptSource):
    """Do not come back."""

    rate = 10.0
    patience = 0.2

    def look(self, now):
        while True:
            time.sleep(0.001)


class Holds(PerceptSource):
    """Call something that keeps Python's lock, and does not come back."""


    name: PerceptName = param("held", doc="Percept that it publishes.")

    def setup(self):
        self.looks = 0

    def look(self, now):
        import ctypes

        self.looks += 1
        if self.looks > 9:  # at 0.9 s, when nobody looks who does so 25 times a second: who holds is known
            ctypes.PyDLL(None).pause()
        return []


class Floods(PerceptSource):
    """Publish without end."""

    name: PerceptName = param("flood", doc="Percept that it publishes.")

    def look(self, now):
        while True:
            yield Percept(self.name, now.time, (1, 0, 0), 0.9)


class Textless(PerceptSource):
    """Raise what cannot say what it is."""

    name: PerceptName = param("textless", doc="Percept that it publishes.")

    def look(self, now):
        class Odd(Exception):
            def __str__(self):
                raise RuntimeError("no text")

        raise Odd


class Wordless(PerceptSource):
    """Do not say why it sees nothing."""

    name: PerceptName = param("cup", doc="Percept that it publishes.")

    def look(self, now):
        self.why = None
        return []

    def why_unseen(self, name):
        return self.why


class Clueless(Wordless):
    """Raise when it is asked why it sees nothing."""

    def why_unseen(self, name):
        return self.reason


class Fails(PerceptSource):
    """Cannot be set up."""

    def setup(self):
        raise OSError("no weights")

    def look(self, now):
        return []
'''

LATE = '''
class Late(PerceptSource):
    """See nothing until half a second has passed, and say how long that is."""

    name: PerceptName = param("late", doc="Percept that it publishes.")

    def look(self, now):
        self.given = now
        self.now = now.time
        return [Percept(self.name, now.time, (1, 0, 0), 0.9)] if now.time > 0.35 else []

    def why_unseen(self, name):
        return f"nothing at {self.now:.1f} s"
'''


def write(folder: Path, name: str, text: str) -> Path:
    """Write a file of sources into a workspace."""
    (folder / "perception").mkdir(exist_ok=True)
    path = folder / "perception" / name
    path.write_text(HEAD + text, encoding="utf-8")
    return path


def problems(workspace: Workspace, sources: Any) -> str:
    """Return what is told of sources that cannot be chosen."""
    config = load_scene(workspace.find_scene("ball_on_stand"))
    with pytest.raises(UserError) as caught:
        choose(written(sources), workspace, config)
    return str(caught.value)
