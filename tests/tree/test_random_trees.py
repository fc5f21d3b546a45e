"""What holds for every tree, tried on random ones."""

from __future__ import annotations

import random
from collections import Counter

import pytest
from py_trees.behaviour import Behaviour

from humanoid_bt.messages import Mode
from humanoid_bt.tree.ticking import INVALID, RUNNING
from humanoid_bt.workspace import Workspace
from tests.tree.helpers import Run, run, seen


def random_tree(rng: random.Random, depth: int) -> str:
    """Return a random tree in YAML's flow form."""
    kind = rng.randrange(11) if depth else 10
    if kind < 4:
        name = rng.choice(["sequence", "selector"])
        memory = rng.choice(["true", "false"])
        return f"{{{name}: {{memory: {memory}, children: [{children(rng, depth)}]}}}}"
    if kind < 6:
        return f"{{parallel: {{success: one, failure: all, children: [{children(rng, depth)}]}}}}"
    if kind < 10:
        head = rng.choice(
            [
                "inverter: {",
                "retry: {attempts: 2, ",
                "repeat: {times: 2, ",
                "timeout: {duration: 0.25, ",
                "emergency_stop: {",
                f"watchdog: {{percept: target, max_age: 0.15, on_stale: {random_tree(rng, depth - 1)}, ",
                "watchdog: {percept: target, max_age: 0.15, ",
            ]
        )
        return f"{{{head}{random_tree(rng, depth - 1)[1:-1]}}}}}"
    script = "".join(rng.choice("rrrsf") for _ in range(20))
    return f"{{act: {{name: leaf{rng.randrange(10**9)}, script: {script}}}}}"


def children(rng: random.Random, depth: int) -> str:
    return ", ".join(random_tree(rng, depth - 1) for _ in range(rng.randint(1, 3)))


def check(under_test: Run) -> None:
    """Check what must hold after every tick and halt."""
    for node in under_test.tree.root.iterate():
        if node.status is not RUNNING:
            assert not any(child.status is RUNNING for child in node.children), f"{node.name} left a child running"
        if node.status is INVALID:
            assert all(child.status is INVALID for child in node.children), f"{node.name} kept a child's result"
    alive: Counter[str] = Counter()
    for event, name in under_test.log:
        alive[name] += 1 if event == "start" else -1
        assert alive[name] in (0, 1), f"{name} was told {event} at the wrong time"
    running = {node.name for node in leaves(under_test) if node.status is RUNNING}
    assert running == {name for name, count in alive.items() if count}


def leaves(under_test: Run) -> list[Behaviour]:
    return [node.behaviour for node in under_test.tree.nodes if node.kind == "skill"]


@pytest.mark.parametrize("seed", range(60))
def test_no_node_is_forgotten_or_told_twice(workspace: Workspace, seed: int) -> None:
    rng = random.Random(seed)
    under_test = run(workspace, random_tree(rng, 4))
    told = dict.fromkeys((node.path for node in under_test.tree.nodes), INVALID)
    for _ in range(25):
        mode = rng.choice([Mode.RUN] * 12 + [Mode.PROTECTIVE_STOP, Mode.EMERGENCY_STOP])
        under_test.tick(seen(under_test.time) if rng.random() < 0.6 else {}, mode)
        check(under_test)
        if rng.random() < 0.1:
            under_test.executor.halt("test")
            check(under_test)
            assert under_test.executor.status is INVALID
        for change in under_test.changes:
            assert told[change.path] is not change.status
            told[change.path] = change.status
        assert told == {node.path: node.behaviour.status for node in under_test.tree.nodes}
