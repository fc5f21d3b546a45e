"""What is drawn of a tree."""

from __future__ import annotations

import dataclasses

import pytest

from humanoid_bt.core.params import Param
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.show import Outline, outline_of, unicode_tree
from tests.tree.drawings import random_outline, random_statuses
from tests.tree.helpers import load


class Expression:
    """What a parameter may be besides plain data."""

    def __str__(self) -> str:
        return "$distance - 0.1"


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.25, "at: 0.25 m"),
        (3, "at: 3 m"),
        ([0.1, 2.0], "at: [0.1, 2] m"),
        (True, "at: true"),
        (None, "at: null"),
        ({"x": 1.0}, "at: {x: 1}"),
        (Expression(), "at: $distance - 0.1"),
        ("two\nlines\x07", r"at: two lines\x07"),
    ],
)
def test_a_parameter_is_shown_as_a_file_would_say_it(value: object, shown: str, workspace: Workspace) -> None:
    tree = load(workspace, "root: act")
    node = tree.nodes[0]
    kind = dataclasses.replace(node.type, params={"at": Param("at", float, unit="m")})
    tree = dataclasses.replace(tree, nodes=(dataclasses.replace(node, type=kind, values={"at": value}),))
    assert outline_of(tree).nodes[0].parameters == (shown,)


def test_a_parameter_that_nothing_declares_is_shown_too(workspace: Workspace) -> None:
    tree = load(workspace, "root: act")
    tree = dataclasses.replace(tree, nodes=(dataclasses.replace(tree.nodes[0], values={"other": 1}),))
    assert outline_of(tree).nodes[0].parameters == ("other: 1",)


def test_an_outline_survives_its_way_to_another_process() -> None:
    outline = random_outline(0)
    assert Outline.from_json(outline.to_json()) == outline


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"name": "t", "description": "", "nodes": [{}]}'])
def test_what_is_no_outline_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"outline|JSON|Expecting"):
        Outline.from_json(text)


def test_feedback_stands_below_its_node() -> None:
    outline = random_outline(0)
    last = outline.nodes[-1]
    lines = unicode_tree(outline, {}, 10_000, {last.path: "0.5 m\nto go"}).splitlines()
    assert lines[-1].strip() == "→ 0.5 m to go"
    assert lines[-1].index("→") > lines[-2].index("○")


@pytest.mark.parametrize("width", [40, 50, 80])
def test_text_fits_as_well_as_its_words_allow(width: int) -> None:
    outline = random_outline(4, size=15)
    said = {node.path: "a long way to go to the target, and more" for node in outline.nodes}
    for line in unicode_tree(outline, random_statuses(outline), width, said).splitlines():
        assert len(line) <= width or "  " not in line.lstrip(" │") or "," not in line.rstrip(",")


UNITS = """
parameters: {step: 60 deg, near: 45cm}
root:
  emergency_stop:
    sequence:
      - turn: {angle: $step}
      - step_back: {distance: 20 cm}
      - walk_to: {x: $near, y: 0.5, heading: 1.5}
"""


def test_what_is_written_in_a_unit_is_shown_and_written_in_it(workspace: Workspace) -> None:
    tree = load(workspace, UNITS)
    wanted = [("angle: 60 deg",), ("distance: 20 cm",), ("x: 45 cm", "y: 0.5 m", "heading: 1.5 rad")]
    assert [node.parameters for node in outline_of(tree).nodes[2:]] == wanted
    text = tree.to_yaml()
    assert "step: 60 deg" in text
    assert "distance: 20 cm" in text


def test_a_number_with_an_exponent_is_shown_with_its_unit(workspace: Workspace) -> None:
    assert outline_of(load(workspace, "root: {wait: 1e-3}")).nodes[0].parameters == ("duration: 0.001 s",)


def test_what_is_given_from_outside_is_shown_as_it_is_given(workspace: Workspace) -> None:
    tree = load(workspace, UNITS, step="90 deg", near="0.3")
    assert outline_of(tree).nodes[2].parameters == ("angle: 90 deg",)
    assert outline_of(tree).nodes[4].parameters[0] == "x: 0.3 m"
    assert "step: 90 deg" in tree.to_yaml()
