"""What holds for every tree, tried on random ones."""

from __future__ import annotations

import random
from collections import Counter

import pytest
from py_trees.behaviour import Behaviour

from humanoid_bt.core.messages import Mode
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, RUNNING, SUCCESS
from tests.tree.helpers import Run, load, seen

KEY = "k"
"""A key that random trees write and ask for."""

CONDITIONS = ["state.time < 0.8 s", f"{KEY} == 'running'", f"not ({KEY} == 'failure')", "true"]

DECORATORS = [
    "inverter: {",
    "retry: {attempts: 2, ",
    "repeat: {times: 2, ",
    "timeout: {duration: 0.25, ",
    "emergency_stop: {",
    "watchdog: {percept: target, max_age: 0.15, ",
    "force_success: {",
    "force_failure: {",
    "keep_running_until_failure: {",
    "running_is_failure: {",
    "running_is_success: {",
    "failure_is_running: {",
    "success_is_running: {",
    "delay: {duration: 0.2 s, ",
    "cooldown: {duration: 0.2 s, ",
    "min_duration: {duration: 0.3 s, ",
    "once: {",
    "once: {policy: success, ",
    f"status_to_blackboard: {{key: {KEY}, ",
    "for_each: {item: n, items: [1, 2], ",
]


def random_tree(rng: random.Random, depth: int, caught: bool = False) -> str:
    """Return a random tree in YAML's flow form; nodes in it raise if something above catches that."""
    if not depth or rng.random() < 0.06:
        return leaf(rng, caught)
    makers = [sequence] * 3 + [parallel] * 2 + [choice] * 2 + [on_error] + [conditional] * 2 + [decorator] * 7
    return rng.choice(makers)(rng, depth - 1, caught)


def leaf(rng: random.Random, caught: bool) -> str:
    script = "".join(rng.choice("rrrsfx" if caught else "rrrsf") for _ in range(20))
    kind = "bad_end" if caught and rng.random() < 0.2 else "act"
    return f"{{{kind}: {{name: leaf{rng.randrange(10**9)}, script: {script}}}}}"


def sequence(rng: random.Random, depth: int, caught: bool) -> str:
    """Return a random sequence or selector."""
    kind = rng.choice(["sequence", "selector", "reactive_sequence", "reactive_selector"])
    return f"{{{kind}: [{children(rng, depth, caught)}]}}"


def parallel(rng: random.Random, depth: int, caught: bool) -> str:
    return f"{{parallel: {{success: one, failure: all, children: [{children(rng, depth, caught)}]}}}}"


def decorator(rng: random.Random, depth: int, caught: bool) -> str:
    head = rng.choice(DECORATORS)
    if head.startswith("watchdog") and rng.random() < 0.5:
        head += f"on_stale: {random_tree(rng, depth, caught)}, "
    return f"{{{head}{random_tree(rng, depth, caught)[1:-1]}}}}}"


def on_error(rng: random.Random, depth: int, caught: bool) -> str:
    return f"{{on_error: {random_tree(rng, depth, True)}}}"


def conditional(rng: random.Random, depth: int, caught: bool) -> str:
    kind, child = rng.choice(["while", "guard", "precondition"]), random_tree(rng, depth, caught)
    return f"{{{kind}: {{condition: {condition(rng, depth, caught)}, {child[1:-1]}}}}}"


def condition(rng: random.Random, depth: int, caught: bool) -> str:
    return f'"{rng.choice(CONDITIONS)}"' if rng.random() < 0.5 else random_tree(rng, depth, caught)


def choice(rng: random.Random, depth: int, caught: bool) -> str:
    """Return a random ``if`` or ``switch``, reactive or not."""
    reactive = rng.choice(["", "reactive_"])
    one, two = (random_tree(rng, depth, caught) for _ in range(2))
    if rng.random() < 0.5:
        otherwise = f", else: {two}" if rng.random() < 0.7 else ""
        return f"{{{reactive}if: {{condition: {condition(rng, depth, caught)}, then: {one}{otherwise}}}}}"
    default = f", default: {random_tree(rng, depth, caught)}" if rng.random() < 0.5 else ""
    return f"{{{reactive}switch: {{value: {KEY}, cases: {{running: {one}, success: {two}}}{default}}}}}"


def children(rng: random.Random, depth: int, caught: bool) -> str:
    return ", ".join(random_tree(rng, depth, caught) for _ in range(rng.randint(1, 3)))


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


@pytest.mark.parametrize("seed", range(120))
def test_no_node_is_forgotten_or_told_twice(workspace: Workspace, seed: int) -> None:
    rng = random.Random(seed)
    under_test = Run(load(workspace, f"blackboard: {{{KEY}: running}}\nroot: {random_tree(rng, 4)}\n"))
    told = dict.fromkeys((node.path for node in under_test.tree.nodes), INVALID)
    for _ in range(25):
        mode, before = rng.choice([Mode.RUN] * 12 + [Mode.PROTECTIVE_STOP, Mode.EMERGENCY_STOP]), len(under_test.log)
        under_test.tick(seen(under_test.time) if rng.random() < 0.6 else {}, mode)
        check(under_test)
        started = {name for event, name in under_test.log[before:] if event == "start"}
        if rng.random() < 0.1:
            under_test.executor.halt("test")
            check(under_test)
            assert under_test.executor.status is INVALID
        for change in under_test.changes:
            ended = change.status in (SUCCESS, FAILURE) and change.path.rpartition("/")[2] in started
            halted = change.status is INVALID and bool(change.feedback)
            assert ended or halted or told[change.path] is not change.status
            told[change.path] = change.status
        assert told == {node.path: node.behaviour.status for node in under_test.tree.nodes}
