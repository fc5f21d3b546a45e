"""The tree as it runs: what is drawn of it, when, and that it fits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from py_trees.common import Status

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.record import tree_view
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.subject import TreeView
from humanoid_bt.tree.show import Outline, OutlineNode, outline_of
from humanoid_bt.tree.show.looks import STATUS_COLORS
from humanoid_bt.tree.show.metrics import text_width
from humanoid_bt.tree.source.load import load_tree
from tests.record.conftest import OUTLINE
from tests.record.helpers import rows

Maker = Callable[..., Recorder]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.rrd"


def labels(file: Path) -> list[tuple[float, list[str]]]:
    return rows(file, "/tree/labels", "Points2D:labels")


def colors(file: Path, entity: str, component: str) -> list[list[tuple[int, ...]]]:
    """Return the colours of each row, without those that never change."""
    found = [value for time, value in rows(file, entity, component) if time >= 0]
    return [[tuple(color.to_bytes(4, "big")[:3]) for color in row] for row in found]


def test_a_change_is_drawn_with_status_parameters_and_reason(record: Maker, file: Path) -> None:
    with record() as recorder:
        recorder.node_changed(0.5, "root", "RUNNING", "")
        recorder.node_changed(0.5, "root/reach", "RUNNING", "0.3 m to go")
        recorder.node_changed(0.7, "root/reach", "FAILURE", "out of reach")
    assert labels(file) == [
        (0.0, ["○ root (selector)", "○ reach      target: ball", "○ ruhig ? (idle)"]),
        (0.5, ["▶ root (selector)", "▶ reach      target: ball", "○ ruhig ? (idle)"]),
        (0.7, ["▶ root (selector)", "✗ reach      out of reach", "○ ruhig ? (idle)"]),
    ]


def test_nodes_and_the_lines_to_them_have_the_colour_of_their_status(record: Maker, file: Path) -> None:
    with record() as recorder:
        recorder.node_changed(0.5, "root", "RUNNING", "")
        recorder.node_changed(0.5, "root/reach", "FAILURE", "")
    running, failure, invalid = (STATUS_COLORS[name].dark for name in ("RUNNING", "FAILURE", "INVALID"))
    assert colors(file, "/tree/boxes", "Boxes2D:colors") == [[invalid] * 3, [running, failure, invalid]]
    assert colors(file, "/tree/edges", "LineStrips2D:colors") == [[invalid] * 2, [failure, invalid]]


def test_a_child_stands_below_its_parent_and_further_right(record: Maker, file: Path) -> None:
    record().close()
    ((_, centers),) = rows(file, "/tree/boxes", "Boxes2D:centers")
    ((_, sizes),) = rows(file, "/tree/boxes", "Boxes2D:half_sizes")
    left = [x - width for (x, _), (width, _) in zip(centers, sizes, strict=True)]
    assert left[0] < left[1] == pytest.approx(left[2])
    assert centers[0][1] < centers[1][1] < centers[2][1]


def test_another_tree_takes_the_place_of_the_one_before(record: Maker, file: Path) -> None:
    new = replace(OUTLINE, nodes=(OUTLINE.nodes[0], OutlineNode("root/walk", "walk", "walk", "skill", 0)))
    with record() as recorder:
        recorder.node_changed(0.1, "root/ruhig ä", "RUNNING", "")
        recorder.show_tree(1.0, TreeView(new, "root: {sequence: []}", "trees/small.yaml"), {"parameters": "a = 2"})
        recorder.node_changed(1.5, "root/walk", "RUNNING", "")
        with pytest.raises(HumanoidBtError, match="no node"):
            recorder.node_changed(1.6, "root/ruhig ä", "RUNNING", "")
    assert labels(file)[-2:] == [
        (1.0, ["○ root (selector)", "○ walk"]),
        (1.5, ["○ root (selector)", "▶ walk"]),
    ]
    documents = rows(file, "/documents/tree", "TextDocument:text")
    assert [(time, "sequence" in text) for time, (text,) in documents] == [(0.0, False), (1.0, True)]
    run = rows(file, "/documents/run", "TextDocument:text")
    assert [(time, "| parameters | a = 2 |" in text) for time, (text,) in run] == [(0.0, False), (1.0, True)]


def test_a_tree_of_one_node_takes_the_lines_away(record: Maker, file: Path) -> None:
    with record() as recorder:
        recorder.show_tree(1.0, TreeView(replace(OUTLINE, nodes=OUTLINE.nodes[:1])), {})
    strips = rows(file, "/tree/edges", "LineStrips2D:strips")
    assert [(time, len(lines)) for time, lines in strips] == [(0.0, 2), (1.0, 0)]


def chain(length: int) -> Outline:
    """Return a tree of sequences in each other, each with a condition before it."""
    nodes = [OutlineNode("t/0", "s0", "sequence", "composite", -1)]
    for depth in range(1, length):
        parent = 0 if depth == 1 else 2 * depth - 2
        nodes.append(OutlineNode(f"t/c{depth}", f"c{depth}", "condition", "condition", parent))
        nodes.append(OutlineNode(f"t/{depth}", f"s{depth}", "sequence", "composite", parent))
    return Outline("t", "", tuple(nodes))


def tour() -> Outline:
    workspace = Workspace(builtin_root())
    return outline_of(load_tree(workspace.find_tree("tour"), workspace))


@pytest.mark.parametrize("outline", [tour(), chain(40)], ids=["tour", "chain"])
@pytest.mark.parametrize("kind", ["skill", "composite"])
def test_any_tree_fits_with_what_runs(record: Maker, file: Path, outline: Outline, kind: str) -> None:
    """The deepest node of a kind runs, and all above it."""
    deepest = max((n for n in outline.nodes if n.kind in (kind, "composite")), key=lambda node: node.path.count("/"))
    index = outline.nodes.index(deepest)
    with record() as recorder:
        recorder.show_tree(1.0, TreeView(outline), {})
        while index >= 0:
            recorder.node_changed(2.0, outline.nodes[index].path, "RUNNING", "")
            index = outline.nodes[index].parent
    shown = labels(file)[-1][1]
    assert any(text.startswith("▶") and deepest.name in text for text in shown)
    _, centers = rows(file, "/tree/boxes", "Boxes2D:centers")[-1]
    _, halves = rows(file, "/tree/boxes", "Boxes2D:half_sizes")[-1]
    width, height = tree_view.SIZE
    for (x, y), (dx, dy) in zip(centers, halves, strict=True):
        assert x - dx >= 0
        assert y - dy >= 0
        assert x + dx <= width + 20
        assert y + dy <= height


def test_sub_trees_are_called_by_their_names_and_roles_are_said(record: Maker, file: Path) -> None:
    outline = tour()
    with record() as recorder:
        recorder.show_tree(0.5, TreeView(outline), {})
        for node in outline.nodes:
            if next(other for other in outline.nodes if other.name == "offer").path.startswith(node.path):
                recorder.node_changed(1.0, node.path, "RUNNING", "")
    assert labels(file)[-1][1][0].startswith("▶ emergency_stop / patrol / repeat / for_each / visit")
    watchdog = OutlineNode("w", "watchdog", "watchdog", "decorator", -1)
    idle = OutlineNode("w/idle", "idle", "idle", "skill", 0, branch="on_stale")
    with record() as recorder:
        recorder.show_tree(1.0, TreeView(Outline("w", "", (watchdog, idle))), {})
    assert labels(file)[-1][1] == ["○ watchdog", "○ on_stale: idle"]


def test_a_long_label_is_cut(record: Maker, file: Path) -> None:
    node = OutlineNode("t", "act", "act", "skill", -1, parameters=("text: " + "long " * 80,))
    with record() as recorder:
        recorder.show_tree(1.0, TreeView(Outline("t", "", (node,))), {})
    (text,) = labels(file)[-1][1]
    whole = "○ act" + tree_view._GAP + node.parameters[0]
    assert whole.startswith(text.removesuffix("..."))
    longer = whole[: len(text) - 2] + "..."
    widths = [tree_view._PAD + text_width(label, tree_view._LETTERS) for label in (text, longer)]
    assert widths[0] <= tree_view.SIZE[0] < widths[1]


def test_what_a_node_says_at_length_takes_no_time(record: Maker, monkeypatch: pytest.MonkeyPatch) -> None:
    measured: list[int] = []

    def measure(text: str, size: float) -> float:
        measured.append(len(text))
        return text_width(text, size)

    monkeypatch.setattr(tree_view, "text_width", measure)
    with record() as recorder:
        recorder.node_changed(1.0, "root/reach", "FAILURE", "long " * 800)
    assert sum(measured) < 20 * 4000


@pytest.mark.parametrize(("path", "status"), [("root/reech", "RUNNING"), ("root", "DONE")])
def test_unknown_nodes_and_statuses_are_refused(record: Maker, path: str, status: str) -> None:
    with record() as recorder, pytest.raises(HumanoidBtError, match=r"did you mean|valid"):
        recorder.node_changed(0.0, path, status, "")


def test_every_status_has_a_colour() -> None:
    assert set(STATUS_COLORS) == set(Status.__members__)
