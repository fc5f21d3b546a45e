from __future__ import annotations

import py_trees
from py_trees.common import Status

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.show import dot_tree, unicode_tree
from humanoid_bt.tree.tree import Tree
from tests.tree.helpers import load

TEXT = """
name: demo
description: Show what a tree looks like.
root:
  emergency_stop:
    watchdog:
      percept: target
      max_age: 500 ms
      on_stale: idle
      sequence:
        name: go there
        children:
          - within: {percept: target, distance: 0.5, bearing: 0.4, hysteresis: 0.05}
          - approach: {target: target}
"""


def demo(workspace: Workspace) -> Tree:
    return load(workspace, TEXT)


def test_unicode_tree_shows_names_types_and_the_parameters_of_the_file(workspace: Workspace) -> None:
    assert unicode_tree(demo(workspace)) == (
        "demo: Show what a tree looks like.\n"
        "└─ emergency_stop\n"
        "   └─ watchdog  percept: target, max_age: 500 ms\n"
        "      ├─ go there (sequence)\n"
        "      │  ├─ within  percept: target, distance: 0.5 m, hysteresis: 0.05 m,\n"
        "      │  │       bearing: 0.4 rad\n"
        "      │  └─ approach  target: target\n"
        "      └─ on_stale: idle"
    )


def test_unicode_tree_marks_statuses(workspace: Workspace) -> None:
    statuses = {"demo/emergency_stop": Status.RUNNING, "demo/emergency_stop/watchdog/idle": Status.FAILURE}
    lines = unicode_tree(demo(workspace), statuses).splitlines()
    assert lines[1] == "└─ ▶ emergency_stop"
    assert lines[2].startswith("   └─ ○ watchdog")
    assert lines[-1] == "      └─ ✗ on_stale: idle"


def test_unicode_tree_breaks_between_parameters_to_fit(workspace: Workspace) -> None:
    lines = unicode_tree(demo(workspace), width=40).splitlines()
    assert max(map(len, lines)) <= 40
    assert [line.strip(" │") for line in lines[6:10]] == [
        "distance: 0.5 m,",
        "hysteresis: 0.05 m,",
        "bearing: 0.4 rad",
        "└─ approach  target: target",
    ]


def test_dot_tree_has_every_node_and_edge(workspace: Workspace) -> None:
    tree = demo(workspace)
    dot = dot_tree(tree)
    assert dot.startswith('digraph "demo" {') and dot.rstrip().endswith("}")
    assert dot.count("[label=") - dot.count("style=dashed") == len(tree.nodes)
    assert dot.count("->") == len(tree.nodes) - 1
    assert '[label="on_stale", style=dashed]' in dot


def test_dot_tree_quotes_names(workspace: Workspace) -> None:
    dot = dot_tree(load(workspace, "root: {plain: {name: 'say \"hi\" \\ there'}}"))
    assert r"say \"hi\" \\ there" in dot


def test_py_trees_can_draw_it_too(workspace: Workspace) -> None:
    root = load(workspace, "root: {parallel: [act, {selector: [act]}]}").root
    assert "/_/ parallel" in py_trees.display.unicode_tree(root)
    assert "parallel" in py_trees.display.dot_tree(root).to_string()


def test_a_long_value_is_broken_between_its_words(workspace: Workspace) -> None:
    text = "root: {for_each: {item: k, items: [first place, second place, third place, fourth place], act: }}"
    lines = unicode_tree(load(workspace, text), width=40).splitlines()
    assert max(map(len, lines)) <= 40
    joined = " ".join(" ".join(lines).replace("│", " ").split())
    assert "items: [first place, second place, third place, fourth place]" in joined
