"""Setting keys and parameters of a tree while it runs, as text says it."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from py_trees.common import Status

from humanoid_bt.core.errors import Place, UserError, nearest
from humanoid_bt.core.params import Param
from humanoid_bt.core.reading import convert
from humanoid_bt.core.units import base_unit, readable
from humanoid_bt.decision.assign import keys_read
from humanoid_bt.decision.blackboard import Key, names_key
from humanoid_bt.tree.expressions.grammar import names
from humanoid_bt.tree.expressions.holding import expressions_of, holds_expressions
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.node_type import Consistent, names_percepts
from humanoid_bt.tree.source.given import written_item
from humanoid_bt.tree.tree import Tree

_BEFORE = "must be known before the run"


@dataclass(frozen=True)
class Setting:
    """A value that goes with what gets it: a key of the blackboard, or parameters of nodes.

    Attributes:
        name: what people call what is set.
        unit: SI unit of a number, "" for none.
        value: it.
        key: the key that gets it, if one does.
        initially: whether the key begins with it.
        parameters: else the nodes that get it, with their parameter and the value as that takes it.
    """

    name: str
    unit: str
    value: Any
    key: Key | None = None
    initially: bool = False
    parameters: Sequence[tuple[Node, str, Any]] = ()

    def apply(self) -> str:
        """Set it; return it in words."""
        if self.key is not None:
            self.key.put(self.value)
            if self.initially:
                self.key.initial = self.value
        for node, parameter, converted in self.parameters:
            setattr(node.behaviour, parameter, converted)
        return f"{self.name} = {readable(self.value, self.unit)}"


def setting(tree: Tree, name: str, value: Any) -> Setting:
    """Return what gives a key of the blackboard, or a parameter of a node or of the tree, a value; nothing is set yet.

    A node reads a parameter when it needs it: a time-out in each tick, most skills when they start.

    Args:
        tree: the tree that runs.
        name: of the key; ``reach.timeout``, the end of a node's path and a parameter; or of a parameter of the tree,
            which is set wherever nodes are given it as ``$name``.
        value: plain, in SI units, or text as after ``--set``.

    Raises:
        UserError: there is none of this name, it takes no such value, or it must be known before the run.
    """
    keys = {key.name: key for key in tree.keys}
    if name in keys:
        return _of_key(keys[name], value, begun=tree.root.status is not Status.INVALID)
    if name in tree.parameters:
        return _everywhere(tree, name, value)
    path, dot, parameter = name.rpartition(".")
    if not dot:
        hint = nearest(name, [*keys, *tree.parameters]) or "the tree has neither"
        raise UserError(
            f"the tree has no key or parameter {name!r}",
            hint=f"{hint}; of a node: NODE.PARAMETER",
            code="unknown-parameter",
        )
    node = tree.node(path)
    if parameter not in node.type.params:
        hint = nearest(parameter, node.type.params) or "it has none"
        raise UserError(f"{node.path!r} has no parameter {parameter!r}", hint=hint, code="unknown-parameter")
    converted = checked(node, parameter, value)
    unit = node.type.params[parameter].unit
    return Setting(f"{node.path}.{parameter}", unit, converted, parameters=[(node, parameter, converted)])


def _of_key(key: Key, value: Any, begun: bool) -> Setting:
    spec = key.spec or Param(key.name, Any)
    if key.spec is None and isinstance(value, str) and (unit := base_unit(value)):
        spec = Param(key.name, float, unit=unit)
    taken = key.taken(_converted(spec, key.name, value), _place(key.name, value))
    return Setting(key.name, spec.unit, taken, key, initially=not begun)


def uses_of(tree: Tree, name: str) -> list[tuple[Node, str]]:
    """Return the nodes that are given a parameter of the tree, each with its own parameter that gets the value.

    Raises:
        UserError: it cannot be set while the tree runs.
    """
    own = [node for node in tree.nodes if node.place.file == tree.nodes[0].place.file]  # sub-trees have their own names
    uses = [(node, parameter) for node in own for parameter, of in node.references.items() if of == name]
    in_expressions = [node.path for node in own if _asks(node, name)]
    fixed = in_expressions + [node.path for node, _ in uses if node.kind == "subtree"]
    if fixed or not uses:
        where = f"{fixed[0]!r} has taken its value" if fixed else "no node is given it as a whole"
        raise UserError(f"the parameter {name!r} {_BEFORE}: {where}", hint="set NODE.PARAMETER, or run it with --set")
    return uses


def _everywhere(tree: Tree, name: str, value: Any) -> Setting:
    """Return what sets a parameter of the tree wherever it was put in."""
    found = [(node, parameter, checked(node, parameter, value)) for node, parameter in uses_of(tree, name)]
    node, parameter, converted = found[0]
    return Setting(name, node.type.params[parameter].unit, converted, parameters=found)


def _asks(node: Node, name: str) -> bool:
    """Return whether an expression of a node names something."""
    return any(name in names(part.syntax) for value in node.values.values() for part in expressions_of(value))


def checked(node: Node, parameter: str, value: Any) -> Any:
    """Return a value for a parameter of a node that may change while it runs.

    Raises:
        UserError: it must be known before the run, or takes no such value.
    """
    spec, what = node.type.params[parameter], f"{parameter!r} of {node.path!r}"
    if (key := keys_read(node.behaviour).get(parameter)) is not None:
        raise UserError(f"{what} is read from the blackboard when the node starts", hint=f"set {key.name}")
    kinds = (spec.type, *getattr(spec.type, "__args__", ()))
    expression = any(map(holds_expressions, kinds))
    if node.kind == "subtree" or expression or names_percepts(spec.type) or names_key(spec.type):
        raise UserError(
            f"{what} {_BEFORE}", hint="edit the tree's file; with --watch it is swapped in", code="not-dynamic"
        )
    converted = _converted(spec, parameter, value)
    if node.type.commands(node.values) != node.type.commands({**node.values, parameter: converted}):
        raise UserError(f"{what} {_BEFORE}: it decides what the node commands", code="not-dynamic")
    if isinstance(node.behaviour, Consistent):
        other = copy.copy(node.behaviour)
        setattr(other, parameter, converted)
        try:
            other.check_values()
        except ValueError as error:
            raise UserError(str(error), _place(parameter, value), code="out-of-range") from error
    return converted


def _converted(spec: Param, name: str, value: Any) -> Any:
    return convert(replace(spec, name=name), written_item(spec, value, _place(name, value)))


def _place(name: str, value: Any) -> Place:
    return Place(f"{name} = {value}")
