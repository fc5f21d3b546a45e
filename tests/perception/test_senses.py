"""Percept sources at work: when they look, what becomes of one that fails, and of the others."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Percept, Truth
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import choose, simulated, written
from humanoid_bt.perception.senses import Senses, new_perception
from humanoid_bt.perception.simulated import SimulatedPerception
from humanoid_bt.perception.source import Moment, PerceptSource
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.testing.source_rig import SourceTrial
from tests.perception.sources import LATE, SIGN, write

BLOCKS = '''
class Sleeps(PerceptSource):
    """Do not come back."""

    patience = 5.0
    name: PerceptName = param("slept", doc="Percept that it publishes.")

    def look(self, now):
        while True:
            time.sleep(0.001)
'''
TWO = """
format: 1
name: two
objects:
  ball: {shape: ball, size: [8 cm], color: orange, position: [1.0, 0.1, 0.85], stand: true}
  cube: {shape: box, size: [0.1, 0.1, 0.1], color: blue, position: [1.0, -0.3, 0.85], stand: true}
percepts:
  target: {object: ball}
  other: {object: cube}
"""


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel(load_robot_config(Workspace().find_robot("humanoid")))


def here(time: float) -> Truth:
    ahead = np.array([1.0, 0.0, 0.0])
    return Truth(time, np.array([0, 0, 0.7]), np.array([1.0, 0, 0, 0]), np.array([0.1, 0, 1.2]), ahead)


@pytest.fixture
def senses(workspace: Workspace, robot: RobotModel) -> Iterator[Callable[..., Any]]:
    """Makes what sources see, and has begun to look."""
    made = list[Any]()

    def make(sources: Any, seed: int = 0, scene: str = "ball_on_stand", waits: bool = True) -> Any:
        room = Scene(load_scene(workspace.find_scene(scene)), seed)
        made.append(new_perception(choose(written(sources), workspace, room.config), robot, room, waits=waits))
        made[-1].start()
        return made[-1]

    yield make
    for one in made:
        one.close()


def watch(senses: Any, *times: float, of: object = None) -> tuple[list[Percept], list[str]]:
    """Return what is published and told when sources look at these times."""
    percepts, news = list[Percept](), list[str]()
    for time in times:
        percepts += senses.observe(here(time), of)
        news += [text for _, text in senses.take_news()]
    return percepts, news


@pytest.fixture
def late(workspace: Workspace, senses: Callable[..., Any]) -> Any:
    """The source that sees something only later."""
    write(workspace.root, "late.py", LATE)
    return senses("late")


class Seen:
    """What sources publish in half a minute, asked as an engine does."""

    def __init__(self, senses: Any) -> None:
        self.senses = senses
        self.percepts: list[Percept] = []
        self.news: list[str] = []

    def watch(self, until: float) -> Seen:
        ticks = round(self.senses.period / 0.02)
        begin, end = round(getattr(self, "now", 0.0) / 0.02), round(until / 0.02)
        percepts, news = watch(self.senses, *(tick * 0.02 for tick in range(begin, end, ticks)))
        self.percepts += percepts
        self.news += news
        self.now = until
        return self

    def times(self, name: str) -> list[float]:
        return [percept.stamp for percept in self.percepts if percept.name == name]


@pytest.fixture
def seen(senses: Callable[..., Any]) -> Callable[..., Seen]:
    return lambda sources, seed=0: Seen(senses(sources, seed))


def test_the_tracker_alone_is_the_simulated_perception(seen: Any) -> None:
    for sources in (None, "tracker"):
        assert isinstance(seen(sources).senses, SimulatedPerception)


def test_each_source_looks_at_its_own_rate(seen: Any) -> None:
    watched = seen(["tracker", {"door_sign": {"ahead": "150 cm"}}]).watch(0.4)
    assert isinstance(watched.senses, Senses)
    assert watched.times("sign") == pytest.approx(np.arange(0, 0.4, 0.04))
    assert watched.times("target") == pytest.approx([0.0, 0.1, 0.2, 0.3])
    sign = next(percept for percept in watched.percepts if percept.name == "sign")
    assert sign.position == pytest.approx([1.5, 0, 0], abs=0.05)
    assert (sign.class_name, sign.position.flags.writeable) == ("sign", False)


def test_a_source_whose_look_was_missed_looks_as_soon_as_it_can(senses: Any) -> None:
    sign = senses("door_sign")
    percepts, _ = watch(sign, 0.0, 0.02, 0.06, 0.08, 0.14)  # the look at 0.04 s never came, nor that at 0.12 s
    assert [percept.stamp for percept in percepts] == pytest.approx([0.0, 0.06, 0.08, 0.14])


def test_the_seed_decides_what_a_source_draws(seen: Any) -> None:
    first, again, other = (
        [percept.position[0] for percept in seen("door_sign", seed).watch(0.2).percepts] for seed in (3, 3, 4)
    )
    assert first == again != other


def test_two_sources_of_one_name_draw_numbers_of_their_own(senses: Any) -> None:
    percepts, _ = watch(senses([{"door_sign": {"sign": "a"}}, {"door_sign": {"sign": "b"}}]), 0.0)
    first, second = (percept.position[0] for percept in percepts)
    assert first != second


def test_the_tracker_gives_way_to_who_publishes_a_percept_of_its(seen: Any) -> None:
    watched = seen(["tracker", {"door_sign": {"sign": "target"}}]).watch(0.2)
    assert {percept.class_name for percept in watched.percepts} == {"sign"}


def test_a_tracker_that_publishes_only_some_of_the_scene_publishes_no_more(senses: Any, tmp_path: Path) -> None:
    (tmp_path / "sim/scenes").mkdir(parents=True)
    (tmp_path / "sim/scenes/two.yaml").write_text(TWO)
    tracker = senses({"tracker": {"only": ["other"]}}, scene="two")
    percepts, _ = watch(tracker, 0.0)
    assert ({percept.name for percept in percepts}, list(tracker.names)) == ({"other"}, ["other"])


@pytest.mark.parametrize(
    ("name", "until", "why"),
    [
        ("raises", 0.5, r"raised KeyError: 'no detector' \(.*perception/bad.py:13:\d+\)"),
        ("blocks", 0.0, r"has been at it for more than 0.2 s"),
        ("floods", 0.0, r"answers wrongly: look\(\) gave the percept 'flood' twice at once \(.*bad.py"),
        ("wordless", 0.0, r"answers wrongly: why_unseen\('cup'\) gave None, and must give a text \(.*bad.py"),
        ("clueless", 0.0, r"raised AttributeError: .*'reason' \(.*perception/bad.py:\d+:\d+\)"),
        ("fails", 0.0, r"raised OSError: no weights \(.*perception/bad.py:\d+:\d+\)"),
    ],
)
def test_a_source_that_fails_is_off_and_told_and_the_others_go_on(seen: Any, name: str, until: float, why: str) -> None:
    watched = seen([name, "door_sign"]).watch(until)
    assert not [text for text in watched.news if name != "fails"]
    watched.watch(1.0)
    assert len(watched.news) == 1
    assert re.match(f"the percept source '{name}' is off: it {why}", watched.news[0])
    assert watched.times("sign") == pytest.approx(np.arange(0, 1.0, 0.04))
    assert watched.times("raised") == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4] if name == "raises" else [])
    if name == "floods":
        assert "is off" in watched.senses.unseen["flood"]


def test_a_source_whose_exception_has_no_text_is_off_and_the_others_go_on(senses: Any) -> None:
    percepts, news = watch(senses(["textless", "door_sign"]), 0.0, 0.1)
    assert {percept.name for percept in percepts} == {"sign"}
    (told,) = news
    assert told.startswith(
        "the percept source 'textless' is off: it raised Odd: (its text cannot be made: RuntimeError)"
    )


@pytest.mark.parametrize("patience", ["1e300", "float('inf')"])
def test_a_source_may_have_patience_without_end(workspace: Workspace, seen: Any, patience: str) -> None:
    patient = SIGN.replace("DoorSign", "Patient").replace("rate = ", f"patience = {patience}; rate = ")
    write(workspace.root, "patient.py", patient)
    assert seen("patient").watch(0.1).times("sign")


def test_a_source_that_nobody_waits_for_is_off_when_its_patience_is_over(
    senses: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, "sleeps.py", BLOCKS)
    both = senses("sleeps", waits=False)
    now = [100.0]

    class Clock:
        @staticmethod
        def monotonic() -> float:
            return now[0]

    monkeypatch.setattr("humanoid_bt.perception.worker.time", Clock)
    assert watch(both, 0.0)[1] == []
    now[0] += 4.9
    assert watch(both, 0.5)[1] == []
    now[0] += 0.2
    assert watch(both, 1.0)[1] == ["the percept source 'sleeps' is off: it has been at it for more than 5 s"]


def test_what_is_never_published_says_why(seen: Any) -> None:
    watched = seen(["tracker", "door_sign"])
    assert watched.senses.unseen["target"] == "perception has not looked yet"
    assert "sign" not in watched.watch(0.1).senses.unseen


def test_why_a_source_sees_nothing_is_asked_in_each_look_and_forgotten_once_it_sees(late: Any) -> None:
    assert late.unseen == {"late": "perception has not looked yet"}
    for time in (0.0, 0.1, 0.3):
        watch(late, time)
        assert late.unseen == {"late": f"nothing at {time:.1f} s"}
    percepts, _ = watch(late, 0.4)
    assert ([percept.name for percept in percepts], late.unseen) == (["late"], {})
    watch(late, 0.5)
    assert late.unseen == {}


def test_what_a_source_saw_before_it_failed_is_not_among_what_was_never_seen(senses: Any) -> None:
    raises = senses("raises")
    percepts, news = watch(raises, 0.4, 0.5)
    assert ([percept.name for percept in percepts], len(news), raises.unseen) == (["raised"], 1, {})


def test_what_looks_at_the_simulation_is_known_and_publishes_nothing_when_it_is_off(
    workspace: Workspace, robot: RobotModel
) -> None:
    scene = Scene(load_scene(workspace.find_scene("ball_on_stand")), 0)
    chosen = choose(written(["tracker", {"color_blob": {"target": "ball"}}, "door_sign"]), workspace, scene.config)
    blind = dict.fromkeys(simulated(chosen), "is blind")
    assert sorted(blind) == ["color_blob", "tracker"]
    for some in (chosen, chosen[:1]):
        senses = new_perception(some, robot, scene, waits=True, off=blind)
        senses.start()  # needs no picture
        assert {percept.name for percept in senses.observe(here(0.0))} == {"sign"} & set(senses.names)
        assert senses.unseen["target"] == "the percept source 'tracker' is off: it is blind"
        senses.close()


def test_without_pictures_only_the_sources_that_need_some_are_off(senses: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    class Broken:
        why_none = "the camera is gone"

        def __init__(self, *_: object) -> None: ...

        def open(self) -> None: ...

        def look(self, *_: object) -> None: ...

        def close(self) -> None: ...

    monkeypatch.setattr("humanoid_bt.perception.senses.Eyes", Broken)
    both = senses(["color_blob", "door_sign"])
    percepts, news = watch(both, 0.0, 0.04, 0.08, of=object())
    assert [percept.name for percept in percepts] == ["sign"] * 3
    assert news == ["the percept source 'color_blob' is off: it has no picture: the camera is gone"]


def test_a_source_is_given_only_what_it_needs(late: Any) -> None:
    late.observe(here(0.0), object())  # a state
    given: Moment = late._senses[0].worker.source.given
    assert (given.time, given.state, given.picture, given.truth) == (0.0, None, None, None)


def test_a_source_that_cannot_be_made_is_told(workspace: Workspace, seen: Any) -> None:
    text = "class Mine(PerceptSource):\n    def __init__(self, **values):\n        self.x\n    look = None\n"
    write(workspace.root, "wrong.py", text)
    with pytest.raises(UserError, match=r"wrong.py:6:9: error: the percept source 'mine' raised AttributeError"):
        seen("mine")


@pytest.mark.parametrize(("rate", "ticks"), [(50.0, 1), (16.66, 3), (8.33, 6), (7.143, 7)])
def test_a_source_under_test_looks_when_it_does_in_a_run(rate: float, ticks: int) -> None:
    class Rated(PerceptSource):
        def look(self, now: Moment) -> list[Percept]:
            return [Percept("sign", now.time, np.zeros(3), 0.9)]

    Rated.rate, Rated.names = rate, ("sign",)
    looks = SourceTrial(Rated(), "rated").watch(Moment(0.02 * tick) for tick in range(50))
    assert [round(percept.stamp / 0.02) for percept in looks] == list(range(0, 50, ticks))
