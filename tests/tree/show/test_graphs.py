"""Trees as Graphviz graphs and Mermaid flowcharts."""

from __future__ import annotations

import html
import re

import pytest

from humanoid_bt.tree.show import Outline, OutlineNode, dot_tree, mermaid_tree
from tests.tree.drawings import NASTY, random_outline, random_statuses

DOT_NODE = re.compile(r'^  n(\d+) \[label="((?:[^"\\]|\\.)*)", .*tooltip="(?:[^"\\]|\\.)*"\];$', re.MULTILINE)
DOT_EDGE = re.compile(r"^  n(\d+) -> n(\d+)", re.MULTILINE)
MERMAID_NODE = re.compile(
    r'^  n(\d+)(?:\[|\(|\{\{|\(\[|\[\[)"([^"\n]*)"(?:\]|\)|\}\}|\]\)|\]\]):::(\w+)$', re.MULTILINE
)
MERMAID_EDGE = re.compile(r'^  n(\d+) (?:-->|-\. "[^"\n]*" \.->) n(\d+)$', re.MULTILINE)


def edges(outline: Outline) -> list[tuple[str, str]]:
    return [(str(node.parent), str(index)) for index, node in enumerate(outline.nodes) if node.parent >= 0]


def decoded(label: str) -> str:
    """Return what Mermaid shows for a label."""
    return html.unescape(re.sub(r"#(\d+);", r"&#\1;", label)).replace("\u200b", "")


@pytest.mark.parametrize("seed", range(10))
def test_dot_has_every_node_and_edge_once(seed: int) -> None:
    outline = random_outline(seed)
    text = dot_tree(outline)
    assert [found[0] for found in DOT_NODE.findall(text)] == [str(index) for index in range(len(outline.nodes))]
    assert DOT_EDGE.findall(text) == edges(outline)


@pytest.mark.parametrize("seed", range(10))
def test_mermaid_is_lines_of_known_form_with_every_node_and_edge_once(seed: int) -> None:
    outline = random_outline(seed)
    text = mermaid_tree(outline, random_statuses(outline))
    first, *lines = text.splitlines()
    assert first == "flowchart TD"
    assert [found[0] for found in MERMAID_NODE.findall(text)] == [str(index) for index in range(len(outline.nodes))]
    assert MERMAID_EDGE.findall(text) == edges(outline)
    styles = [line for line in lines if re.fullmatch(r"  classDef \w+ fill:#\w{6},stroke:#\w{6},color:#\w{6}", line)]
    assert len(lines) == len(outline.nodes) + len(edges(outline)) + len(styles)


@pytest.mark.parametrize("text", NASTY)
def test_mermaid_shows_a_name_as_it_is(text: str) -> None:
    nodes = (
        OutlineNode("t/a", "a", "a", "decorator", -1),
        OutlineNode(f"t/{text}", text, "act", "skill", 0, text, (f"reason: {text}",)),
    )
    drawn = mermaid_tree(Outline("t", "", nodes), None, {nodes[1].path: text})
    label = MERMAID_NODE.findall(drawn)[1][1]
    rows = [decoded(re.sub(r"</?[bi]>", "", row)) for row in label.split("<br/>")]
    assert rows == [text, "(act)", f"reason: {text}", text]
    branch = re.search(r'-\. "(.*)" \.->', drawn)
    assert branch and decoded(branch[1]) == text
    assert not set(re.sub(r"<br/>|</?[bi]>|#\d+;", "", label)) & set('"<>#&;`*[]{}|$\\%')


@pytest.mark.parametrize("text", NASTY)
def test_dot_shows_a_name_as_it_is(text: str) -> None:
    drawn = dot_tree(Outline(text, "", (OutlineNode("t/a", text, text, "skill", -1),)))
    label = DOT_NODE.findall(drawn)[0][1]
    assert html.unescape(re.sub(r"\\(.)", r"\1", label)) == text


def test_statuses_colour_and_mark() -> None:
    outline = random_outline(3)
    statuses = random_statuses(outline)
    mermaid, dot = mermaid_tree(outline, statuses), dot_tree(outline, statuses)
    assert [style for _, _, style in MERMAID_NODE.findall(mermaid)] == [
        statuses[node.path].name.lower() for node in outline.nodes
    ]
    labels = [label for _, label, _ in MERMAID_NODE.findall(mermaid)] + [label for _, label in DOT_NODE.findall(dot)]
    marks = {"RUNNING": "▶", "SUCCESS": "✓", "FAILURE": "✗", "INVALID": "○"}
    assert [label[0] for label in labels] == [marks[statuses[node.path].name] for node in outline.nodes] * 2


def test_feedback_is_shown() -> None:
    outline = random_outline(3)
    said = {outline.nodes[2].path: "0.5 m to go"}
    assert mermaid_tree(outline, {}, said).count("<i>0.5 m to go</i>") == 1
    assert dot_tree(outline, {}, said).count('\\n0.5 m to go"') == 1


def test_an_unknown_kind_is_neutral() -> None:
    outline = Outline("t", "", (OutlineNode("t/x", "x", "x", "something new", -1),))
    assert ":::other" in mermaid_tree(outline)
    assert "shape=box" in dot_tree(outline)
