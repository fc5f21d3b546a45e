"""Percept sources at work: when they look, what becomes of one that fails, and of the others."""

from __future__ import annotations

import re
from collections.abc import Iterator
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
from humanoid_bt.perception.worker import PerceptError, checked
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.testing.source_rig import SourceTrial
from tests.perception.sources import BAD, SIGN, write


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel(load_robot_config(Workspace().find_robot("humanoid")))


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    write(tmp_path, "door_sign.py", SIGN)
    write(tmp_path, "bad.py", BAD)
    return Workspace(tmp_path)


def here(time: float) -> Truth:
    ahead = np.array([1.0, 0.0, 0.0])
    return Truth(time, np.array([0, 0, 0.7]), np.array([1.0, 0, 0, 0]), np.array([0.1, 0, 1.2]), ahead)


class Seen:
    """What sources publish in half a minute, asked as an engine does."""

    def __init__(self, workspace: Workspace, robot: RobotModel, sources: Any, seed: int = 0) -> None:
        scene = Scene(load_scene(workspace.find_scene("ball_on_stand")), seed)
        chosen = choose(written(sources), workspace, scene.config)
        self.senses = new_perception(chosen, robot, scene, waits=True)
        self.senses.start()
        self.percepts: list[Percept] = []
        self.news: list[str] = []
        self.robot = robot

    def watch(self, until: float) -> Seen:
        ticks = round(self.senses.period / 0.02)
        begin, end = round(getattr(self, "now", 0.0) / 0.02), round(until / 0.02)
        for tick in range(begin, end, ticks):
            self.percepts += self.senses.observe(here(tick * 0.02))
            self.news += [text for _, text in self.senses.take_news()]
        self.now = until
        return self

    def times(self, name: str) -> list[float]:
        return [percept.stamp for percept in self.percepts if percept.name == name]


@pytest.fixture
def seen(workspace: Workspace, robot: RobotModel) -> Iterator[Any]:
    made: list[Seen] = []

    def make(sources: Any, seed: int = 0) -> Seen:
        made.append(Seen(workspace, robot, sources, seed))
        return made[-1]

    yield make
    for one in made:
        one.senses.close()


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


def test_the_seed_decides_what_a_source_draws(seen: Any) -> None:
    first, again, other = (
        [percept.position[0] for percept in seen("door_sign", seed).watch(0.2).percepts] for seed in (3, 3, 4)
    )
    assert first == again != other


def test_the_tracker_gives_way_to_who_publishes_a_percept_of_its(seen: Any) -> None:
    watched = seen(["tracker", {"door_sign": {"sign": "target"}}]).watch(0.2)
    assert {percept.class_name for percept in watched.percepts} == {"sign"}


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


@pytest.mark.parametrize("patience", ["1e300", "float('inf')"])
def test_a_source_may_have_patience_without_end(workspace: Workspace, seen: Any, patience: str) -> None:
    patient = SIGN.replace("DoorSign", "Patient").replace("rate = ", f"patience = {patience}; rate = ")
    write(workspace.root, "patient.py", patient)
    assert seen("patient").watch(0.1).times("sign")


def test_what_is_never_published_says_why(seen: Any) -> None:
    watched = seen(["tracker", "door_sign"])
    assert watched.senses.unseen["target"] == "perception has not looked yet"
    assert "sign" not in watched.watch(0.1).senses.unseen


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


GOOD = Percept("cup", 1.0, np.array([1.0, 0, 0]), 0.5)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (None, "gave None"),
        (GOOD, "gave a percept, and must give a list"),
        (["cup"], "which is no Percept"),
        ([GOOD, GOOD], "'cup' twice"),
        ([Percept("bowl", 1.0, GOOD.position, 0.5)], "'bowl', which it does not publish: it publishes cup"),
        ([Percept("cup", 1.0, np.array([1.0, np.nan, 0]), 0.5)], "has the position"),
        ([Percept("cup", 1.0, np.zeros(2), 0.5)], "has the position"),
        ([Percept("cup", 1.0, GOOD.position, 1.5)], "confidence 1.5: it is from 0 to 1"),
        ([Percept("cup", 9.0, GOOD.position, 0.5)], "it was not seen yet"),
        ([Percept("cup", -99.0, GOOD.position, 0.5)], "has the stamp of 100 s ago: .* of 60 s"),
        ([Percept("cup", 1.0, 2000 * GOOD.position, 0.5)], "is 2000 m away: positions are in metres"),
        ([Percept("cup", 1.0, GOOD.position, 0.5, size=np.array([1, 0, 1]))], "lengths are above 0"),
        ([Percept("cup", 1.0, GOOD.position, 0.5, orientation=np.ones(4))], "a unit quaternion"),
        ([Percept("cup", 1.0, GOOD.position, 0.5, covariance=-np.eye(3))], "not symmetric and positive"),
        ([Percept("cup", 1.0, GOOD.position, 0.5, covariance=np.full((2, 2), np.nan))], r"\[nan, nan\], \[nan, nan\]"),
        ([Percept("cup", 1.0, GOOD.position, 0.5, class_name=3)], "no text"),  # type: ignore[arg-type]  # the mistake that is tried
    ],
)
def test_only_sound_percepts_of_its_own_are_published(given: Any, why: str) -> None:
    with pytest.raises(PerceptError, match=why.replace("(", r"\(")):
        checked(given, ["cup"], 1.0)


def problems(workspace: Workspace, sources: Any) -> str:
    config = load_scene(workspace.find_scene("ball_on_stand"))
    with pytest.raises(UserError) as caught:
        choose(written(sources), workspace, config)
    return str(caught.value)


