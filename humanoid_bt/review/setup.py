"""What was run, out of a recording."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

T = TypeVar("T")

_AT = 1e-6  # s; engine times that differ by less are the same


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
        origin: file:line:column; "given", or "given in FILE:LINE:COLUMN", from outside; "" if nobody knows.
    """

    value: Any
    written: Any = None
    origin: str = ""

    @property
    def given(self) -> bool:
        """Whether it was given from outside."""
        return self.origin.startswith("given")


def ran_at(one_by_one: Sequence[tuple[float, T]], time: float) -> T:
    """Return what is kept of the tree that ran at a time [s]; the tree that takes its place then runs later.

    Args:
        one_by_one: since when [s], and what is kept, of each tree that ran; the first since ever.
        time: engine time [s].
    """
    return next((kept for since, kept in reversed(one_by_one) if since < time - _AT), one_by_one[0][1])


def nodes(tree: Mapping[str, Any]) -> dict[str, NodeInfo]:
    """Return a tree's nodes by path, in their order."""
    return {
        node["path"]: NodeInfo(node["path"], node["type"], node["kind"], node["place"], node["values"])
        for node in tree["nodes"]
    }


def parameters(tree: Mapping[str, Any]) -> dict[str, ParameterInfo]:
    """Return a tree's parameters by name, in their order."""
    return {
        name: ParameterInfo(parameter["value"], parameter.get("written"), parameter.get("from", ""))
        for name, parameter in tree["parameters"].items()
    }


def joints(setup: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield a row for each joint: its limits, None for none."""
    robot = setup["robot"]
    for number, joint in enumerate(robot["joints"]):
        yield {"joint": joint, **{name: values[number] for name, values in robot["limits"].items()}}
