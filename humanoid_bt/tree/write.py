"""Writing a tree as a file that loads to the same tree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import yaml
from py_trees.behaviour import Behaviour

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.units import is_number_text
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.tree.expressions.fields import Fields
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.node_type import CHILD

_WIDTH = 100
_HEAD = ("format", "name", "description", "robot", "scene", "perception", "subtree")
_ORDER = (*_HEAD, "parameters", "blackboard", "outputs")


class _Flow(dict[str, Any]):
    """A mapping on one line: the parameters of a leaf."""


class _FlowList(list[Any]):
    """A list on one line: values, not nodes."""


class _Dumper(yaml.SafeDumper):
    """Writes as people do: lists indented below their key, leaves on one line, nothing for nothing."""

    def increase_indent(self, flow: bool = False, indentless: bool = False) -> None:
        super().increase_indent(flow, False)

    def ignore_aliases(self, data: Any) -> bool:
        return True


_Dumper.add_representer(
    _Flow, lambda dumper, data: dumper.represent_mapping("tag:yaml.org,2002:map", data.items(), flow_style=True)
)
_Dumper.add_representer(
    _FlowList, lambda dumper, data: dumper.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=True)
)
_Dumper.add_representer(type(None), lambda dumper, _: dumper.represent_scalar("tag:yaml.org,2002:null", ""))


def tree_text(name: str, header: Mapping[str, Any], nodes: Sequence[Node]) -> str:
    """Return the text of a tree file.

    Args:
        name: what the tree is called, for messages.
        header: the file's keys but for the root, as plain YAML.
        nodes: every node, parents before children.

    Raises:
        UserError: a parameter has a value that no file can hold.
    """
    children: dict[int, list[int]] = {}
    for index, node in enumerate(nodes):
        children.setdefault(node.parent, []).append(index)
    root = _node(nodes, 0, children)
    header = {"format": 1, **header}
    parameters = header.get("parameters") or {}
    named = set(_names(root, parameters))
    header["parameters"] = {name: of for name, of in parameters.items() if name in named or not _is_default_node(of)}
    header = {key: header[key] for key in (*_ORDER, *header) if header.get(key) not in (None, "", {})}
    header |= {part: _lists_in_flow(header[part]) for part in ("parameters", "blackboard") if part in header}
    document = {**header, "root": root}
    try:
        text: str = yaml.dump(
            document, Dumper=_Dumper, sort_keys=False, width=_WIDTH, allow_unicode=True, default_flow_style=False
        )
    except yaml.representer.RepresenterError as error:
        message = f"the tree {name!r} cannot be written: {error.args[0]} {error.args[-1]!r}"
        raise UserError(message, code="wrong-type") from error
    return text


def written(value: Any, unit: str = "") -> Any:  # noqa: PLR0911 (a table of cases)
    """Return a parameter's value as a file holds it, with its unit."""
    if isinstance(value, Key):
        return value.name
    if isinstance(value, bool) or value is None:
        return value
    if isinstance(value, (int, float)):
        return f"{repr(value).removesuffix('.0')} {unit}" if unit else value
    if isinstance(value, (list, tuple)):
        return _FlowList(written(item, unit) for item in value)
    if isinstance(value, Fields):
        return _Flow(value.written)
    if isinstance(value, Mapping):
        return {key: written(item, unit) for key, item in value.items()}
    if isinstance(value, str):
        if unit and is_number_text(value):
            return f"{value} {unit}"
        return f"${value}" if value.startswith("$") else value
    return str(value) if hasattr(type(value), "from_item") else value


