"""The built-in trees: their pictures, and those that are made for use in other trees."""

from __future__ import annotations

from pathlib import Path

import blocks

from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.tree.node_type import NodeType
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.show import svg_tree
from humanoid_bt.tree.source.load import load_tree, subtree_types
from humanoid_bt.tree.tree import Tree
from parts.markdown import table
from parts.parameters import Row, parameter_row, parameter_table


def pictures() -> dict[Path, str]:
    """Return file -> picture of each built-in tree, as ``humanoid-bt show NAME -o FILE`` draws it."""
    return {_picture(name): svg_tree(tree) for name, tree in _built_in().items()}


def trees() -> str:
    """Return the pictures of the built-in trees that run alone."""
    alone = [name for name, tree in _built_in().items() if not tree.is_subtree]
    return "\n\n".join(f"![The tree {name}](images/{_picture(name).name})" for name in alone)


def made_for_use_in_others() -> list[str]:
    """Return the names of the built-in trees that are made for use in other trees."""
    return [name for name, tree in _built_in().items() if tree.is_subtree]


def library() -> str:
    """Return the table of the built-in trees that are made for use in other trees."""
    trees = _built_in()
    rows = [(f"[`{name}`]({name}.md)", trees[name].description) for name in made_for_use_in_others()]
    return table(("tree", "what it does"), rows)


def library_tree(name: str) -> str:
    """Return picture, parameters and outputs of a built-in tree that is made for use in others."""
    workspace = Workspace(builtin_root())
    node_type, tree = subtree_types(workspace, Registry.of(workspace))[name], _built_in()[name]
    rows = [
        parameter_row(node_type.params[key]) if key in node_type.params else _node_row(node_type, key)
        for key in tree.header["parameters"]
    ]
    parts = [f"![The tree {name}](../images/{_picture(name).name})", parameter_table("parameter", rows)]
    if outputs := tree.header.get("outputs"):
        parts.append(table(("output", "meaning"), [(f"`{key}`", output["doc"]) for key, output in outputs.items()]))
    return "\n\n".join(parts)


def _node_row(node_type: NodeType, name: str) -> Row:
    slot = node_type.branches[name]
    return f"`{name}`", "node", "required" if slot.required else "see the picture", slot.doc


def _picture(name: str) -> Path:
    return blocks.IMAGES / f"tree-{name}.svg"


def _built_in() -> dict[str, Tree]:
    workspace = Workspace(builtin_root())
    return {name: load_tree(path, workspace) for name, path in sorted(workspace.trees().items())}
