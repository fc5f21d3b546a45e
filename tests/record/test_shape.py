"""Shapes: what of a recording's data is kept, part by part, and what is left out."""

from __future__ import annotations

import math
from typing import Any

import pytest

from humanoid_bt.record import shape
from humanoid_bt.record.shape import LAYOUT, NEWS, SETUP, Shape

ENDING = dict.fromkeys(("outcome", "reason", "failure", "traceback", "node", "error", "line"), "x")
ANSWER = {"state": "success", "text": "it is on", "values": {"message": "on"}}
STOP = {"time": 1.0, "mode": "damp", "reason": "", "source": "", "resources": {"gaze": "a/b"}}
LIMITS = {"lower": [0.0], "upper": [None], "torque": [9], "speed": [1.0]}
NODE = {"path": "t", "type": "", "kind": "", "place": "", "parent": -1, "branch": "", "values": {}}


@pytest.mark.parametrize(
    ("taken", "good", "bad"),
    [
        (shape.text, ["", "x"], [None, 1, ["x"]]),
        (shape.number, [0, -1.5], [True, "1", None, math.nan, math.inf]),
        (shape.time, [0, 1.5], [-0.1, 1e9, math.nan, "1"]),
        (shape.whole, [0, -3], [True, 1.0, None]),
        (shape.truth, [True, False], [0, 1, None]),
        (shape.one_of("a", 1), ["a", 1], ["b", True, 1.0]),
        (shape.optional(shape.text), [None, "x"], [1]),
        (shape.every(shape.whole), [[], [1, 2]], [[1, "x"], (1,), {}]),
        (shape.row(shape.text, shape.whole), [["a", 1]], [["a"], ["a", 1, 2], ["a", "b"], "a1"]),
        (NEWS["node"], [["a", "RUNNING", ""]], [["a", "RUNNING"], ["a", 1, ""]]),
        (NEWS["results"], [["a", [["r", None, "m"]]]], [["a", [["r", 1, None]]], ["a"]]),
        (NEWS["event"], [["info", "x"]], [["loud", "x"], ["info"]]),
        (NEWS["key"], [["k"], ["k", {"a": 1}]], [[], [1], ["k", 1, 2]]),
        (NEWS["input"], [[1.0, "push", ["torso", [1, 0, 0], 0.1]]], [[1.0, "push", ["torso", [1, 0], 0.1]], [1.0]]),
        (NEWS["input"], [[1.0, "key", ["k", 2]], [1.0, "key", ["k"]]], [[-1.0, "key", ["k"]], [1.0, "key", []]]),
        (NEWS["input"], [[1.0, "reset", "me"], [1.0, "reset_after_tick", "me"]], [[1.0, "estop", "me"], "push"]),
        (NEWS["input"], [[1.0, "answer", [3, ANSWER]]], [[1.0, "answer", [3, {**ANSWER, "state": "lost"}]], [1.0, 3]]),
        (NEWS["stop"], [STOP], [{**STOP, "time": -1.0}, {**STOP, "reason": None}, {**STOP, "resources": []}, {}]),
        (NEWS["end"], [ENDING], [{**ENDING, "line": 3}, {"outcome": "success"}]),
    ],
)
def test_what_is_right_is_kept_whole_and_what_is_not_is_refused(taken: Shape, good: list[Any], bad: list[Any]) -> None:
    for data in good:
        assert taken(data) == data
    for data in bad:
        with pytest.raises(ValueError):
            taken(data)


@pytest.mark.parametrize(
    ("taken", "data", "kept"),
    [
        (shape.several(shape.text), ["a", 1, "b"], ["a", "b"]),
        (shape.named(shape.text), {"a": "b", "c": 1, 2: "d"}, {"a": "b"}),
        (NEWS["unseen"], {"target": "why", "door": None}, {"target": "why"}),
        (NEWS["end"], {**ENDING, "tree_ended": "soon", "slow_ticks": {"count": 1.5}}, {**ENDING, "slow_ticks": {}}),
        (NEWS["limits"], {"duration": "long", "more": 1}, {"duration": None, "waits": False, "more": 1}),
        (LAYOUT, {"modes": ["run", 1], "gaits": ["stand"]}, {"modes": [], "gaits": ["stand"]}),
        (LAYOUT, {"cycles": [{"name": "q"}]}, {"modes": [], "gaits": []}),
    ],
)
def test_a_part_that_is_wrong_is_left_out_alone(taken: Shape, data: Any, kept: Any) -> None:
    assert taken(data) == kept


@pytest.mark.parametrize(
    ("part", "given", "kept"),
    [
        ("seed", "x", 0),
        ("mode", "sideways", ""),
        ("duration", math.inf, None),
        ("staged", {"dry": 1, "told": ["a", 2]}, {"dry": False, "told": ["a"]}),
        ("files", [{"name": "a", "role": "b"}, {"name": "a", "role": "b", "sha256": "c", "text": 1}],
         [{"name": "a", "role": "b", "sha256": "c"}]),
        ("versions", {"a": "1", "b": 2}, {"a": "1"}),
        ("scene", [], {"name": "", "file": ""}),
    ],
)  # fmt: skip
def test_what_was_run_is_never_missing(part: str, given: Any, kept: Any) -> None:
    whole = SETUP({})
    assert SETUP({part: given}) == {**whole, part: kept}
    assert SETUP(None) == whole


@pytest.mark.parametrize(
    "nodes",
    [
        [{"type": "idle"}],  # without a path
        [{"path": "t", "parent": 0}],  # its own parent
        [{"path": "t"}, {"path": "t/a", "parent": 2}, {"path": "t/b", "parent": 0}],  # a parent behind it
        [{"path": "t", "parent": -2}],
        [{"path": "t"}, 3],
        {},
    ],
)
def test_nodes_are_kept_only_if_they_make_a_tree(nodes: Any) -> None:
    good = [{"path": "t"}, {"path": "t/a", "parent": 0, "values": {"x": 1}}]
    assert SETUP({"tree": {"nodes": good}})["tree"]["nodes"] == [NODE, {**NODE, **good[1]}]
    assert SETUP({"tree": {"name": "t", "nodes": nodes}})["tree"] == {**SETUP({})["tree"], "name": "t"}


@pytest.mark.parametrize("wrong", [{"lower": []}, {"upper": ["x"]}, {"speed": None}])
def test_limits_that_are_not_one_for_each_joint_are_unknown(wrong: dict[str, Any]) -> None:
    assert SETUP({"robot": {"joints": ["knee"], "limits": LIMITS}})["robot"]["limits"] == LIMITS
    robot = SETUP({"robot": {"joints": ["knee"], "limits": {**LIMITS, **wrong}}})["robot"]
    assert robot["limits"] == {name: [None] for name in LIMITS}


def test_what_is_made_of_nothing_is_nobodys() -> None:
    SETUP({})["tree"]["nodes"].append(NODE)
    assert SETUP({})["tree"]["nodes"] == []


def test_a_depth_without_end_is_left_out() -> None:
    deep: list[Any] = []
    for _ in range(100_000):
        deep = [deep]
    assert shape.several(_nested)([deep, []]) == [[]]


def _nested(data: Any) -> Any:
    return shape.every(_nested)(data)
