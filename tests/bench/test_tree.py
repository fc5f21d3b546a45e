"""The figures of trees, with few ticks: what is measured, not how much it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.bench import tree
from humanoid_bt.bench.promises import LOAD, TICK
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.tree.ticking.executor import NodeError
from tests.projects import make_project


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tree, "_TICKS", 3)
    monkeypatch.setattr(tree, "_LOADS", 1)
    monkeypatch.setattr(tree, "_LOADED", 10)


def test_ticks_and_loading_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    workspace = Workspace(builtin_root())
    figures = list(tree.measure_tree(workspace.find_tree("fetch"), workspace, 2))
    names = [figure.name.split(",")[0] for figure in figures]
    ticks = ["tick of fetch: 18 nodes"] * 2 + ["tick of a 40-node tree"]
    assert names == [*ticks, "load of a 10-node tree with all checks"]
    assert all(0 < figure.low <= figure.ratio <= figure.high for figure in figures)
    assert [figure.promise for figure in figures] == [TICK, None, TICK, LOAD]


def test_any_tree_can_be_measured_but_for_one_whose_skill_raises(tmp_path: Path) -> None:
    project = make_project(tmp_path / "project")
    for name, root in {
        "lost": "watchdog: {percept: ball, max_age: 1, pause: {}}",
        "bad": "emergency_stop: {leave: {after: 0 s}}",
        "typo": "puase",
    }.items():
        (project / "trees" / f"{name}.yaml").write_text(f"format: 1\nroot: {{{root}}}\n")
    workspace = Workspace(project)
    assert len(list(tree.measure_tree(workspace.find_tree("lost"), workspace, 1))) == 4
    with pytest.raises(NodeError, match="SystemExit"):
        list(tree.measure_tree(workspace.find_tree("bad"), workspace, 1))
    with pytest.raises(UserError, match="pause"):
        list(tree.measure_tree(workspace.find_tree("typo"), workspace, 1))
