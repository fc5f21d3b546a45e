"""Nodes whose keys stand in the wrong place: each slip is told once, and reading goes on with what was meant."""

from __future__ import annotations

import re
from dataclasses import replace

from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.core.items import Item
from humanoid_bt.tree.node_type import CHILD, NodeType
from humanoid_bt.tree.nodes.registry import Registry

_RUN_TOGETHER = re.compile(r"(\w+) *([:=]) *(.+)")

Keyed = tuple[str, Item, Place]
"""A key, what stands behind it, and the key's place."""


class Mender:
    """Finds what was meant where keys are indented, separated or spelled wrongly.

    Args:
        registry: the node types.
        problems: takes every slip.
    """

    def __init__(self, registry: Registry, problems: list[Problem]) -> None:
        self._registry = registry
        self._problems = problems

    def nodes(self, item: Item, in_list: bool) -> list[Keyed]:
        """Return the nodes that are meant by a mapping with several keys; none if that is not clear.

        Args:
            item: the mapping.
            in_list: whether several nodes may stand where it stands.
        """
        (first, body, place), *others = _keyed(item)
        node_type = self._registry.get(first)
        if node_type is None:
            return []
        beside = [key for key, _, _ in others]
        if all(self._belongs(key, node_type, body) for key in beside):
            merged = _with(body, others)
            if merged is not None:
                self._told(others[0], first)
                return [(first, merged, place)]
        if len(others) == 1 and beside[0] in self._registry and (deeper := self._deeper(first, body, others[0])):
            return [(first, deeper, place)]
        if in_list and all(key in self._registry for key in beside):
            message = f"{beside[0]!r} has no dash before it"
            self._problem(message, others[0][2], f"- {beside[0]}: ...", "not-a-node")
            return [(first, body, place), *others]
        return []

    def _belongs(self, key: str, node_type: NodeType, body: Item) -> bool:
        """Return whether a key that stands beside a node is most likely a part of it."""
        if key in _own_keys(node_type) or (key == "children" and node_type.takes == "many"):
            return True
        return body.value is None and (node_type.takes == "one" if key in self._registry else True)

    def body(self, name: str, node_type: NodeType, body: Item) -> Item:
        """Return what is meant by the mapping behind a node's type."""
        body = self._separated(node_type, body)
        if node_type.takes == "many":
            return self._children(name, body)
        return self._below(name, node_type, body) if node_type.takes == "one" else body

    def without_dashes(self, name: str, body: Item) -> Item | None:
        """Return the mapping that is meant by a list of mappings, None if it is none."""
        parts = [part for item in body.value if isinstance(item.value, dict) for part in _keyed(item)]
        if len(body.value) != sum(isinstance(item.value, dict) for item in body.value) or not parts:
            return None
        merged = _with(Item({}, body.place), parts)
        first = self._registry.get(parts[0][0])
        if len(body.value) == 1 and len(parts) > 1 and first and first.takes != "none" and parts[0][1].value is None:
            merged = _with(Item({}, body.place), [(parts[0][0], _with(parts[0][1], parts[1:]) or body, parts[0][2])])
        if merged is not None:
            hint = f"leave out the dash before {parts[0][0]!r}" + (", and the others" if len(body.value) > 1 else "")
            self._problem(f"what {name!r} holds is no list", body.place, hint, "wrong-type")
        return merged

    # ---- what stands in one mapping ------------------------------------------------------------------------------

    def _separated(self, node_type: NodeType, body: Item) -> Item:
        """Tell keys from values where a blank is missing, or a comma stands for a colon."""
        if all(item.value is not None for item in body.value.values()):
            return body
        own = _own_keys(node_type)
        found: list[Keyed] = []
        for key, item, place in _keyed(body):
            run = _RUN_TOGETHER.fullmatch(key) if item.value is None else None
            if run and run[1] in own:
                message = "there is no blank after the colon" if run[2] == ":" else "'=' stands for a colon"
                hint = f"{run[1]}: {run[3]}"
                self._problem(f"{message} of {run[1]!r}", replace(place, column=place.column + run.end(1)), hint)
                found.append((run[1], Item(run[3], place), place))
            elif node_type.takes == "none" and key not in own and _both_empty(found, item) and found[-1][0] in own:
                name, _, at = found.pop()
                self._problem(f"a comma after {name!r}, where a colon is expected", at, f"{name}: {key}")
                found.append((name, Item(key, place), at))
            else:
                found.append((key, item, place))
        return _with(Item({}, body.place), found) or body

    def _children(self, name: str, body: Item) -> Item:
        """Take a list under a name that means nothing for the children."""
        if "children" in body.value:
            return body
        lists = [part for part in _keyed(body) if isinstance(part[1].value, list)]
        if len(lists) != 1:
            return body
        key, _, place = lists[0]
        self._problem(f"unknown parameter {key!r} of {name!r}", place, "did you mean 'children'?", "unknown-parameter")
        return _renamed(body, key, "children")

    def _below(self, name: str, node_type: NodeType, body: Item) -> Item:
        own = _own_keys(node_type)
        nodes = [part for part in _keyed(body) if part[0] not in own and part[0] in self._registry]
        if len(nodes) == 2 and (deeper := self._deeper(nodes[0][0], nodes[0][1], nodes[1])):
            rest = {key: item for key, item in body.value.items() if key != nodes[1][0]} | {nodes[0][0]: deeper}
            body = Item(rest, body.place, body.key_places)
        missing = [key for key, spec in node_type.params.items() if spec.required and key not in body.value]
        missing += [key for key, slot in node_type.branches.items() if key not in body.value]
        for key in missing if len(nodes) == 1 else ():
            body = self._moved_up(name, key, nodes[0], body)
        return body

    def _moved_up(self, name: str, key: str, child: Keyed, body: Item) -> Item:
        """Take what stands in a child for its parent's, where only that has such a key."""
        child_name, inner, _ = child
        if not isinstance(inner.value, dict) or key not in inner.value or key in self._registry:
            return body
        if key in _own_keys(self._registry[child_name]):
            return body
        place = inner.key_places[key]
        message = f"{key!r} is a parameter of {name!r}, not of {child_name!r}"
        self._problem(message, place, f"write it beside {child_name!r}, not in it", "unknown-parameter")
        rest = Item({other: item for other, item in inner.value.items() if other != key}, inner.place, inner.key_places)
        values = {**body.value, key: inner.value[key], child_name: rest}
        return Item(values, body.place, {**body.key_places, key: place})

    def _deeper(self, name: str, body: Item, node: Keyed) -> Item | None:
        """Return what a decorator holds with a node put into the innermost decorator that has no child, if any."""
        node_type = self._registry[name]
        if node_type.takes != "one" or not isinstance(body.value, (dict, type(None))):
            return None
        values = body.value or {}
        children = [key for key in values if key not in _own_keys(node_type)]
        if not children:
            self._told(node, name)
            return _with(body, [node])
        if len(children) > 1 or children[0] not in self._registry:
            return None
        deeper = self._deeper(children[0], values[children[0]], node)
        return None if deeper is None else Item({**values, children[0]: deeper}, body.place, body.key_places)

    def _told(self, node: Keyed, above: str) -> None:
        hint = f"indent it, and all that belongs to it, deeper than {above!r}"
        self._problem(f"{node[0]!r} is not indented below {above!r}", node[2], hint, "not-a-node")

    def _problem(self, message: str, place: Place, hint: str, code: str = "syntax") -> None:
        self._problems.append(Problem(message, place, hint, code))


def _both_empty(before: list[Keyed], item: Item) -> bool:
    return bool(before) and before[-1][1].value is None and item.value is None


def _own_keys(node_type: NodeType) -> set[str]:
    return {"name", *node_type.params, *node_type.branches, *((CHILD,) if node_type.takes == "one" else ())}


def _keyed(item: Item) -> list[Keyed]:
    return [(key, value, item.key_places.get(key, item.place)) for key, value in item.value.items()]


def _with(body: Item, parts: list[Keyed]) -> Item | None:
    """Return a mapping with more keys; None if what there is is no mapping, or has one of them."""
    if not isinstance(body.value, (dict, type(None))):
        return None
    values, places = dict(body.value or {}), dict(body.key_places)
    for key, item, place in parts:
        if key in values:
            return None
        values[key], places[key] = item, place
    return Item(values, body.place, places)


def _renamed(body: Item, key: str, name: str) -> Item:
    parts = [(name if old == key else old, item, place) for old, item, place in _keyed(body)]
    return _with(Item({}, body.place), parts) or body
