"""What a type of node says about itself: its parameters, its places for other nodes, what it commands and reads."""

from __future__ import annotations

import functools
import inspect
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, runtime_checkable

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Dummy

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.params import Param, PerceptName
from humanoid_bt.core.texts import told
from humanoid_bt.decision.blackboard import Key, names_key
from humanoid_bt.decision.result import Result, declared_results
from humanoid_bt.decision.skill import Skill
from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.expressions.fields import Fields
from humanoid_bt.tree.results import ANYTHING, AT_ONCE, NEVER_ENDS, Below, Results
from humanoid_bt.tree.slots import Slot, Takes

Kind = Literal["composite", "decorator", "subtree", "condition", "action", "skill"]
"""What a node is for."""

CHILD = "child"
NODE_KEYS = {
    "name": "What the node is called; its type if not given.",
    "children": "The nodes below it.",
    CHILD: "The node below it, where its type is called like a parameter.",
}
"""Keys that a node's body may have besides its parameters: all a name, composites children, decorators a child."""


@runtime_checkable
class Consistent(Protocol):
    """A node whose parameters must go together, or with its children."""

    def check_values(self) -> None:
        """Look at the parameters as they are now.

        Raises:
            ValueError: they do not go together.
        """


@dataclass(frozen=True)
class NodeType:
    """One type of node.

    Attributes:
        type_name: as written in trees.
        kind: composite, decorator, subtree, condition, action or skill.
        cls: its class.
        doc: one line.
        params: its declared parameters by name.
        resources: what it may command.
        takes: how many children it has.
        branches: places for nodes besides the children (a watchdog's ``on_stale``).
        main: the parameter that a body without a mapping gives (``wait: 2 s``), "" for none.
        outputs: of a sub-tree, how its file declares what the keys get that its parameters name.
    """

    type_name: str
    kind: Kind
    cls: type[Behaviour]
    doc: str
    params: Mapping[str, Param]
    resources: tuple[str, ...] = ()
    takes: Takes = "none"
    branches: Mapping[str, Slot] = field(default_factory=dict)
    main: str = ""
    outputs: Mapping[str, Param] = field(default_factory=dict)

    @property
    def factory(self) -> Callable[..., Behaviour]:
        """What makes a node: called with ``name``, children and parameter values."""
        return self.cls

    @property
    def results(self) -> Mapping[str, Result]:
        """Its declared results by name; only skills have some."""
        return declared_results(self.cls)

    @property
    def dynamic(self) -> bool:
        """Whether its parameters can be read from the blackboard, each time it starts."""
        return issubclass(self.cls, Skill) or self.kind in ("action", "subtree")

    def complete(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return a node's parameter values with the defaults of those that are not given."""
        return {name: spec.default for name, spec in self.params.items() if not spec.required} | dict(values)

    def possible_results(self, values: Mapping[str, Any] | None, below: Below) -> Results:
        """Return what a node can answer when it is ticked; see :mod:`~humanoid_bt.tree.results`.

        Args:
            values: its parameters, None if a mistake leaves them open.
            below: what can come from the nodes below it.
        """
        if not getattr(self.cls, "ends", True):
            return NEVER_ENDS
        if not getattr(self.cls, "runs", True):
            return AT_ONCE
        declared = getattr(self.cls, "possible_results", None)
        if values is None or not inspect.ismethod(declared):
            return AT_ONCE if self.kind == "condition" else ANYTHING
        results: Results = declared(self.complete(values), below)
        return results

    def commands(self, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return the resources that a node with these parameter values may command.

        Raises:
            UserError: its class cannot tell.
        """
        narrowed = getattr(self.cls, "resources_for", None)
        from_keys = (name for name, value in values.items() if isinstance(value, Key))
        if narrowed is None or not all(names_key(self.params[name].type) for name in from_keys):
            return self.resources
        try:
            returned = narrowed(self.complete(values))
            wanted = returned if isinstance(returned, str) else tuple(returned)
            if isinstance(wanted, str) or not set(wanted).issubset(self.resources):
                raise ValueError(f"resources_for returned {wanted!r}")
        except Exception as error:  # the skill's code is the user's
            message = f"{self.type_name!r} cannot tell what it commands: {told(error)}"
            hint = f"its resources_for is to return a tuple with some of: {', '.join(self.resources)}"
            raise UserError(message, hint=hint, code="broken-skill") from error
        return tuple(resource for resource in self.resources if resource in wanted)

    def percepts(self, values: Mapping[str, Any]) -> dict[str, list[str]]:
        """Return parameter -> percepts that a node with these parameter values names, as far as they are known."""
        found: dict[str, list[str]] = {}
        if self.kind == "subtree":
            return found  # the nodes in it tell
        for name, spec in self.params.items():
            if names_percepts(spec.type):
                value = values.get(name, None if spec.required else spec.default)
                found[name] = [value] if isinstance(value, str) else list(value or ())
            elif isinstance(value := values.get(name), (Expression, Fields)):
                found[name] = list(dict.fromkeys(filter(None, value.percepts)))
        return found


def placeholder(name: str, doc: str) -> NodeType:
    """Return the type of a node that stands for a parameter without a value (``$action``): to be shown, not made."""
    return NodeType(name, "subtree", Dummy, doc, {})


@functools.cache
def names_percepts(kind: Any) -> bool:
    """Return whether values of a parameter's type are names of percepts, or hold some."""
    if kind is PerceptName:
        return True
    inner = typing.get_args(kind)
    containers = (typing.Union, types.UnionType, list, tuple)
    return typing.get_origin(kind) in containers and any(map(names_percepts, inner))
