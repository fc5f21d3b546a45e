"""Reading the parameters of a node: values, ``$name``, keys of the blackboard, expressions."""

from __future__ import annotations

import typing
from collections.abc import Mapping, Sequence
from typing import Any

from humanoid_bt.core.errors import Problem, UserError, any_of, nearest
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import Param
from humanoid_bt.core.reading import needed, read_values, with_article
from humanoid_bt.core.units import is_number_text
from humanoid_bt.decision.blackboard import Key, are_keys, exchanged, keys_in
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.expressions.holding import expressions_of, holds_expressions
from humanoid_bt.tree.node_type import NodeType, names_percepts
from humanoid_bt.tree.nodes import other_libraries
from humanoid_bt.tree.source.file import check_name
from humanoid_bt.tree.source.parameters import Parameter, reference, references
from humanoid_bt.tree.source.scope import Scope


class ValueReader:
    """Reads the parameters of the nodes of one tree file.

    Args:
        scope: what names mean in the file.
        problems: takes every mistake.
    """

    def __init__(self, scope: Scope, problems: list[Problem]) -> None:
        self._scope = scope
        self._problems = problems

    def read(self, draft: Draft, body: Item, unknown: Sequence[str] = ()) -> None:
        """Read the parameters and the name of a node into its draft.

        Args:
            draft: the node's.
            body: what stands behind the node's type, as a mapping.
            unknown: its keys that mean nothing: most likely they are the parameters that are missing.
        """
        node_type = draft.type
        given: dict[str, Item] = {}
        plainly: dict[str, Any] = {}
        missing = [name for name, spec in node_type.params.items() if spec.required and name not in body.value]
        wanted = {name: spec for name, spec in node_type.params.items() if name not in missing[: len(unknown)]}
        for key, item in body.value.items():
            if key == "name":
                self._name(draft, item)
            elif key in wanted:
                value = self._value(draft, wanted[key], item)
                draft.value_places[key] = item.place
                if value is None:
                    del wanted[key]  # it is read while the tree runs, or its mistake is noted
                else:
                    given[key] = value
                    plainly[key] = self._plainly(item, value)
                    if value.place != item.place:
                        draft.given_places[key] = value.place
            elif node_type.takes == "none" and key in unknown:
                self.unknown(draft, body, key, [*node_type.params, *node_type.branches, "name"])
        values, problems = read_values(wanted, Item(given, draft.place), repr(draft.word))
        self._problems += [self._scope.parameters.explain(problem) for problem in problems]
        draft.written = {key: plain for key, plain in plainly.items() if _in_another_form(values.get(key), plain)}
        literals = literals_of(node_type, values, given)
        write = self._scope.write
        for key, value in values.items():
            place = draft.value_places[key]
            if isinstance(value, Key):
                output = node_type.outputs.get(key)
                draft.values[key] = write(value.name, place, output, literals.get(value.name, ()))
            elif are_keys(value):
                parts = {part: write(part.name, place, None, literals.get(part.name, ())) for part in keys_in(value)}
                draft.values[key] = exchanged(value, parts.__getitem__)
            else:
                draft.values[key] = value
                for expression in expressions_of(value):
                    self._scope.add(expression)

    def unknown(self, draft: Draft, body: Item, key: str, known: Sequence[str], owners: Sequence[str] = ()) -> None:
        """Note that a node has no such parameter.

        Args:
            draft: the node's.
            body: what stands behind the node's type, as a mapping.
            key: what is no parameter.
            known: what would be valid.
            owners: the node types that do have such a parameter.
        """
        draft.sound = False
        self._scope.suppose(body.value[key])
        name = draft.word
        hint = nearest(key, known)
        missing = [spec for other, spec in draft.type.params.items() if spec.required and other not in body.value]
        if len(missing) == 1 and not hint.startswith("did"):
            hint = needed(missing[0])
        elif owners and not hint.startswith("did"):
            hint = f"it is a key of {any_of(owners)}: write it there"
        if meant := other_libraries.hint_for_parameter(draft.type.type_name, key, body.value[key].value):
            hint = meant
        message = f"unknown parameter {key!r} of {name!r}"
        self._problems.append(Problem(message, body.key_places[key], hint, "unknown-parameter"))

    def _name(self, draft: Draft, item: Item) -> None:
        try:
            resolved = self._scope.parameters.resolve(item)
            if resolved is not None:
                check_name(resolved)
                draft.name = resolved.value
                if reference(item) is not None:
                    draft.unresolved["name"] = item.value
        except UserError as error:
            self._problems += error.problems

    def _value(self, draft: Draft, spec: Param, item: Item) -> Item | None:
        """Return a value with what it refers to put in; None if it is read while the tree runs, or is a mistake."""
        if _has_names(spec.type):
            return item
        name, resolved = reference(item), None
        try:
            if name is None:
                resolved = self._scope.parameters.resolve(item)
                if next(references(item), None):
                    draft.unresolved[spec.name] = item.plain()
            else:
                draft.references[spec.name] = name
                parameter = self._scope.parameters.find(name)
                if parameter is None or isinstance(parameter.value, Key):
                    self._dynamic(draft, spec, item, parameter)
                    return None
                _check_unit(spec, item, parameter)
                resolved = self._scope.parameters.resolve(item)
        except UserError as error:
            self._problems += error.problems
        if resolved is None:
            draft.sound = False
        return resolved

    def _plainly(self, item: Item, resolved: Item) -> Any:
        """Return a value as it is written, here or where the parameter got it that it refers to."""
        name = reference(item)
        parameter = self._scope.parameters.find(name) if name is not None else None
        return resolved.plain() if parameter is None else parameter.written

    def _dynamic(self, draft: Draft, spec: Param, item: Item, parameter: Parameter | None) -> None:
        """Let a parameter be read from the blackboard each time the node starts."""
        name = item.value[1:]
        if draft.type.dynamic and spec.type is not Key and not names_percepts(spec.type):
            draft.values[spec.name] = self._scope.read(name, item.place, spec) if parameter is None else parameter.value
            return
        draft.sound = False
        what = f"{spec.name!r} of {draft.word!r}"
        message = f"{what} must be known before the run, and {item.value!r} is a key of the blackboard"
        place, hint = item.place, "give it a value or a parameter"
        if parameter is not None and parameter.given is not None:  # the mistake is that of whoever gave it a key
            place, hint = parameter.given.place, f"{hint}; {item.value} is used at {item.place}"
        self._scope.refuse(name, Problem(message, place, hint, "not-dynamic"))


