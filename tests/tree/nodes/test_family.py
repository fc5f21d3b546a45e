"""What is answered where a node made in Python is given something else than its children."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from py_trees.behaviour import Behaviour

import humanoid_bt as hbt
from humanoid_bt.core.errors import UserError
from humanoid_bt.tree.nodes import (
    Guard,
    If,
    Inverter,
    Log,
    Parallel,
    Precondition,
    Selector,
    Sequence,
    Switch,
    Timeout,
    Wait,
    Watchdog,
    While,
)
from humanoid_bt.tree.show import svg_tree


def wait() -> Wait:
    return Wait("w", duration=1.0)


def twice() -> None:
    node = wait()
    Sequence("s", [Sequence("a", [node]), Selector("b", [node])])


def deep() -> Behaviour:
    node: Behaviour = wait()
    for number in range(2000):
        node = Inverter(f"i{number}", node)
    return node


MISTAKES: list[tuple[Callable[[], object], str]] = [
    (lambda: Sequence("s", wait()), "the children of Sequence 's' must be a list of nodes, not the node 'w'"),
    (lambda: Sequence("s", "idle"), "must be a list of nodes, not text"),
    (lambda: Sequence("s", [None]), "a child of Sequence 's' must be a node, not None"),
    (lambda: Parallel("p", [Wait]), "a child of Parallel 'p' must be a node, not the class Wait"),
    (lambda: Sequence([wait()], []), "Sequence needs a name, and a list stands where it is expected"),
    (lambda: Sequence("s", [node := wait(), node]), "the node 'w' is given to Sequence 's', and stands in a tree"),
    (twice, "the node 'w' is given to Selector 'b', and stands in a tree already"),
    (lambda: Timeout("t", None, duration=1.0), "the child of Timeout 't' must be a node, not None"),
    (lambda: Timeout("t", [wait()], duration=1.0), "the child of Timeout 't' must be a node, not a list"),
    (lambda: If("i", condition=wait(), then=Wait), "a child of If 'i' must be a node, not the class Wait"),
    (lambda: If("i", condition=None, then=wait()), "the condition of If 'i' must be a node, not None"),
    (lambda: If("i", condition=wait(), then=wait(), else_=""), "a child of If 'i' must be a node, not text"),
    (lambda: Switch("s", {1: wait()}, "", value="n"), "a child of Switch 's' must be a node, not text"),
    (lambda: Guard("g", wait(), condition="1 < 2"), "the condition of Guard 'g' must be a node, not text"),
    (lambda: While("w", wait(), condition=Wait), "the condition of While 'w' must be a node, not the class Wait"),
    (lambda: Precondition("p", wait(), condition=None), "the condition of Precondition 'p' must be a node, not None"),
    (
        lambda: Watchdog("w", wait(), "idle", percept="p", max_age=1.0),
        "the on_stale of Watchdog 'w' must be a node, not text",
    ),
    (
        lambda: Switch("s", [wait()], value="n"),
        "the cases of Switch 's' must be a mapping of values to nodes, not a list",
    ),
    (lambda: Switch("s", {None: wait()}, value="n"), "None cannot be a case of Switch 's'"),
    (lambda: Switch("s", {True: wait(), "true": wait()}, value="n"), "two cases of Switch 's' are true"),
    (lambda: hbt.make_tree(deep()), "the nodes of the tree are nested too deeply"),
    (lambda: hbt.make_tree(Wait), "the root of a tree must be a node, not the class Wait"),
    (lambda: hbt.make_tree(3), "the root of a tree must be a node, not 3"),
    (lambda: hbt.load("stand").node(3), "a node is named by its path, not by 3"),
    (lambda: hbt.check(3), "3 cannot be checked"),
    (hbt.run, "which tree?"),
    (lambda: svg_tree("seq"), "only a tree can be drawn, not 'seq'"),
]


@pytest.mark.parametrize(("make", "says"), MISTAKES)
def test_a_mistake_is_one_clear_message(make: Callable[[], object], says: str) -> None:
    with pytest.raises(UserError) as caught:
        make()
    [problem] = caught.value.problems
    assert says in problem.message
    assert problem.hint


def test_an_unknown_parameter_is_answered_with_the_valid_ones() -> None:
    with pytest.raises(TypeError, match="Log has no parameter 'message': valid: level, text"):
        Log("l", message="x")


def test_a_node_says_in_a_line_what_it_is() -> None:
    node = hbt.load("fetch").node("reach")
    assert repr(node) == f"<Node {node.path!r}: reach, INVALID>"
