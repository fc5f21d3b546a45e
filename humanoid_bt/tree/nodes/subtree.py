"""A tree inside another one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Dummy
from py_trees.common import Status

from humanoid_bt.core.params import param
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.tree.nodes.decorators import Decorator
from humanoid_bt.tree.results import Below, Results
from humanoid_bt.tree.ticking.tick import Seen, tick


class SubTree(Decorator):
    """Run the tree of another file, with its parameters.

    Beside `tree` stand the parameters of that tree: values, `$name` of this tree's own, nodes for those of type node,
    and for its outputs the keys of this tree's blackboard that get them. All other names in it are its own; its keys
    begin anew each time it starts. The file is looked for beside this one if it is a path, else by its name in the
    workspace and then among the built-in trees.
    """

    type_name: ClassVar[str] = "subtree"
    main: ClassVar[str] = "tree"

    tree: str = param(doc="Name or file of the tree.")

    def __init__(self, name: str, *, tree: str, **arguments: Any) -> None:
        """Make a node that :func:`~humanoid_bt.tree.source.compose.make_tree` fills from the tree's file.

        Args:
            name: the node's name.
            tree: name or file of the tree.
            arguments: its parameters: values, nodes, and keys for what is read from the blackboard; and for its
                outputs the keys that get them.
        """
        super().__init__(name, Dummy(f"what is in {tree}"), tree=tree)
        self.arguments = arguments
        self.keys: Sequence[Key] = ()  # those that begin anew with it
        self._taken: Mapping[Key, Key] = {}

    def fill(self, child: Behaviour, keys: Sequence[Key], taken: Mapping[Key, Key]) -> None:
        """Take what its file holds, once that has been read.

        Args:
            child: the root of the file's nodes.
            keys: the keys that begin anew with it.
            taken: those of its parameters that take the value of a key of the caller when it starts, and that key.
        """
        self.children[:] = [child]
        self.decorated, child.parent = child, self
        self.keys, self._taken = keys, taken

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the tree's results."""
        return below.child

    def initialise(self) -> None:
        """Give the tree's own keys their initial values, and its parameters the values of keys they were given."""
        for key in self.keys:
            key.reset()
        for parameter, key in self._taken.items():
            parameter.set(key.value)

    def advance(self, seen: Seen) -> Status:
        """Tick the tree."""
        return tick(self.decorated, seen)
