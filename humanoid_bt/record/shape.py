"""What a recording's data must look like: what does not is left out here, so that whoever reads it can rely on it."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

_LONGEST = 1e9  # s; a time beyond is none

Shape = Callable[[Any], Any]
"""Returns data as it should be, parts that are not left out; raises ValueError if nothing of it can be kept."""


def text(data: Any) -> str:
    """Take a text."""
    if not isinstance(data, str):
        raise ValueError("no text")
    return data


def number(data: Any) -> float | int:
    """Take a number that is finite."""
    if isinstance(data, bool) or not isinstance(data, (int, float)) or not math.isfinite(data):
        raise ValueError("no number")
    return data


def time(data: Any) -> float:
    """Take an engine time [s]."""
    if not 0.0 <= number(data) < _LONGEST:
        raise ValueError("no time")
    return float(data)


def whole(data: Any) -> int:
    """Take a whole number."""
    if isinstance(data, bool) or not isinstance(data, int):
        raise ValueError("no whole number")
    return data


def truth(data: Any) -> bool:
    """Take yes or no."""
    if not isinstance(data, bool):
        raise ValueError("neither true nor false")
    return data


def anything(data: Any) -> Any:
    """Take whatever it is."""
    return data


def one_of(*values: Any) -> Shape:
    """Return a shape for some values."""

    def take(data: Any) -> Any:
        if not any(type(data) is type(value) and data == value for value in values):
            raise ValueError(f"none of {values}")
        return data

    return take


def optional(shape: Shape) -> Shape:
    """Return a shape for something that may be missing."""
    return lambda data: None if data is None else shape(data)


def several(shape: Shape) -> Shape:
    """Return a shape for a list whose entries can be left out one by one."""
    return lambda data: [kept for entry in _list(data) for kept in _kept(shape, entry)]


def every(shape: Shape) -> Shape:
    """Return a shape for a list that is kept only as a whole."""
    return lambda data: [shape(entry) for entry in _list(data)]


def named(shape: Shape) -> Shape:
    """Return a shape for a mapping of names, whose entries can be left out one by one."""
    return lambda data: {name: kept for name, entry in _mapping(data).items() for kept in _kept(shape, entry)}


def row(*shapes: Shape) -> Shape:
    """Return a shape for a list of these entries, no more and no fewer."""
    return lambda data: [shape(entry) for shape, entry in zip(shapes, _list(data), strict=True)]


def parts(needed: dict[str, Shape] | None = None, **shapes: Shape) -> Shape:
    """Return a shape for a mapping of known parts, which can be left out one by one; what else is in it is kept.

    Args:
        needed: parts without which it is none.
        shapes: of the others.
    """

    def take(data: Any) -> dict[str, Any]:
        mapping = _mapping(data)
        if lacking := (needed or {}).keys() - mapping:
            raise ValueError(f"no {min(lacking)}")
        whole = {name: shape(mapping[name]) for name, shape in (needed or {}).items()}
        kept = {name: part for name, entry in mapping.items() for part in _kept(shapes.get(name, anything), entry)}
        return kept | whole

    return take


def filled(shape: Shape, **defaults: Any) -> Shape:
    """Return a shape for a mapping that is never missing: what is not there is as the defaults say."""
    return lambda data: copy.deepcopy(defaults) | next(iter(_kept(shape, data)), {})


def _kept(shape: Shape, data: Any) -> tuple[Any, ...]:
    """Return what is kept of data, and nothing if nothing can be."""
    try:
        return (shape(data),)
    except (ValueError, RecursionError):
        return ()


def _list(data: Any) -> list[Any]:
    if not isinstance(data, list):
        raise ValueError("no list")
    return data


def _mapping(data: Any) -> dict[str, Any]:
    if not isinstance(data, dict):
        raise ValueError("no mapping")
    return {name: value for name, value in data.items() if isinstance(name, str)}


_NODE = filled(
    parts({"path": text}, type=text, kind=text, place=text, parent=whole, branch=text, values=named(anything)),
    type="",
    kind="",
    place="",
    parent=-1,
    branch="",
    values={},
)
_PARAMETER = parts({"value": anything}, **{"from": text})


def _nodes(data: Any) -> list[Any]:
    """Take the nodes of a tree, which know their parents by their numbers."""
    nodes: list[Any] = every(_NODE)(data)
    if any("path" not in node or not -1 <= node["parent"] < number for number, node in enumerate(nodes)):
        raise ValueError("no nodes of a tree")
    return nodes


_TREE = filled(
    parts(name=text, file=text, source=text, parameters=named(_PARAMETER), nodes=_nodes),
    name="",
    file="",
    source="",
    parameters={},
    nodes=[],
)
_SCENE = filled(parts(name=text, file=text), name="", file="")
_LIMITS = dict.fromkeys(("lower", "upper", "torque", "speed"), every(optional(number)))
_ROBOT = filled(
    parts(
        name=text,
        file=text,
        joints=every(text),
        limits=parts(_LIMITS),
        arms=named(every(text)),
        mass=optional(number),
        fall=optional(parts({"tilt": number, "height": number})),
    ),
    name="",
    file="",
    joints=[],
    limits={},
    arms={},
    mass=None,
    fall=None,
)


def _robot(data: Any) -> dict[str, Any]:
    """Take what is kept of a robot; limits that are not one for each joint are unknown."""
    robot: dict[str, Any] = _ROBOT(data)
    count = len(robot["joints"])
    if any(len(robot["limits"].get(name, ())) != count or not count for name in _LIMITS):
        robot["limits"] = {name: [None] * count for name in _LIMITS}
    return robot


_STAGED = filled(parts(dry=truth, told=several(text)), dry=False, told=[])

SETUP: Shape = filled(
    parts(
        began=text,
        mode=one_of("lockstep", "realtime"),
        seed=whole,
        duration=optional(number),
        workspace=text,
        tree=_TREE,
        robot=_robot,
        scene=_SCENE,
        staged=_STAGED,
        files=several(parts({"name": text, "role": text, "sha256": text}, text=text)),
        versions=named(text),
        machine=named(anything),
    ),
    began="",
    mode="",
    seed=0,
    duration=None,
    workspace="",
    tree=_TREE({}),
    robot=_robot({}),
    scene=_SCENE({}),
    staged=_STAGED({}),
    files=[],
    versions={},
    machine={},
)
"""What was run."""

_COLUMNS = every(parts({"name": text, "unit": text, "resolution": number, "labels": every(text)}))
LAYOUT: Shape = filled(parts(modes=every(text), gaits=every(text), cycles=_COLUMNS, plans=_COLUMNS), modes=[], gaits=[])
"""What the numbers of a row stand for."""

_STOP = parts({"time": time, "mode": text, "reason": text, "source": text, "resources": named(text)})
_SLOW = parts(count=whole, worst=optional(parts({"time": number, "node": text, "duration": number})))
_END = ("outcome", "reason", "failure", "traceback", "node", "error", "line")


def _key(data: Any) -> Any:
    """Take a key of the blackboard, with its value if it has one."""
    return row(text, *(anything for _ in _list(data)[1:2]))(data)


_PUSH = row(time, one_of("push"), row(text, row(number, number, number), number))
_KEY = row(time, one_of("key"), _key)
_SET = row(time, one_of("set"), row(text, anything))
_FORCE = row(time, one_of("force"), row(text, one_of("SUCCESS", "FAILURE"), text))
_RESET = row(time, one_of("reset", "reset_after_tick"), text)
_ANSWERED = parts({"state": one_of("success", "failure"), "text": text, "values": named(anything)})
_ANSWER = row(time, one_of("answer"), row(whole, _ANSWERED))
_INPUTS = {"push": _PUSH, "key": _KEY, "set": _SET, "force": _FORCE, "answer": _ANSWER}


def _input(data: Any) -> Any:
    kind = next(iter(_list(data)[1:2]), None)
    return (_INPUTS.get(kind, _RESET) if isinstance(kind, str) else _RESET)(data)


NEWS: dict[str, Shape] = {
    "limits": filled(parts(duration=optional(number), waits=truth), duration=None, waits=False),
    "node": row(text, text, text),
    "results": row(text, every(row(text, anything, text))),
    "event": row(one_of("info", "warning", "error"), text),
    "key": _key,
    "unseen": named(text),
    "input": _input,
    "stop": _STOP,
    "tree": _TREE,
    "end": parts(dict.fromkeys(_END, text), tree_ended=optional(time), slow_ticks=_SLOW),
}
"""What happened, by its kind."""
