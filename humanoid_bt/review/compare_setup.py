"""How what was run differs from what was run another time: parameters, files, versions, the tree node by node."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from humanoid_bt.review import setup
from humanoid_bt.review.parameters import as_text, changed_parameters, same, shown
from humanoid_bt.review.setup import NodeInfo

_SETTINGS = ("mode", "body", "seed", "duration", "on_estop", "watch", "perception")
_STAGED = ("dry", "conditions", "replace", "script")
_HASH = 12  # digits of a file's hash that are shown


@dataclass(frozen=True)
class Change:
    """Something that is not the same in two runs.

    Attributes:
        part: what it belongs to: settings, parameters, files, tree, versions, machine, results, outcome.
        name: what it is.
        before, after: how it was in each, None where it was not.
    """

    part: str
    name: str
    before: str | None
    after: str | None


def setup_changes(one: Mapping[str, Any], other: Mapping[str, Any]) -> Iterator[Change]:
    """Yield what two runs were given that was not the same.

    Args:
        one, other: what was run, as recordings have it.
    """
    yield from _changes("settings", _settings(one), _settings(other))
    trees = one["tree"], other["tree"]
    for change in changed_parameters(*map(setup.parameters, trees)):
        before, after = (None if info is None else shown(info) for info in (change.before, change.after))
        yield Change("parameters", change.name, before, after)
    yield from _changes("files", _files(one), _files(other))
    yield from _node_changes(*map(_nodes, trees))
    for part in ("versions", "machine"):
        yield from _changes(part, one[part], other[part])


def _settings(run: Mapping[str, Any]) -> dict[str, Any]:
    names = {key: run[key]["name"] for key in ("tree", "robot", "scene")}
    staged = {f"staged {key}": run["staged"][key] for key in _STAGED if run["staged"].get(key)}
    return {**names, **{key: run.get(key) for key in _SETTINGS}, **staged}


def _files(run: Mapping[str, Any]) -> dict[str, str]:
    """Return the hash of every file by its role and name."""
    return {f"{file['role']} {file['name']}": file["sha256"][:_HASH] for file in run["files"]}


def _changes(part: str, one: Mapping[str, Any], other: Mapping[str, Any]) -> Iterator[Change]:
    for name in dict.fromkeys((*one, *other)):
        if name not in one or name not in other or not same(one[name], other[name]):
            yield Change(part, name, _shown(one, name), _shown(other, name))


def _shown(values: Mapping[str, Any], name: str) -> str | None:
    if name not in values:
        return None
    return as_text(values[name])


# ---- the tree -------------------------------------------------------------------------------------------------------


def _nodes(tree: Mapping[str, Any]) -> dict[str, NodeInfo]:
    """Return a tree's nodes by their path below the tree's name."""
    return {path.partition("/")[2]: node for path, node in setup.nodes(tree).items()}


def _node_changes(one: dict[str, NodeInfo], other: dict[str, NodeInfo]) -> Iterator[Change]:
    """Yield nodes that were added, removed, moved, or given other values."""
    removed = {path: node for path, node in one.items() if path not in other}
    added = {path: node for path, node in other.items() if path not in one}
    for path, node in list(removed.items()):
        to = next((new for new, found in added.items() if _alike(path, node, new, found)), None)
        if to is not None:
            del removed[path], added[to]
            yield Change("tree", f"{_name(path)} moved", path, to)
    for path, node in removed.items():
        yield Change("tree", path, _described(node), None)
    for path, node in added.items():
        yield Change("tree", path, None, _described(node))
    common = [path for path in one if path in other]
    for path in common:
        if one[path].type != other[path].type:
            yield Change("tree", f"{path} type", one[path].type, other[path].type)
        for change in _changes("tree", one[path].values, other[path].values):
            yield Change("tree", f"{path} {change.name}", change.before, change.after)
    yield from _order_changes(common, [path for path in other if path in one])


def _order_changes(one: list[str], other: list[str]) -> Iterator[Change]:
    """Yield the parents whose children, as far as both trees have them, stand in another order."""
    for parent in dict.fromkeys(path.rpartition("/")[0] for path in one):
        orders = [[_name(path) for path in paths if path.rpartition("/")[0] == parent] for paths in (one, other)]
        if orders[0] != orders[1]:
            yield Change("tree", f"{parent} order".strip(), ", ".join(orders[0]), ", ".join(orders[1]))


def _alike(path: str, node: NodeInfo, new: str, found: NodeInfo) -> bool:
    return _name(path) == _name(new) and node.type == found.type and same(dict(node.values), dict(found.values))


def _name(path: str) -> str:
    return path.rpartition("/")[2]


def _described(node: NodeInfo) -> str:
    values = ", ".join(f"{name}: {as_text(value)}" for name, value in node.values.items())
    return f"{node.type} {values}".strip()
