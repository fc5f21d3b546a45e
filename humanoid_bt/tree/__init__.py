"""Trees: read from YAML, checked, built as py_trees nodes, shown and ticked."""

from humanoid_bt.tree.compose import make_tree
from humanoid_bt.tree.executor import Executor, NodeChange, NodeError
from humanoid_bt.tree.load import load_tree
from humanoid_bt.tree.registry import NodeType, Registry
from humanoid_bt.tree.show import dot_tree, unicode_tree
from humanoid_bt.tree.tree import Node, Tree

__all__ = [
    "Executor",
    "Node",
    "NodeChange",
    "NodeError",
    "NodeType",
    "Registry",
    "Tree",
    "dot_tree",
    "load_tree",
    "make_tree",
    "unicode_tree",
]
