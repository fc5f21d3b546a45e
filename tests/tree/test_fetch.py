"""The demo tree: what it does, and that no damage to its text is answered with a traceback."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.tree import Tree
from tests.tree.helpers import Run, seen

FETCH = Path(__file__).parents[2] / "trees" / "fetch.yaml"
LOOKING = "repeat/look for target/timeout/idle"


@pytest.fixture
def tree(workspace: Workspace) -> Tree:
    return load_tree(FETCH, workspace)


def running(under_test: Run) -> str:
    """Return the paths of the skills that run, without what they share."""
    return " ".join(
        node.path.removeprefix("fetch/emergency_stop/reactive_selector/")
        for node in under_test.tree.nodes
        if node.kind == "skill" and node.behaviour.status.name == "RUNNING"
    )


def test_it_says_what_it_is_for(tree: Tree) -> None:
    assert (tree.name, tree.robot, tree.scene) == ("fetch", "humanoid", "ball_on_stand")
    assert tree.parameters["min_confidence"] == 0.6


def test_the_demo_goes_as_told(tree: Tree) -> None:
    fetch, above = Run(tree), "watchdog"
    fetch.tick()
    assert running(fetch) == LOOKING  # never seen
    fetch.tick(seen(fetch.time, 1.2, 0.5))
    assert running(fetch) == LOOKING  # doubtful
    fetch.tick(seen(fetch.time, 1.2, 0.65))
    assert running(fetch) == f"{above}/act on target/get near/approach"
    fetch.tick(seen(fetch.time, 0.45, 0.55))
    assert running(fetch) == f"{above}/act on target/get near/approach"  # it walks all the way, and hysteresis holds
    fetch.tick(seen(fetch.time, 0.39, 0.9))
    assert running(fetch) == f"{above}/act on target/touch/reach"
    fetch.tick(seen(fetch.time, 0.45, 0.9))
    fetch.tick(seen(fetch.time, 0.52, 0.9))
    assert running(fetch) == f"{above}/act on target/touch/reach"  # hysteresis again
    fetch.ticks(6)
    assert running(fetch) == LOOKING  # lost
    fetch.tick(seen(fetch.time, 0.52, 0.9))
    assert running(fetch) == f"{above}/act on target/get near/approach"


def test_parameters_can_be_set(workspace: Workspace) -> None:
    tree = load_tree(FETCH, workspace, {"target": "cup", "stop_distance": "30 cm"})
    assert tree.parameters["stop_distance"] == pytest.approx(0.3)
    assert tree.nodes[2].values["percept"] == "cup"


def mutated(text: str, rng: random.Random) -> str:
    """Return the text with one to three random damages."""
    for _ in range(rng.randint(1, 3)):
        at = rng.randrange(len(text))
        lines = text.splitlines(keepends=True)
        line = rng.randrange(len(lines))
        damage = rng.randrange(7)
        if damage == 0:
            text = text[:at] + text[at + rng.randint(1, 6) :]
        elif damage == 1:
            text = text[:at] + rng.choice("{}[]:,#&*!|>'\"%@`$- \t\n\0é\u2028~?=<") + text[at:]
        elif damage == 2:
            lines.insert(rng.randrange(len(lines)), lines[line])
            text = "".join(lines)
        elif damage == 3:
            lines[line] = rng.choice([" ", "  ", "    "]) + lines[line]
            text = "".join(lines)
        elif damage == 4:
            del lines[line]
            text = "".join(lines)
        elif damage == 5:
            words = text.split(" ")
            words[rng.randrange(len(words))] = rng.choice(
                [
                    "idle",
                    "$target",
                    "null",
                    "{}",
                    "[]",
                    "-1",
                    ".inf",
                    "<<:",
                    "&a",
                    "*a",
                    "!!python/name:os",
                    "1e99",
                    "- -",
                ]
            )
            text = " ".join(words)
        else:
            lines[line] = lines[line].lstrip()
            text = "".join(lines)
    return text


def test_damaged_text_is_loaded_or_answered_with_places(workspace: Workspace) -> None:
    rng, text = random.Random(20250), FETCH.read_text(encoding="utf-8")
    path = workspace.root / "trees" / "fetch.yaml"
    loaded = refused = 0
    for number in range(250):
        damaged = mutated(text, rng)
        path.write_text(damaged, encoding="utf-8")
        try:
            load_tree(path, workspace)
            loaded += 1
        except UserError as error:
            refused += 1
            assert error.problems
            for problem in error.problems:
                assert problem.message
                assert problem.place is not None and problem.place.line > 0, f"{number}: {problem}\n{damaged}"
    assert loaded > 10 and refused > 125
