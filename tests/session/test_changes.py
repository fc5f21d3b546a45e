"""What a recording is told of the blackboard and of percepts: every change, and nothing that is none."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.messages import Percept
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.session.changes import Changes


def tree_of(*keys: Key) -> Any:
    return SimpleNamespace(keys=keys, nodes=[])


@pytest.fixture
def changes() -> Changes:
    """Changes of a run to which nothing comes from outside."""
    nothing = SimpleNamespace(since=lambda _: [], total=0)
    engine: Any = SimpleNamespace(unseen={}, inputs=nothing, supervisor=SimpleNamespace(stops=nothing))
    return Changes(engine)


@pytest.mark.parametrize("written", ["[0.5]", "0.5", "(0.5, 1)", "True"])
def test_a_key_that_is_set_to_what_it_is_has_not_changed(changes: Changes, written: str) -> None:
    key = Key("place")
    tree = tree_of(key)
    assert list(changes.since(tree)) == []
    key.set(eval(written))
    assert [kind for kind, _ in changes.since(tree)] == ["key"]
    key.set(eval(written))
    assert list(changes.since(tree)) == []


def test_a_list_that_is_changed_where_it_is_has_changed(changes: Changes) -> None:
    key = Key("places", [1])
    tree = tree_of(key)
    assert list(changes.since(tree)) == [("key", ["places", [1]])]
    key.value.append(2)
    assert list(changes.since(tree)) == [("key", ["places", [1, 2]])]


def test_a_key_that_an_edited_tree_does_not_have_is_set_no_more(changes: Changes) -> None:
    list(changes.since(tree_of(Key("stays", 1), Key("goes", 2), Key("is set anew", 3))))
    assert list(changes.since(tree_of(Key("stays", 1), Key("is set anew", 4), Key("comes", 5)))) == [
        ("key", ["goes"]),
        ("key", ["is set anew", 4]),
        ("key", ["comes", 5]),
    ]


def test_a_percept_is_new_when_it_was_seen_anew_even_if_it_is_the_same(changes: Changes) -> None:
    cup, plate = (Percept(name, 0.0, np.ones(3), 0.9) for name in ("cup", "plate"))
    assert changes.percepts({"cup": cup}) == [cup]
    assert changes.percepts({"cup": cup, "plate": plate}) == [plate]
    again = replace(cup)
    assert changes.percepts({"cup": again, "plate": plate}) == [again]
    assert changes.percepts({"cup": again, "plate": plate}) == []
