"""Sources of percepts at work: when each is asked, what it is given, and what of its answers is taken."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.messages import Percept
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import choose, written
from humanoid_bt.perception.senses import Senses, new_perception
from humanoid_bt.perception.source import Moment
from humanoid_bt.perception.worker import PerceptError, checked
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from tests.perception.sources import SIGN, write
from tests.perception.test_senses import here

MORE = '''
class Textless(PerceptSource):
    """Raise what cannot say what it is."""

    name: PerceptName = param("textless", doc="Percept that it publishes.")

    def look(self, now):
        class Odd(Exception):
            def __str__(self):
                raise RuntimeError("no text")

        raise Odd


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

GOOD = Percept("cup", 1.0, np.array([1.0, 0, 0]), 0.5)


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel(load_robot_config(Workspace().find_robot("humanoid")))


@pytest.fixture
def senses(tmp_path: Path, robot: RobotModel) -> Iterator[Callable[..., Any]]:
    write(tmp_path, "door_sign.py", SIGN)
    write(tmp_path, "more.py", MORE)
    workspace, made = Workspace(tmp_path), list[Any]()

    def make(sources: Any, waits: bool = True) -> Any:
        scene = Scene(load_scene(workspace.find_scene("ball_on_stand")), 0)
        made.append(new_perception(choose(written(sources), workspace, scene.config), robot, scene, waits=waits))
        made[-1].start()
        return made[-1]

    yield make
    for one in made:
        one.close()


def watch(senses: Any, *times: float) -> tuple[list[Percept], list[str]]:
    percepts, news = list[Percept](), list[str]()
    for time in times:
        percepts += senses.observe(here(time))
        news += [text for _, text in senses.take_news()]
    return percepts, news


def test_a_source_whose_exception_has_no_text_is_off_and_the_others_go_on(senses: Any) -> None:
    percepts, news = watch(senses(["textless", "door_sign"]), 0.0, 0.1)
    assert {percept.name for percept in percepts} == {"sign"}
    (told,) = news
    assert told.startswith(
        "the percept source 'textless' is off: it raised Odd: (its text cannot be made: RuntimeError)"
    )


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (Percept("cup", 1.02, GOOD.position, 0.5), "it was not seen yet"),  # of the next tick
        (Percept("cup", 1.0, GOOD.position, 0.5, orientation=np.array([0.9, 0, 0, 0])), "a unit quaternion"),
        (Percept("cup", 1.0, GOOD.position, 0.5, orientation=np.array([1.1, 0, 0, 0])), "a unit quaternion"),
        (Percept("cup", 1.0, GOOD.position, 0.5, covariance=np.eye(3) + np.eye(3, k=1) / 2), "not symmetric"),
    ],
)
def test_percepts_that_are_a_little_wrong_are_refused(given: Percept, why: str) -> None:
    with pytest.raises(PerceptError, match=why):
        checked([given], ["cup"], 1.0)


# a field that is lost here is lost for trees
def test_everything_that_a_source_tells_is_published() -> None:
    turn = np.array([math.cos(0.2), 0, 0, math.sin(0.2)])
    given = Percept("cup", 0.9, GOOD.position, 0.5, np.array([1.0, 2, 3]), 0.7, turn, "mug", 0.01 * np.eye(3))
    (published,) = checked([given], ["cup"], 1.0)
    assert (published.stamp, published.confidence, published.heading, published.class_name) == (0.9, 0.5, 0.7, "mug")
    for field in ("position", "size", "orientation", "covariance"):
        array = getattr(published, field)
        np.testing.assert_array_equal(array, getattr(given, field))
        assert not array.flags.writeable


def test_why_a_source_sees_nothing_is_asked_in_each_look_and_forgotten_once_it_sees(senses: Any) -> None:
    late = senses("late")
    assert late.unseen == {"late": "perception has not looked yet"}
    for time in (0.0, 0.1, 0.3):
        watch(late, time)
        assert late.unseen == {"late": f"nothing at {time:.1f} s"}
    percepts, _ = watch(late, 0.4)
    assert ([percept.name for percept in percepts], late.unseen) == (["late"], {})
    watch(late, 0.5)
    assert late.unseen == {}


def test_a_source_is_given_only_what_it_needs(senses: Any) -> None:
    late = senses("late")
    late.observe(here(0.0), object())  # a state
    given: Moment = late._senses[0].worker.source.given
    assert (given.time, given.state, given.picture, given.truth) == (0.0, None, None, None)


def test_a_source_whose_look_was_missed_looks_as_soon_as_it_can(senses: Any) -> None:
    sign = senses({"door_sign": {}})
    assert isinstance(sign, Senses)
    percepts, _ = watch(sign, 0.0, 0.02, 0.06, 0.08, 0.14)  # the look at 0.04 s never came, nor that at 0.12 s
    assert [percept.stamp for percept in percepts] == pytest.approx([0.0, 0.06, 0.08, 0.14])


def test_two_sources_of_one_name_draw_numbers_of_their_own(senses: Any) -> None:
    percepts, _ = watch(senses([{"door_sign": {"sign": "a"}}, {"door_sign": {"sign": "b"}}]), 0.0)
    first, second = (percept.position[0] for percept in percepts)
    assert first != second


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


def test_a_tracker_that_publishes_only_some_of_the_scene_publishes_no_more(tmp_path: Path, robot: RobotModel) -> None:
    (tmp_path / "sim/scenes").mkdir(parents=True)
    (tmp_path / "sim/scenes/two.yaml").write_text(TWO)
    workspace = Workspace(tmp_path)
    scene = Scene(load_scene(workspace.find_scene("two")), 0)
    chosen = choose(written({"tracker": {"only": ["other"]}}), workspace, scene.config)
    senses = new_perception(chosen, robot, scene, waits=True)
    senses.start()
    percepts, _ = watch(senses, 0.0)
    senses.close()
    assert ({percept.name for percept in percepts}, list(senses.names)) == ({"other"}, ["other"])


def test_what_a_source_saw_before_it_failed_is_not_among_what_was_never_seen(senses: Any, tmp_path: Path) -> None:
    raises = MORE.replace("Textless", "Brief").replace('"textless"', '"brief"').replace(
        "    def look(self, now):\n", "    def look(self, now):\n        if now.time < 0.05:\n"
        "            return [Percept(self.name, now.time, (1, 0, 0), 0.9)]\n", 1)  # fmt: skip
    write(tmp_path, "brief.py", raises.partition("class Late")[0].replace("def __str__", "def text"))
    brief = senses("brief")
    percepts, news = watch(brief, 0.0, 0.1)
    assert ([percept.name for percept in percepts], len(news), brief.unseen) == (["brief"], 1, {})


def test_without_pictures_only_the_sources_that_need_some_are_off(senses: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    class Broken:
        why_none = "the camera is gone"

        def __init__(self, *_: object) -> None: ...

        def open(self) -> None: ...

        def look(self, *_: object) -> None: ...

        def close(self) -> None: ...

    monkeypatch.setattr("humanoid_bt.perception.senses.Eyes", Broken)
    both = senses(["color_blob", "door_sign"])
    percepts, news = list[Percept](), list[str]()
    for time in (0.0, 0.04, 0.08):
        percepts += both.observe(here(time), object())
        news += [text for _, text in both.take_news()]
    assert [percept.name for percept in percepts] == ["sign"] * 3
    assert news == ["the percept source 'color_blob' is off: it has no picture: the camera is gone"]


BLOCKS = '''
class Sleeps(PerceptSource):
    """Do not come back."""

    patience = 5.0
    name: PerceptName = param("slept", doc="Percept that it publishes.")

    def look(self, now):
        while True:
            time.sleep(0.001)
'''


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
