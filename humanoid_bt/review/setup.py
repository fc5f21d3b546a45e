"""What was run, out of a recording: what is not as it should be, whoever wrote it, is left out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class NodeInfo:
    """A node of a tree that ran.

    Attributes:
        path: it, with those above it.
        type, kind: what it is.
        place: file:line:column.
        values: its parameters.
    """

    path: str
    type: str = ""
    kind: str = ""
    place: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class ParameterInfo:
    """A parameter of a tree that ran.

    Attributes:
        value: in SI units.
        written: as it was written.
        origin: file:line:column, "given" from outside, "" if nobody knows.
    """

    value: Any
    written: Any = None
    origin: str = ""


def part(data: Any, *keys: str) -> dict[str, Any]:
    """Return the mapping at a place in a mapping, an empty one if there is none."""
    for key in keys:
        data = data.get(key) if isinstance(data, dict) else None
    return {name: value for name, value in data.items() if isinstance(name, str)} if isinstance(data, dict) else {}


def text(data: Mapping[str, Any], key: str) -> str:
    """Return the text at a key, "" if there is none."""
    value = data.get(key)
    return value if isinstance(value, str) else ""


def nodes(tree: Mapping[str, Any]) -> dict[str, NodeInfo]:
    """Return a tree's nodes by path, in their order."""
    found = tree.get("nodes")
    described = [part(node) for node in found] if isinstance(found, list) else []
    return {
        path: NodeInfo(path, text(node, "type"), text(node, "kind"), text(node, "place"), part(node, "values"))
        for node in described
        if (path := text(node, "path"))
    }


def parameters(tree: Mapping[str, Any]) -> dict[str, ParameterInfo]:
    """Return a tree's parameters by name, in their order."""
    found = part(tree, "parameters")
    described = {name: part(found, name) for name in found}
    return {
        name: ParameterInfo(parameter["value"], parameter.get("written"), text(parameter, "from"))
        for name, parameter in described.items()
        if "value" in parameter
    }


def joints(setup: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield a row for each joint: its limits, as far as they are known."""
    robot = part(setup, "robot")
    limits = part(robot, "limits")
    names = robot.get("joints")
    for number, joint in enumerate(names if isinstance(names, list) else []):
        if isinstance(joint, str):
            yield {
                "joint": joint,
                **{key: _at(limits.get(key), number) for key in ("torque", "speed", "lower", "upper")},
            }


def _at(values: Any, number: int) -> float | None:
    """Return a number of a list, None for one that is infinite."""
    value = values[number] if isinstance(values, list) and number < len(values) else None
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None
