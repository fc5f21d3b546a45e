"""Files of percept sources: which of them count, and every mistake in them with its place."""

from __future__ import annotations

import re

import pytest

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import choose, written
from humanoid_bt.plant.scene import load_scene
from tests.perception.sources import SIGN, problems, write


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


def test_a_python_package_holds_no_sources(workspace: Workspace) -> None:
    write(workspace.root, "wrong.py", "x = 1\n")
    write(workspace.root, "__init__.py", "")
    assert not [path for path in workspace.perception_files() if path.is_relative_to(workspace.root)]


def test_two_files_cannot_declare_one_source(workspace: Workspace) -> None:
    write(workspace.root, "another.py", SIGN)
    assert "the percept source 'door_sign' is declared twice [duplicate-source]" in problems(workspace, "door_sign")


def test_a_users_source_wins_over_a_built_in_one(workspace: Workspace) -> None:
    write(workspace.root, "color_blob.py", SIGN.replace("DoorSign", "ColorBlob"))
    config = load_scene(workspace.find_scene("ball_on_stand"))
    assert choose(written("color_blob"), workspace, config)[0].names == ("sign",)
