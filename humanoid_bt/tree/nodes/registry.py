"""Node types: the built-in ones and the workspace's skills, each with what it says about itself.

Reading, checking, help and documentation of trees all come from this one registry.
"""

from __future__ import annotations

import difflib
import inspect
import typing
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from py_trees.behaviour import Behaviour

from humanoid_bt.core.declared import is_readable
from humanoid_bt.core.errors import Place, Problem, UserError, any_of, nearest
from humanoid_bt.core.params import Param, params_of
from humanoid_bt.decision.skill import node_type_name
from humanoid_bt.decision.skill_files import load_skills
from humanoid_bt.files.class_files import class_place
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.expressions import grammar
from humanoid_bt.tree.node_type import NODE_KEYS, Kind, NodeType
from humanoid_bt.tree.nodes import BUILTIN, other_libraries
from humanoid_bt.tree.slots import Takes

ALIASES = {"fallback": "selector", "reactive_fallback": "reactive_selector"}
"""Other names of built-in node types, for files that come from elsewhere."""

_TAKES: dict[str, Takes] = {"composite": "many", "decorator": "one"}


class Registry(Mapping[str, NodeType]):
    """Every node type by name.

    Args:
        skills: the workspace's skills by name, as :func:`~humanoid_bt.decision.skill_files.load_skills` gives them.

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

    def find(self, name: str, place: Place | None = None, trees: Collection[str] = ()) -> NodeType:
        """Return a node type.

        Args:
            name: as written in trees.
            place: where it is written.
            trees: names of trees, for hints.

        Raises:
            UserError: there is none of this name.
        """
        if name not in self:
            hint = f"a tree is a node as subtree: {{tree: {name}}}" if name in trees else self.hint(name)
            raise UserError(f"unknown node {name!r}", place, hint, "unknown-node")
        return self[name]

    def hint(self, name: str, others: Collection[str] = ()) -> str:
        """Return what an unknown name most likely means: what it is called here, or the nearest of what is valid.

        Args:
            name: the name.
            others: what would be valid besides node types.
        """
        if foreign := other_libraries.hint(name, self):
            return foreign
        if close := difflib.get_close_matches(name, others, n=1):
            return f"did you mean {close[0]!r}?"
        if owners := self.owners(name):
            return f"it is a key of {any_of(owners)}: write it there"
        if _is_expression(name):
            return f"condition: {name}"
        return nearest(name, [*others, *self._types, *ALIASES], "humanoid-bt nodes")

    def owners(self, key: str) -> list[str]:
        """Return the node types that have a parameter, or a place for a node, of this name."""
        return [name for name, kind in self._types.items() if key in kind.params or key in kind.branches]


def _is_expression(text: str) -> bool:
    """Return whether a text asks something, as conditions do."""
    try:
        return isinstance(grammar.parse(text), (grammar.Comparison, grammar.Call, grammar.Attribute))
    except grammar.SyntaxMistake:
        return False


def _node_type(name: str, kind: Kind, cls: type[Behaviour]) -> NodeType:
    own: type = object if kind == "skill" else cls  # in a skill these may be names of parameters
    return NodeType(
        type_name=name,
        kind=kind,
        cls=cls,
        doc=(vars(cls).get("__doc__") or "").strip().split("\n")[0],
        params=params_of(cls) or (_signature(cls) if kind == "skill" else {}),
        resources=tuple(getattr(cls, "resources", ())),
        takes=getattr(own, "takes", _TAKES.get(kind, "none")),
        branches=getattr(own, "branches", {}),
        main=getattr(own, "main", ""),
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
        kind = hints.get(name, Any)
        spec = Param(name, kind if is_readable(kind) else Any)
        found[name] = spec if argument.default is argument.empty else Param(name, spec.type, argument.default)
    return found