def _check_unit(spec: Param, item: Item, parameter: Parameter) -> None:
    if parameter.spec.unit and parameter.spec.unit != spec.unit:
        wanted = f"in {spec.unit}" if spec.unit else f"{with_article(spec.type_name)} without a unit"
        message = f"{spec.name!r} is {wanted}, {item.value} in {parameter.spec.unit}"
        if parameter.given is not None and parameter.given.unit:  # the mistake is that of whoever gave it a unit
            raise UserError(message, parameter.given.place, f"{item.value} is used at {item.place}", "wrong-unit")
        raise UserError(message, item.place, f"{item.value} is declared at {parameter.place}", "wrong-unit")


def _has_names(kind: Any) -> bool:
    """Return whether values of a parameter's type look up names by themselves."""
    inner = (kind, *typing.get_args(kind))
    return any(map(holds_expressions, inner))


def _in_another_form(value: Any, plain: Any) -> bool:
    """Return whether a value's written form says more than the value: a unit that is not the SI's."""
    if isinstance(value, bool) or not isinstance(value, (int, float, list, tuple)) or plain is None:
        return False
    if isinstance(plain, str) and is_number_text(plain):
        return False
    return bool(plain != (list(value) if isinstance(value, tuple) else value))


def literals_of(node_type: NodeType, values: Mapping[str, Any], given: Mapping[str, Item]) -> dict[str, list[Item]]:
    """Return what a node writes as it stands in its file, a ``value`` or ``items``, by the name of the key.

    Args:
        node_type: the node's type.
        values: its parameters, converted.
        given: those that it was given, as they are written.
    """
    found: dict[str, list[Item]] = {}
    if node_type.kind == "skill":
        return found  # what it writes is its own
    key, item = values.get("key"), values.get("item")
    if "value" in given and isinstance(key, Key):
        found[key.name] = [given["value"]]
    items = given["items"].value if "items" in given else None
    if isinstance(items, list) and isinstance(item, Key):
        found[item.name] = items
    elif isinstance(items, list):
        rows = [row.value for row in items if isinstance(row.value, list)]
        for index, part in enumerate(keys_in(item)):
            found[part.name] = [row[index] for row in rows if index < len(row) and row[index].value is not None]
    return found
