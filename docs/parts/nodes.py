"""The reference of node types: the built-in ones, and the built-in skills."""

from __future__ import annotations

from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.tree.node_type import NODE_KEYS, NodeType
from humanoid_bt.tree.nodes import BUILTIN
from humanoid_bt.tree.nodes.examples import EXAMPLES
from humanoid_bt.tree.nodes.other_libraries import FOREIGN
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.slots import Slot
from parts.markdown import code, docstring, table
from parts.parameters import parameter_row, parameter_table

_HEADINGS = {
    "composite": "Composites",
    "decorator": "Decorators",
    "subtree": "Sub-trees",
    "condition": "Conditions",
    "action": "Actions",
}

_CHILDREN = {
    "many": "One or more, in a list.",
    "one": "One, as a key beside the parameters.",
    "none": "None.",
}


def nodes() -> str:
    """Return the reference of the built-in node types but for the skills."""
    parts: list[str] = []
    for kind in BUILTIN:
        parts += [f"## {_HEADINGS[kind]}", *_of_kind(kind)]
    return "\n\n".join(parts)


def skills() -> str:
    """Return the reference of the built-in skills."""
    return "\n\n".join(_of_kind("skill"))


def elsewhere() -> str:
    """Return the table of what nodes of other libraries are called here."""
    rows = [(foreign.library, code(foreign.names), foreign.here) for foreign in FOREIGN]
    return table(("library", "there", "here"), rows)


def node_keys() -> str:
    """Return the table of the keys that nodes have besides their parameters."""
    return table(("key", "meaning"), [(f"`{name}`", doc) for name, doc in NODE_KEYS.items()])


def _of_kind(kind: str) -> list[str]:
    registry = Registry.of(Workspace(builtin_root()))
    return [_node(node_type) for node_type in registry.values() if node_type.kind == kind]


def _node(node_type: NodeType) -> str:
    parts = [f"### `{node_type.type_name}`", docstring(node_type.cls)]
    if node_type.resources:
        parts.append(f"Commands: {code(node_type.resources)}.")
    if node_type.takes != "none":
        parts.append(f"Children: {_CHILDREN[node_type.takes]}")
    if node_type.branches:
        rows = [
            (f"`{name}`", _holds(slot), "required" if slot.required else "", slot.doc)
            for name, slot in node_type.branches.items()
        ]
        parts.append(table(("branch", "holds", "default", "meaning"), rows))
    if node_type.params:
        parts.append(parameter_table("parameter", map(parameter_row, node_type.params.values())))
    if node_type.results:
        rows = [(f"`{result.name}`", result.type_name, result.doc) for result in node_type.results.values()]
        parts.append(table(("result", "type", "meaning"), rows))
    parts.append(f"<!-- tree -->\n```yaml\n{EXAMPLES[node_type.type_name]}```")
    return "\n\n".join(parts)


def _holds(slot: Slot) -> str:
    if slot.many:
        return "mapping of values to nodes"
    return "expression or node" if slot.condition else "node"
