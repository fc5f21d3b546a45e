"""Node types: the built-in ones and the workspace's skills, each with what it says about itself.

Reading, checking, help and documentation of trees all come from this one registry.
"""

from __future__ import annotations

import inspect
import types
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Dummy

from humanoid_bt.blackboard import Key
from humanoid_bt.errors import Place, Problem, UserError, nearest
from humanoid_bt.params import Param, PerceptName, params_of
from humanoid_bt.skill import Skill, node_type_name
from humanoid_bt.skill_files import class_place, load_skills
from humanoid_bt.tree import elsewhere
from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.nodes import BUILTIN, Kind
from humanoid_bt.tree.slots import Slot, Takes
from humanoid_bt.workspace import Workspace

ALIASES = {"fallback": "selector", "reactive_fallback": "reactive_selector"}
"""Other names of built-in node types, for files that come from elsewhere."""

_TAKES: dict[str, Takes] = {"composite": "many", "decorator": "one"}

CHILD = "child"
NODE_KEYS = {
    "name": "What the node is called; its type if not given.",
    "children": "The nodes below it.",
    CHILD: "The node below it, where its type is called like a parameter.",
}
"""Keys that a node's body may have besides its parameters: all a name, composites children, decorators a child."""


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

    @property
    def factory(self) -> Callable[..., Behaviour]:
        """What makes a node: called with ``name``, children and parameter values."""
        return self.cls

    @property
    def dynamic(self) -> bool:
        """Whether its parameters can be read from the blackboard, each time it starts."""
        return issubclass(self.cls, Skill) or self.kind in ("action", "subtree")

    def complete(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return a node's parameter values with the defaults of those that are not given."""
        return {name: spec.default for name, spec in self.params.items() if not spec.required} | dict(values)

    def commands(self, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return the resources that a node with these parameter values may command."""
        narrowed = getattr(self.cls, "resources_for", None)
        if narrowed is None or any(isinstance(value, Key) and not self._writes(name) for name, value in values.items()):
            return self.resources
        wanted = set(narrowed(self.complete(values)))
        return tuple(resource for resource in self.resources if resource in wanted)

    def _writes(self, parameter: str) -> bool:
        kind = self.params[parameter].type
        return kind is Key or Key in typing.get_args(kind)

    def percepts(self, values: Mapping[str, Any]) -> dict[str, list[str]]:
        """Return parameter -> percepts that a node with these parameter values names."""
        found: dict[str, list[str]] = {}
        if self.kind == "subtree":
            return found  # the nodes in it tell
        for name, spec in self.params.items():
            if names_percepts(spec.type):
                value = values.get(name, None if spec.required else spec.default)
                found[name] = [value] if isinstance(value, str) else list(value or ())
            elif isinstance(value := values.get(name), Expression):
                found[name] = list(dict.fromkeys(value.percepts))
        return found


class Registry(Mapping[str, NodeType]):
    """Every node type by name.

    Args:
        skills: the workspace's skills by name, as :func:`~humanoid_bt.skill_files.load_skills` gives them.

    Raises:
        UserError: a skill has the name of a built-in node type or of a key that stands beside nodes.
    """

    def __init__(self, skills: Mapping[str, type[Behaviour]]) -> None:
        self._types: dict[str, NodeType] = {}
        keys: set[str] = {*NODE_KEYS, *ALIASES}
        for kind, classes in BUILTIN.items():
            for cls in classes:
                node_type = _node_type(node_type_name(cls), kind, cls)
                self._types[node_type.type_name] = node_type
                if kind == "decorator":
                    keys |= {*node_type.params, *node_type.branches}
        problems: list[Problem] = []
        for name, cls in skills.items():
            if name in self._types or name in keys:
                what = "a built-in node type" if name in self._types else "a key of a built-in node type"
                problems.append(
                    Problem(f"the skill {name!r} has the name of {what}", class_place(cls), "rename it", "taken-name")
                )
            else:
                self._types[name] = _node_type(name, "skill", cls)
        if problems:
            raise UserError(problems)

    @classmethod
    def of(cls, workspace: Workspace) -> Registry:
        """Return the registry of a workspace.

        Raises:
            UserError: its skills cannot be loaded, or clash with built-in node types.
        """
        return cls(load_skills(workspace))

    def __getitem__(self, name: str) -> NodeType:
        return self._types[ALIASES.get(name, name)]

    def __contains__(self, name: object) -> bool:
        return name in self._types or name in ALIASES

    def __iter__(self) -> Iterator[str]:
        return iter(self._types)

    def __len__(self) -> int:
        return len(self._types)

    def find(self, name: str, place: Place | None = None) -> NodeType:
        """Return a node type.

        Raises:
            UserError: there is none of this name.
        """
        name = ALIASES.get(name, name)
        if name not in self._types:
            raise UserError(f"unknown node {name!r}", place, self.hint(name), "unknown-node")
        return self._types[name]

    def hint(self, name: str, others: Iterable[str] = ()) -> str:
        """Return what an unknown name most likely means: what it is called here, or the nearest of what is valid.

        Args:
            name: the name.
            others: what would be valid besides node types.
        """
        return elsewhere.hint(name, self) or nearest(name, [*others, *self._types])


def placeholder(name: str, doc: str) -> NodeType:
    """Return the type of a node that stands for a parameter without a value (``$action``): to be shown, not made."""
    return NodeType(name, "subtree", Dummy, doc, {})


def _node_type(name: str, kind: Kind, cls: type[Behaviour]) -> NodeType:
    return NodeType(
        type_name=name,
        kind=kind,
        cls=cls,
        doc=(vars(cls).get("__doc__") or "").strip().split("\n")[0],
        params=params_of(cls) or (_signature(cls) if kind == "skill" else {}),
        resources=tuple(getattr(cls, "resources", ())),
        takes=getattr(cls, "takes", _TAKES.get(kind, "none")),
        branches=getattr(cls, "branches", {}),
        main=getattr(cls, "main", ""),
    )


def _signature(cls: type) -> dict[str, Param]:
    """Return the parameters of a plain py_trees behaviour: those of its constructor but for the name."""
    found: dict[str, Param] = {}
    constructor = inspect.getattr_static(cls, "__init__")
    try:
        hints = typing.get_type_hints(constructor)
    except (NameError, TypeError):
        hints = {}
    for name, argument in list(inspect.signature(constructor).parameters.items())[1:]:
        if name == "name" or argument.kind in (argument.VAR_POSITIONAL, argument.VAR_KEYWORD):
            continue
        spec = Param(name, hints.get(name, Any))
        found[name] = spec if argument.default is argument.empty else Param(name, spec.type, argument.default)
    return found


def names_percepts(kind: Any) -> bool:
    """Return whether values of a parameter's type are names of percepts, or hold some."""
    if kind is PerceptName:
        return True
    inner = typing.get_args(kind)
    containers = (typing.Union, types.UnionType, list, tuple)
    return typing.get_origin(kind) in containers and any(map(names_percepts, inner))
