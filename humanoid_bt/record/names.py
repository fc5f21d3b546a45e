"""What nodes are called in a recording: short names, no two alike, for lanes and events."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from humanoid_bt.tree.show.outline import Outline, OutlineNode

_SUBTREE = "tree: "


def short_names(outline: Outline) -> dict[str, str]:
    """Return a name for each node: its own, with where it stands if others are called the same.

    Where it stands is the nearest node above it that its author gave a name, or the sub-tree that it is in. What is
    still alike is numbered, in the tree's order.

    Returns:
        Path to name.
    """
    outline = with_subtree_names(outline)
    own = [node.title for node in outline.nodes]
    count = Counter(own)
    names: dict[str, str] = {}
    used: Counter[str] = Counter()
    for index in outline.in_order():
        name = own[index]
        if count[name] > 1:
            where = _where(outline, index)
            name = f"{name} ({where})" if where else name
        used[name] += 1
        names[outline.nodes[index].path] = f"{name} {used[name]}" if used[name] > 1 else name
    return names


def with_subtree_names(outline: Outline) -> Outline:
    """Return the tree with sub-trees called by the tree they are, where their author gave them no name."""
    return replace(outline, nodes=tuple(map(_named, outline.nodes)))


def _named(node: OutlineNode) -> OutlineNode:
    tree = next((text for text in node.parameters if text.startswith(_SUBTREE)), "")
    if node.kind != "subtree" or node.name != node.type_name or not tree:
        return node
    others = tuple(text for text in node.parameters if text != tree)
    return replace(node, name=tree.removeprefix(_SUBTREE), parameters=others)


def _where(outline: Outline, index: int) -> str:
    above = outline.nodes[index].parent
    while above > 0:
        node = outline.nodes[above]
        if node.type_label:
            return node.name
        above = node.parent
    return ""
