"""When perception is held up: who is blamed, who is not, and what is told."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from humanoid_bt.link.ring import RingWriter
from humanoid_bt.link.run_folder import RunFolder, RunInfo
from humanoid_bt.perception.choice import Chosen
from humanoid_bt.perception.tracker import Tracker
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.perception_life import PerceptionLife


class Patient(Tracker):
    """It may take five seconds."""

    patience = 5.0


class Processes:
    """The processes of a run, of which there are none."""

    def __init__(self) -> None:
        self.told: list[str] = []
        self.ended = ""

    def start(self, role: str, _module: str) -> None:
        self.told.append(f"start {role}")
        self.ended = ""

    def kill(self, role: str) -> None:
        self.told.append(f"kill {role}")
        self.ended = "killed by signal 9"

    def how_ended(self, _role: str) -> str:
        return self.ended


class Held:
    """Perception with two sources that publish nothing, looked at once per tick."""

    def __init__(self, folder: RunFolder, classes: list[type[Tracker]]) -> None:
        self.folder, self.processes = folder, Processes()
        channels.create_channels(folder)
        self.percepts: RingWriter = channels.writer(folder, "percept")
        chosen = [Chosen("mine", cls, {}, ()) for cls in classes]
        processes: Any = self.processes
        self.life = PerceptionLife(folder, processes, chosen, channels.reader(folder, "percept"))
        self.signs = channels.source_signs(folder, 2)
        self.life.start()
        self.percepts.write(b"")

    def wait(self, seconds: float, writes: bool = False) -> list[str]:
        told = []
        for _ in range(round(seconds / 0.02)):
            if writes:
                self.percepts.write(b"")
            told.append(self.life.look())
        return [text for text in told if text]


@pytest.fixture(params=[[Tracker, Tracker]])
def held(request: pytest.FixtureRequest) -> Iterator[Held]:
    folder = RunFolder.create(RunInfo("tree", "robot"))
    one = Held(folder, request.param)
    yield one
    one.life.close()
    one.percepts.close()
    folder.close()


def test_who_is_at_work_while_perception_is_silent_is_off(held: Held) -> None:
    held.signs[1].beat()
    assert not held.wait(2.9)
    (told,) = held.wait(0.2)
    assert told == "the percept source 'mine 2' is off: it held up perception for 3.0 s, which begins anew without it"
    assert channels.off_sources(held.folder) == {"mine 2": "held up perception for 3.0 s"}
    assert not held.wait(20.0)  # it has not begun to write
    assert held.processes.told == ["start perception", "kill perception", "start perception"]
    assert not held.life.ended


def test_of_two_at_work_nobody_knows_which(held: Held) -> None:
    for sign in held.signs:
        sign.beat()
    (told,) = held.wait(3.2)
    assert "sources 'mine' and 'mine 2' are off: one of them held up perception" in told


def test_one_that_is_slow_while_perception_goes_on_is_left_alone(held: Held) -> None:
    held.signs[0].beat()
    assert not held.wait(20.0, writes=True)
    held.signs[0].beat()
    assert not held.wait(20.0)  # silent, and nobody is at work: the camera may be slow
    assert held.processes.told == ["start perception"]


@pytest.mark.parametrize("held", [[Tracker, Patient]], indirect=True)
def test_it_has_the_patience_that_it_asks_for(held: Held) -> None:
    held.signs[1].beat()
    assert not held.wait(5.9)
    assert held.wait(0.2)


def test_an_end_that_nobody_meant_is_told_once(held: Held) -> None:
    held.processes.ended = "killed by signal 9"
    assert held.wait(1.0) == ["the perception process ended (killed by signal 9)"]
    assert held.processes.told == ["start perception"]
