"""Trees as SVG pictures."""

from __future__ import annotations

import re
from collections import Counter
from xml.etree import ElementTree

import pytest
from py_trees.common import Status

from humanoid_bt.tree.show import Outline, OutlineNode, svg_tree
from tests.tree.drawings import NASTY, random_outline, random_statuses

SVG = "{http://www.w3.org/2000/svg}"


class Picture:
    """A picture that was read again."""

    def __init__(self, text: str) -> None:
        self.root = ElementTree.fromstring(text)
        groups = list(self.root.iter(f"{SVG}g"))
        self.nodes = [group for group in groups if "node" in group.get("class", "").split()]
        self.edges = [path for path in self.root.iter(f"{SVG}path") if "edge" in path.get("class", "").split()]

    def hints(self) -> list[str]:
        return [node.findtext(f"{SVG}title", "") for node in self.nodes]

    def texts(self, look: str) -> list[str]:
        return [text.text or "" for text in self.root.iter(f"{SVG}text") if text.get("class") == look]


def joined(texts: list[str]) -> str:
    """Return a text without the places where it was broken."""
    return "".join("".join(texts).split())


@pytest.mark.parametrize("seed", range(10))
def test_every_node_and_every_edge_is_there_once(seed: int) -> None:
    outline = random_outline(seed)
    picture = Picture(svg_tree(outline))
    assert Counter(picture.hints()) == Counter(node.hint for node in outline.nodes)
    assert len(picture.edges) == len(outline.nodes) - 1
    aside = [edge for edge in picture.edges if "aside" in edge.get("class", "")]
    assert len(aside) == len(picture.texts("branch")) == sum(bool(node.branch) for node in outline.nodes)


@pytest.mark.parametrize("seed", range(10))
def test_everything_is_inside_the_picture(seed: int) -> None:
    picture = Picture(svg_tree(random_outline(seed)))
    width, height = float(picture.root.get("width", 0)), float(picture.root.get("height", 0))
    for node in picture.nodes:
        x, y = map(float, re.findall(r"[\d.]+", node.get("transform", "")))
        assert 0 <= x < width
        assert 0 <= y < height


@pytest.mark.parametrize("text", NASTY)
def test_a_name_is_shown_as_it_is(text: str) -> None:
    node = OutlineNode(f"t/{text}", text, "act", "skill", -1, "", (f"reason: {text}",), text)
    picture = Picture(svg_tree(Outline(text, text, (node,))))
    assert joined(picture.texts("name")) == joined([text])
    assert joined(picture.texts("title")) == joined([text])
    assert joined(picture.texts("small")) == joined([text, "reason:", text])
    assert picture.hints() == [f"t/{text}\nact: {text}"]


def test_what_xml_forbids_is_written_out() -> None:
    node = OutlineNode("t/act", "act", "act", "skill", -1)
    said = {"t/act": "bell \x07 null \x00 lone \ud800"}
    assert Picture(svg_tree(Outline("t", "", (node,)), {}, said)).texts("said") == [r"bell \x07 null \x00 lone \ud800"]


def test_statuses_colour_and_mark_every_node() -> None:
    outline = random_outline(1)
    statuses = random_statuses(outline)
    plain, live = Picture(svg_tree(outline)), Picture(svg_tree(outline, statuses))
    for node, group in zip(outline.nodes, live.nodes, strict=True):
        assert group.get("class", "").split()[-1] == statuses[node.path].name.lower()
    for picture, count in ((plain, 0), (live, len(outline.nodes))):
        assert sum(path.get("class") == "mark" for path in picture.root.iter(f"{SVG}path")) == count


def test_a_node_that_nothing_is_known_of_is_invalid() -> None:
    outline = random_outline(1)
    live = Picture(svg_tree(outline, {outline.nodes[0].path: Status.RUNNING}))
    assert [group.get("class", "").split()[-1] for group in live.nodes[:2]] == ["running", "invalid"]


def test_feedback_is_shown_in_its_node() -> None:
    outline = random_outline(1)
    picture = Picture(svg_tree(outline, {}, {outline.nodes[3].path: "0.5 m to go"}))
    assert [text.text for text in picture.nodes[3].iter(f"{SVG}text") if text.get("class") == "said"] == ["0.5 m to go"]


def test_an_unknown_kind_has_a_look_of_its_own() -> None:
    node = OutlineNode("t/x", "x", "x", "something new", -1)
    picture = Picture(svg_tree(Outline("t", "", (node,))))
    assert picture.nodes[0].get("class") == "node other"


def test_the_same_tree_gives_the_same_text() -> None:
    assert svg_tree(random_outline(2)) == svg_tree(random_outline(2))


def test_a_long_name_is_broken() -> None:
    node = OutlineNode("t/x", "w" * 100 + " and_some_more_of_it", "x", "skill", -1)
    text = svg_tree(Outline("t", "", (node,)))
    assert float(Picture(text).root.get("width", 0)) < 400