def _node(nodes: Sequence[Node], index: int, children: Mapping[int, list[int]]) -> Any:
    """Return a node as plain YAML, in its shortest form."""
    node = nodes[index]
    below = [] if node.kind == "subtree" else children.get(index, [])
    body = {**_parameters(node), **_arguments(nodes, node, children)}
    plain = [child for child in below if not nodes[child].branch]
    for child in below:
        branch, _, case = nodes[child].branch.partition(" ")
        if branch and node.type.branches[branch].many:
            body.setdefault(branch, {})[case] = _node(nodes, child, children)
        elif branch:
            body[branch] = _branch(node, branch, _node(nodes, child, children))
    if node.type.takes == "many":
        items = [_node(nodes, child, children) for child in plain]
        return {node.type_name: {**body, "children": items} if body else items}
    if node.type.takes == "one":
        return {node.type_name: {**body, **_child(node, _node(nodes, plain[0], children))}}
    if not body:
        return node.type_name
    if body.keys() == {node.type.main} and not isinstance(body[node.type.main], (list, dict)):
        return {node.type_name: body[node.type.main]}
    return {node.type_name: body if below or node.arguments else _Flow(body)}


def _parameters(node: Node) -> dict[str, Any]:
    body: dict[str, Any] = {} if node.name == node.type_name else {"name": written(node.name)}
    if "name" in node.unresolved:
        body["name"] = node.unresolved["name"]
    for name, spec in node.type.params.items():
        if name in node.references:
            body[name] = f"${node.references[name]}"
        elif name in node.unresolved:
            body[name] = _in_flow(node.unresolved[name])
        elif name in node.values and (spec.required or node.values[name] != spec.default):
            body[name] = written(node.written.get(name, node.values[name]), spec.unit)
    return body


def _in_flow(value: Any) -> Any:
    """Return plain YAML to be written on one line."""
    if isinstance(value, dict):
        return _Flow((key, _in_flow(part)) for key, part in value.items())
    return _FlowList(map(_in_flow, value)) if isinstance(value, list) else value


def _names(value: Any, parameters: Mapping[str, Any]) -> Iterator[str]:
    """Yield the parameters that stand in plain YAML as ``$name``, and those in the nodes that are their defaults."""
    if isinstance(value, (dict, list)):
        for part in (*value, *value.values()) if isinstance(value, dict) else value:
            yield from _names(part, parameters)
    elif isinstance(value, str) and value.startswith("$") and (name := value[1:]) in parameters:
        yield name
        if _is_default_node(parameters[name]):
            yield from _names(parameters[name]["default"], parameters)


def _is_default_node(declared: Any) -> bool:
    """Return whether a parameter is a node that stands wherever it is used, since none else was given."""
    return isinstance(declared, dict) and declared.get("type") == "node" and declared.get("default") is not None


def _lists_in_flow(value: Any) -> Any:
    """Return plain YAML whose lists are to be written on one line."""
    if isinstance(value, dict):
        return {key: _lists_in_flow(part) for key, part in value.items()}
    return _in_flow(value)


def _arguments(nodes: Sequence[Node], node: Node, children: Mapping[int, list[int]]) -> dict[str, Any]:
    """Return the nodes that a sub-tree is given; those that were made in Python stand somewhere below it."""
    places = {node.behaviour: index for index, node in enumerate(nodes)} if node.arguments else {}
    return {
        name: _plain(_node(nodes, places[given], children)) if isinstance(given, Behaviour) else given
        for name, given in node.arguments.items()
    }


def _plain(value: Any) -> Any:
    """Return a node's value without a word on how it is laid out: as it comes back from a file."""
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    return [_plain(part) for part in value] if isinstance(value, list) else value


def _branch(node: Node, branch: str, below: Any) -> Any:
    """Return what stands for a branch: of a condition that is only an expression, its text, as text is one there."""
    if not node.type.branches[branch].condition:
        return below
    if isinstance(below, str):
        return {below: None}
    return below["condition"] if isinstance(below.get("condition"), str) else below


def _child(node: Node, child: Any) -> dict[str, Any]:
    """Return what stands for a decorator's child among its parameters."""
    taken = {"name", *node.type.params, *node.type.branches}
    whole = {child: None} if isinstance(child, str) else child
    return {CHILD: child} if whole.keys() & taken else whole
