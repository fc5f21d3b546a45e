"""Showing trees: as text, and as pictures for people and for other programs."""

from humanoid_bt.tree.show.dot import dot_tree
from humanoid_bt.tree.show.looks import MARKS
from humanoid_bt.tree.show.mermaid import mermaid_tree
from humanoid_bt.tree.show.outline import Outline, OutlineNode, outline_of
from humanoid_bt.tree.show.svg import svg_tree
from humanoid_bt.tree.show.text import unicode_tree

__all__ = [
    "MARKS",
    "Outline",
    "OutlineNode",
    "dot_tree",
    "mermaid_tree",
    "outline_of",
    "svg_tree",
    "unicode_tree",
]
