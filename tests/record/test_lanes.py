"""Lanes and events: what nodes and robot did, in words."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from humanoid_bt.core.messages import Mode
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.record import lanes
from humanoid_bt.record.names import short_names
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.subject import TreeView
from humanoid_bt.tree.show import Outline, OutlineNode, outline_of
from humanoid_bt.tree.show.looks import mix
from humanoid_bt.tree.source.load import load_tree
from tests.record.conftest import OUTLINE
from tests.record.helpers import entities, events, make_state, rows
from tests.tree.show.test_contrast import ENOUGH, contrast

Maker = Callable[..., Recorder]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.rrd"


def states(file: Path, entity: str) -> list[tuple[float, str]]:
    return [(time, state) for time, (state,) in rows(file, entity, "StateChange:state")]


def test_a_lane_begins_when_something_happens_on_it(record: Maker, file: Path) -> None:
    with record() as recorder:
        recorder.node_changed(0.5, "root/reach", "RUNNING", "")
        recorder.node_changed(0.7, "root/reach", "INVALID", "halted")
        recorder.node_changed(0.9, "root/ruhig ä", "SUCCESS", "at once: only an event")
    assert states(file, "/actions/1-reach") == [(0.5, "RUNNING"), (0.7, "INVALID")]
    groups = tuple(f"/{group}/" for group in lanes.GROUPS)
    assert [entity for entity in entities(file) if entity.startswith(groups)] == ["/actions/1-reach"]


def test_mode_gait_and_limits_have_lanes(record: Maker, file: Path) -> None:
    with record() as recorder:
        for tick in range(4):
            recorder.sample(make_state(tick * 0.02, mode=Mode.RUN if tick < 2 else Mode.DAMP), {}, {})
    assert states(file, "/body/mode") == [(0.0, "run"), (0.04, "damp")]
    assert states(file, "/body/gait") == [(0.0, "stand")]
    assert "/body/limits" not in entities(file)


def test_another_tree_ends_what_ran_and_nodes_of_one_path_keep_their_lanes(record: Maker, file: Path) -> None:
    walk = OutlineNode("root/walk", "walk", "walk", "skill", 0)
    new = replace(OUTLINE, nodes=(OUTLINE.nodes[0], walk, OUTLINE.nodes[1]))
    with record() as recorder:
        recorder.node_changed(0.1, "root/ruhig ä", "RUNNING", "")
        recorder.node_changed(0.1, "root/reach", "RUNNING", "")
        recorder.show_tree(1.0, TreeView(new), {})
        recorder.node_changed(1.5, "root/reach", "RUNNING", "")
        recorder.node_changed(1.5, "root/walk", "RUNNING", "")
    assert states(file, "/actions/2-ruhig__") == [(0.1, "RUNNING"), (1.0, "INVALID")]
    assert states(file, "/actions/1-reach") == [(0.1, "RUNNING"), (1.0, "INVALID"), (1.5, "RUNNING")]
    assert states(file, "/actions/3-walk") == [(1.5, "RUNNING")]


def test_lanes_of_one_name_are_two(record: Maker, file: Path) -> None:
    twins = [OutlineNode(f"t/{name}", name, "act", "skill", 0) for name in ("a b", "a_b")]
    outline = Outline("t", "", (OutlineNode("t", "t", "sequence", "composite", -1), *twins))
    with record() as recorder:
        recorder.show_tree(0.0, TreeView(outline), {})
        for node in twins:
            recorder.node_changed(1.0, node.path, "RUNNING", "")
    assert {"/actions/1-a_b", "/actions/2-a_b"} <= entities(file)


@pytest.mark.parametrize("tree", ["fetch", "tour"])
def test_names_are_short_and_no_two_are_alike(tree: str) -> None:
    workspace = Workspace(builtin_root())
    names = short_names(outline_of(load_tree(workspace.find_tree(tree), workspace)))
    assert len(set(names.values())) == len(names)
    assert max(map(len, names.values())) < 70
    assert not any("/" in name for name in names.values())


def test_a_name_says_role_or_place_where_it_must(tmp_path: Path) -> None:
    workspace = Workspace(builtin_root())
    file = tmp_path / "watch.yaml"
    file.write_text(
        "format: 1\nroot: {emergency_stop: {watchdog: {percept: p, max_age: 1, on_stale: idle, idle: {}}}}\n"
    )
    watch = short_names(outline_of(load_tree(file, workspace)))
    assert {"idle", "on_stale: idle", "watchdog"} <= set(watch.values())
    tour = set(short_names(outline_of(load_tree(workspace.find_tree("tour"), workspace))).values())
    assert {"search", "wait (give)", "wait (look around)", "wait (look around) 2", "retract (greet)"} <= tour


def test_words_on_lanes_can_be_read_in_both_themes() -> None:
    """The viewer dims a lane by a fifth towards its background, and writes in black on what is light."""
    looks = [lanes._STATUS, *lanes._BODY.values()]
    for color in {color for look in looks for color in look.values()} - {lanes._HIDDEN}:
        assert (0.299 * color[0] + 0.587 * color[1] + 0.114 * color[2]) / 255 > 0.6, color
        for paper in ((0, 0, 0), (255, 255, 255)):
            assert contrast(mix(color, paper, 200 / 255), (0, 0, 0)) >= ENOUGH


def test_events_are_of_leaves_and_the_rest_is_for_those_who_ask(record: Maker, file: Path) -> None:
    with record() as recorder:
        recorder.node_changed(0.1, "root/reach", "RUNNING", "0.3 m to go")
        recorder.node_changed(0.1, "root", "RUNNING", "")
        recorder.event(0.1, "info", "scene: ball hidden")
        recorder.node_changed(0.5, "root/reach", "INVALID", "halted: the run is over")
        recorder.node_changed(0.5, "root/ruhig ä", "INVALID", "")
    assert events(file) == [
        (0.1, "INFO", "▶ reach: 0.3 m to go"),
        (0.1, "DEBUG", "▶ root"),
        (0.1, "INFO", "scene: ball hidden"),
        (0.5, "INFO", "○ reach: halted: the run is over"),
        (0.5, "DEBUG", "○ ruhig ?"),
    ]
    paths = [path for _, (path,) in rows(file, "/events", "node")]
    assert paths == ["root/reach", "root", "", "root/reach", "root/ruhig ?"]


def test_lanes_are_called_with_words(record: Maker, file: Path) -> None:
    workspace = Workspace(builtin_root())
    outline = outline_of(load_tree(workspace.find_tree("tour"), workspace))
    with record() as recorder:
        recorder.show_tree(0.0, TreeView(outline), {})
        for node in outline.nodes:
            recorder.node_changed(1.0, node.path, "RUNNING", "")
    groups = tuple(f"/{group}/" for group in lanes.GROUPS)
    found = [entity for entity in entities(file) if entity.startswith(groups)]
    assert len(found) == len(outline.nodes)
    words = {re.sub(r"/\d+-", "/", entity) for entity in found}
    assert {"/actions/wait-in-give", "/flow/receive_a_visitor", "/conditions/confident"} <= words
    assert "\\" not in "".join(found)


def test_what_ran_first_comes_first(record: Maker, file: Path) -> None:
    """The viewer sorts lanes by name, and numbers in names as numbers."""
    nodes = [OutlineNode(f"t/{name}", name, "act", "skill", 0) for name in "abcdefghijkl"]
    outline = Outline("t", "", (OutlineNode("t", "t", "sequence", "composite", -1), *nodes))
    with record() as recorder:
        recorder.show_tree(0.0, TreeView(outline), {})
        for time, node in enumerate(reversed(nodes)):
            recorder.node_changed(float(time), node.path, "RUNNING", "")
    found = [entity.removeprefix("/actions/") for entity in entities(file) if entity.startswith("/actions/")]
    numbers = {int(name.split("-")[0]): name for name in found}
    assert [numbers[i] for i in sorted(numbers)] == [f"{i}-{name}" for i, name in enumerate("lkjihgfedcba", 1)]