@pytest.mark.parametrize(
    ("sources", "message"),
    [
        ("door_sing", r"no percept source named 'door_sing' .*\n.*did you mean 'door_sign'"),
        ({"door_sign": {"ahead": "2 kg"}}, r"'ahead' has the unit 'kg'"),
        ({"door_sign": {"ahed": 2}}, r"unknown parameter 'ahed' of 'door_sign'"),
        ({"door_sign": [2]}, "the parameters of the source 'door_sign' must be a mapping, not a list"),
        (["door_sign", "door_sign"], "two sources publish the percept 'sign'"),
        ({"tracker": {"only": ["cup"]}}, "the scene 'ball_on_stand' has no percept 'cup'"),
        ([], "'perception' names no source"),
        (3, "a percept source must be named, and this is a number"),
    ],
)
def test_wrong_names_and_parameters_are_told(workspace: Workspace, sources: Any, message: str) -> None:
    assert re.search(message, problems(workspace, sources))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1\n", r"wrong.py:1:1: error: this file has no percept source \[broken-source\]"),
        ("import nothing_here\n", r"wrong.py:4:1: error: the file of percept sources cannot be imported"),
        ("class A(PerceptSource): pass\n", r"wrong.py:4:1: error: the percept source 'a' has no look\(\)"),
        ("class A(PerceptSource):\n    rate = 30\n    def look(self, now): pass\n", "the rate of 'a' cannot be 30"),
        (
            "class A(PerceptSource):\n    patience = True\n    def look(self, now): pass\n",
            "the patience of 'a' cannot be True",
        ),
        (
            "class A(PerceptSource):\n    needs = 'state'\n    def look(self, now): pass\n",
            r"the needs of 'a' must be a tuple, not 'state' .*\n.*needs = \(\"state\",\)",
        ),
        ("class A(PerceptSource):\n    needs = ('lidar',)\n    def look(self, now): pass\n", "'a' cannot need 'lidar'"),
        (
            "class A(PerceptSource):\n    rate: float = param(5.0, doc='x')\n    def look(self, now): pass\n",
            "'a' declares the parameter 'rate', which every source has already",
        ),
        (
            "class A(PerceptSource):\n    far: float = param('5 m', unit='m', doc='')\n    def look(self, now): pass\n",
            r"in 'a', the default of 'far' must be 5.0, not '5 m' \[broken-source\]",
        ),
        (
            "class Mine(PerceptSource):\n    source_name = 'tracker'\n    def look(self, now): pass\n",
            r"wrong.py:4:1: error: the percept source 'tracker' is the simulated tracker, .* \[taken-name\]",
        ),
    ],
)
def test_mistakes_in_a_file_are_told_with_their_place(workspace: Workspace, text: str, message: str) -> None:
    write(workspace.root, "wrong.py", text)
    assert re.search(message, problems(workspace, "door_sign"))


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("return values['cup']", r"wrong.py:8:\d+: error: the percept source 'mine' raised KeyError: 'cup'"),
        ("pass", r"wrong.py:6:5: error: publishes\(\) of the percept source 'mine' gave None \[broken-source\]"),
        ("return 'cup'", "gave 'cup' .*\n.*a list of the percepts' names"),
        ("return [3]", r"gave \[3\]"),
        ("yield 1 / 0", "raised ZeroDivisionError: .*\n.*raised by its publishes"),
    ],
)
def test_a_source_that_cannot_say_what_it_publishes_is_told(workspace: Workspace, body: str, message: str) -> None:
    text = "class Mine(PerceptSource):\n    look = None\n    @classmethod\n    def publishes(cls, values):\n        "
    write(workspace.root, "wrong.py", text + body)
    assert re.search(message, problems(workspace, "mine"))


def test_a_source_that_cannot_be_made_is_told(workspace: Workspace, seen: Any) -> None:
    text = "class Mine(PerceptSource):\n    def __init__(self, **values):\n        self.x\n    look = None\n"
    write(workspace.root, "wrong.py", text)
    with pytest.raises(UserError, match=r"wrong.py:6:9: error: the percept source 'mine' raised AttributeError"):
        seen("mine")


def test_a_python_package_holds_no_sources(workspace: Workspace) -> None:
    write(workspace.root, "wrong.py", "x = 1\n")
    write(workspace.root, "__init__.py", "")
    assert not [path for path in workspace.perception_files() if path.is_relative_to(workspace.root)]


def test_two_files_cannot_declare_one_source(workspace: Workspace) -> None:
    write(workspace.root, "another.py", SIGN)
    assert "the percept source 'door_sign' is declared twice [duplicate-source]" in problems(workspace, "door_sign")


def test_a_users_source_wins_over_a_built_in_one(workspace: Workspace, robot: RobotModel) -> None:
    write(workspace.root, "color_blob.py", SIGN.replace("DoorSign", "ColorBlob"))
    config = load_scene(workspace.find_scene("ball_on_stand"))
    assert choose(written("color_blob"), workspace, config)[0].names == ("sign",)


@pytest.mark.parametrize(("rate", "ticks"), [(50.0, 1), (16.66, 3), (8.33, 6), (7.143, 7)])
def test_a_source_under_test_looks_when_it_does_in_a_run(rate: float, ticks: int) -> None:
    class Rated(PerceptSource):
        def look(self, now: Moment) -> list[Percept]:
            return [Percept("sign", now.time, np.zeros(3), 0.9)]

    Rated.rate, Rated.names = rate, ("sign",)
    looks = SourceTrial(Rated(), "rated").watch(Moment(0.02 * tick) for tick in range(50))
    assert [round(percept.stamp / 0.02) for percept in looks] == list(range(0, 50, ticks))
