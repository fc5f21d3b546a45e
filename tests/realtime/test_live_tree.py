"""Telling others what a tree does, and seeing it."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from py_trees.common import Status

from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.link import run_folder
from humanoid_bt.link.run_folder import RunFolder, RunInfo
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.live_tree import TreeTeller, TreeWatch
from humanoid_bt.tree.show import outline_of
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.tree import Tree


@pytest.fixture(autouse=True)
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where runs live: not where those of a real robot do."""
    root = tmp_path / "runs"
    monkeypatch.setattr(run_folder, "default_root", lambda: root)
    return root


@pytest.fixture
def tree() -> Tree:
    workspace = Workspace(builtin_root())
    return load_tree(workspace.find_tree("fetch"), workspace)


@pytest.fixture
def folder() -> Iterator[RunFolder]:
    with RunFolder.create(RunInfo("fetch", "humanoid")) as folder:
        channels.create_channels(folder)
        yield folder


def does(tree: Tree, name: str, status: Status, feedback: str) -> str:
    """Let a node do something; return its path."""
    node = next(node for node in tree.nodes if node.name == name)
    node.behaviour.status, node.behaviour.feedback_message = status, feedback
    return node.path


def test_what_is_told_is_seen(folder: RunFolder, tree: Tree) -> None:
    teller, watch = TreeTeller(folder), TreeWatch(folder)
    walks = does(tree, "approach", Status.RUNNING, "1.2 m to go")
    fails = does(tree, "within", Status.FAILURE, "1.6 m > 0.5 m")
    sure = does(tree, "confident", Status.SUCCESS, "0.9 > 0.6")
    teller.tell({"time": 1.5}, tree)
    moment = watch.latest()
    assert moment is not None
    assert (moment.outline, moment.time) == (outline_of(tree), 1.5)
    assert {path: status for path, status in moment.statuses.items() if status is not Status.INVALID} == {
        walks: Status.RUNNING,
        fails: Status.FAILURE,
        sure: Status.SUCCESS,
    }
    assert moment.feedback == {walks: "1.2 m to go", fails: "1.6 m > 0.5 m"}
    does(tree, "approach", Status.INVALID, "")
    teller.tell({"time": 1.7}, tree)
    moment = watch.latest()
    assert moment is not None
    assert moment.statuses[walks] is Status.INVALID
    teller.close()
    watch.close()


def test_a_tree_that_takes_the_place_of_another_is_seen(folder: RunFolder, tree: Tree) -> None:
    teller, watch = TreeTeller(folder), TreeWatch(folder)
    teller.tell({"time": 1.0}, tree)
    assert watch.latest() is not None
    other = dataclasses.replace(tree, nodes=tree.nodes[:3])
    teller.tell({"time": 2.0}, other)
    moment = watch.latest()
    assert moment is not None
    assert (moment.outline, moment.time) == (outline_of(other), 2.0)
    teller.close()
    watch.close()


def test_nothing_is_seen_before_anything_is_told(folder: RunFolder, tree: Tree) -> None:
    watch = TreeWatch(folder)
    assert watch.latest() is None
    channels.writer(folder, "status").write(json.dumps({"time": 1.0}).encode())
    assert watch.latest() is None
    assert not watch.over


def test_what_was_told_last_stays_until_the_run_is_over(folder: RunFolder, tree: Tree) -> None:
    watch = TreeWatch(folder)
    TreeTeller(folder).tell({"time": 1.0}, tree)
    assert watch.latest() is not None
    assert not watch.abandoned
    folder.close()
    assert watch.over


def last_told(folder: RunFolder) -> dict[str, object]:
    latest = channels.reader(folder, "status").latest()
    assert latest is not None
    message: dict[str, object] = json.loads(latest[1])
    return message


def test_a_message_that_is_too_long_leaves_out_what_nodes_say_then_statuses(folder: RunFolder, tree: Tree) -> None:
    does(tree, "approach", Status.RUNNING, "on " * 100)
    teller = TreeTeller(folder)

    def told(nodes: int) -> dict[str, object]:
        many = dataclasses.replace(tree, nodes=tree.nodes * (nodes // len(tree.nodes)))
        teller.tell({"time": 1.0, "node": "approach", "percepts": {"target": 0.1}}, many)
        return last_told(folder)

    assert {"feedback_of", "statuses", "node"} <= told(100).keys()
    assert told(2_000).keys() == {"time", "node", "outline", "statuses", "percepts"}
    assert told(20_000).keys() == {"time", "node", "outline", "percepts"}


@pytest.mark.parametrize("long", ["unseen", "percepts"])
def test_statuses_are_told_whatever_else_would_not_fit(folder: RunFolder, tree: Tree, long: str) -> None:
    status = {"time": 1.0, "unseen": {}, "percepts": {}} | {long: {f"tag_{number}": "no" * 20 for number in range(587)}}
    TreeTeller(folder).tell(status, tree)
    told = last_told(folder)
    assert "statuses" in told
    assert long not in told
