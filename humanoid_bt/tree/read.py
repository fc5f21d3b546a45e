"""Reading the nodes of a tree file: from YAML items to drafts, with every mistake noted and none raised."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from humanoid_bt.document import Item
from humanoid_bt.errors import Place, Problem, UserError, nearest
from humanoid_bt.params import Param, read_values
from humanoid_bt.tree.parameters import Parameters
from humanoid_bt.tree.registry import NodeType, Registry


@dataclass
class Draft:
    """A node as its file describes it, before it is made.

    Attributes:
        type: its type.
        place: where it is written.
        name: its name.
        values: its parameters, converted; those with a mistake are missing.
        value_places: where each given parameter's value is written.
        children: its children.
        branches: other sub-trees by key (a watchdog's ``on_stale``).
        sound: whether it can be made: no mistake in it, its children left aside.
    """

    type: NodeType
    place: Place
    name: str
    values: dict[str, Any] = field(default_factory=dict)
    value_places: dict[str, Place] = field(default_factory=dict)
    children: list[Draft] = field(default_factory=list)
    branches: dict[str, Draft] = field(default_factory=dict)
    sound: bool = True

    def below(self) -> Iterator[tuple[str, Draft]]:
        """Return every sub-tree with the key it stands under, "" for children."""
        yield from (("", child) for child in self.children)
        yield from self.branches.items()


def check_name(item: Item) -> None:
    """Check what a node or tree is called.

    Raises:
        UserError: it cannot be a part of a path.
    """
    name = item.value
    if not isinstance(name, str):
        raise UserError(f"a name must be text, not {item.kind}", item.place)
    if not name.strip() or "/" in name or not name.isprintable():
        raise UserError(f"{name!r} cannot be a name", item.place, "one line of text without /")


class Reader:
    """Reads nodes.

    Args:
        registry: the node types.
        parameters: the tree's parameters.
        problems: takes every mistake.
    """

    def __init__(self, registry: Registry, parameters: Parameters, problems: list[Problem]) -> None:
        self._registry = registry
        self._parameters = parameters
        self._problems = problems

    def node(self, item: Item, where: str) -> Draft | None:
        """Read a node: ``type``, or a mapping of one key ``type: body``; None if its type is not known.

        Args:
            item: the node.
            where: what it is, for messages ("the root").
        """
        if isinstance(item.value, str):
            return self._typed(item.value, Item(None, item.place), item.place)
        if not isinstance(item.value, dict) or not item.value:
            kind = "an empty mapping" if isinstance(item.value, dict) else item.kind
            self._problem(f"{where} must be a node, not {kind}", item.place, "like idle, or idle: {...}")
            return None
        keys = list(item.value)
        if len(keys) > 1:
            hint = f"indent the parameters of {keys[0]!r} deeper than it, or write each node as its own list item"
            self._problem(f"a node is one key, here are {len(keys)}", item.key_places[keys[1]], hint)
            known = [key for key in keys if key in self._registry]
            if not known:
                return None
            draft = self._typed(known[0], item.value[known[0]], item.key_places[known[0]])
            if draft:
                draft.sound = False
            return draft
        return self._typed(keys[0], item.value[keys[0]], item.key_places[keys[0]])

    def _typed(self, type_name: str, body: Item, place: Place) -> Draft | None:
        try:
            node_type = self._registry.find(type_name, place)
        except UserError as error:
            self._problems += error.problems
            self._parameters.skim(body)
            return None
        draft = Draft(node_type, place, type_name)
        before = len(self._problems)
        own = self._body(draft, body)
        if own is not None:
            self._values(draft, own)
        draft.sound = draft.sound and len(self._problems) == before
        if own is not None:
            self._below(draft, own)
        return draft

    def _body(self, draft: Draft, body: Item) -> Item | None:
        """Return the body as a mapping, its short forms written out; None if it is none."""
        kind, name = draft.type.kind, draft.type.type_name
        if body.value is None:
            return Item({}, draft.place)
        if isinstance(body.value, dict):
            return body
        if kind == "composite" and isinstance(body.value, list):
            return Item({"children": body}, draft.place, {"children": body.place})
        if kind == "decorator" and isinstance(body.value, str) and body.value in self._registry:
            return Item({body.value: Item(None, body.place)}, draft.place, {body.value: body.place})
        hint = {
            "composite": f"{name}: followed by a list of children",
            "decorator": f"{name}: followed by its parameters and one child",
        }.get(kind, f"{name}: {{{', '.join(f'{key}: ...' for key in draft.type.params)}}}")
        self._problem(f"what {name!r} holds must be a mapping, not {body.kind}", body.place, hint)
        return None

    def _values(self, draft: Draft, body: Item) -> None:
        node_type = draft.type
        given: dict[str, Item] = {}
        wanted = dict(node_type.params)
        for key, item in body.value.items():
            if key == "name":
                self._name(draft, item)
            elif key in wanted:
                value = self._resolved(wanted[key], item)
                if value is None:
                    del wanted[key]  # its mistake is noted, here or where the parameter is declared
                    draft.sound = False
                else:
                    given[key] = value
                    draft.value_places[key] = item.place
            elif node_type.kind in ("condition", "action", "skill"):
                hint = nearest(key, [*node_type.params, "name"])
                self._problem(f"unknown parameter {key!r} of {node_type.type_name!r}", body.key_places[key], hint)
        draft.values, problems = read_values(wanted, Item(given, draft.place), repr(node_type.type_name))
        self._problems += [self._parameters.explain(problem) for problem in problems]

    def _name(self, draft: Draft, item: Item) -> None:
        try:
            resolved = self._parameters.resolve(item)
            if resolved is not None:
                check_name(resolved)
                draft.name = resolved.value
        except UserError as error:
            self._problems += error.problems

    def _resolved(self, spec: Param, item: Item) -> Item | None:
        try:
            parameter = self._parameters.used(item)
            if parameter and parameter.spec.unit and parameter.spec.unit != spec.unit:
                wanted = f"in {spec.unit}" if spec.unit else f"a {spec.type_name} without a unit"
                message = f"{spec.name!r} is {wanted}, {item.value} in {parameter.spec.unit}"
                raise UserError(message, item.place, f"{item.value} is declared at {parameter.place}")
            return self._parameters.resolve(item)
        except UserError as error:
            self._problems += error.problems
            return None

    def _below(self, draft: Draft, body: Item) -> None:
        if draft.type.kind == "composite":
            self._children(draft, body)
        elif draft.type.kind == "decorator":
            self._child(draft, body)

    def _children(self, draft: Draft, body: Item) -> None:
        name = draft.type.type_name
        for key in body.value:
            if key not in draft.type.params and key not in ("name", "children"):
                is_node = key in self._registry
                hint = (
                    "children stand in a list: - first: ..."
                    if is_node
                    else nearest(key, [*draft.type.params, "name", "children"])
                )
                message = (
                    f"{key!r} stands beside the children of {name!r}"
                    if is_node
                    else (f"unknown parameter {key!r} of {name!r}")
                )
                self._broken(draft, message, body.key_places[key], hint)
        children = body.value.get("children")
        if children is None or children.value is None or children.value == []:
            place = children.place if children else draft.place
            self._broken(draft, f"{name!r} needs at least one child", place, f"{name}: followed by a list of nodes")
        elif not isinstance(children.value, list):
            message = f"the children of {name!r} must be a list, not {children.kind}"
            self._broken(draft, message, children.place, "- first: ...")
        else:
            for item in children.value:
                child = self.node(item, f"a child of {name!r}")
                if child is None:
                    draft.sound = False
                else:
                    draft.children.append(child)

    def _child(self, draft: Draft, body: Item) -> None:
        name, known = draft.type.type_name, {"name", *draft.type.params, *draft.type.branches}
        others = [key for key in body.value if key not in known]
        for key in others:
            if key not in self._registry:
                hint = nearest(key, [*known, *self._registry])
                self._broken(
                    draft, f"{key!r} is neither a parameter of {name!r} nor a node", body.key_places[key], hint
                )
                continue
            child = self._typed(key, body.value[key], body.key_places[key])
            if child is None:
                draft.sound = False
            else:
                draft.children.append(child)
        if not others:
            self._broken(draft, f"{name!r} needs a child", draft.place, "a node's key beside its parameters")
        elif len(draft.children) > 1:
            second = draft.children[1].place
            hint = "put them into a sequence, a selector or a parallel"
            self._broken(draft, f"{name!r} has one child, here are {len(draft.children)}", second, hint)
        for key in draft.type.branches:
            if key in body.value:
                branch = self.node(body.value[key], f"{key!r} of {name!r}")
                if branch is None:
                    draft.sound = False
                else:
                    draft.branches[key] = branch

    def _broken(self, draft: Draft, message: str, place: Place, hint: str) -> None:
        draft.sound = False
        self._problem(message, place, hint)

    def _problem(self, message: str, place: Place, hint: str = "") -> None:
        self._problems.append(Problem(message, place, hint))
