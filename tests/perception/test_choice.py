"""Which sources are asked for, and what is no source."""

from __future__ import annotations

import re
from typing import Any

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.perception.sources import problems


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
