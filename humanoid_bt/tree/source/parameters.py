"""A tree's parameters: declared in its file, given from outside or by the tree that uses it, used as ``$name``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NewType

from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.params import Param, PerceptName, param
from humanoid_bt.core.reading import convert, read
from humanoid_bt.core.units import UNITS, base_unit, is_number_text
from humanoid_bt.decision.blackboard import KEY_NAME, Key

NodeItem = NewType("NodeItem", object)
"""The type of a parameter that stands for a node, given by the tree that uses this one as a sub-tree."""

TYPES: dict[str, Any] = {
    "number": float,
    "integer": int,
    "text": str,
    "boolean": bool,
    "percept": PerceptName,
    "list": list[Any],
    "node": NodeItem,
}
"""Types that a parameter of a tree can declare."""


@dataclass(frozen=True)
class LongForm:
    """A parameter, or a key of the blackboard, declared in full."""

    type: Literal["number", "integer", "text", "boolean", "percept", "list", "node"] | None = param(
        None, doc="Its type; the default's if not given."
    )
    unit: str = param("", doc=f"SI unit of a number: {', '.join(UNITS)}.")
    default: Any = param(None, doc="Its value unless another is given; without one, it must be given.")
    doc: str = param("", doc="One line for people.")


@dataclass(frozen=True)
class Declaration:
    """What a file says about one of its names.

    Attributes:
        spec: type, unit, doc; its default is the plain value of ``default``.
        place: where it is declared.
        default: its default as written, None for none.
        broken: whether it has a mistake, so that its uses are none.
    """

    spec: Param
    place: Place
    default: Item | None
    broken: bool = False


@dataclass(frozen=True)
class Argument:
    """What a parameter is given from outside.

    Attributes:
        value: its value, of the parameter's type; a :class:`Key` if it is read while the tree runs.
        place: where it is given.
        reader: for a node, who reads it: names in it are those of the tree that gives it.
        written: its value as it is written ("60 deg"), None if that is not known.
        unit: the SI unit that a number came with whose parameter is declared without one, "" for none.
    """

    value: Any
    place: Place
    reader: Any = None
    written: Any = None
    unit: str = ""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a tree and its value.

    Attributes:
        spec: its declaration, with the unit of its value if that came with one of its own.
        place: where it is declared.
        value: its value, None if it has none.
        known: whether it has a value.
        given: what it was given from outside, None for its default.
    """

    spec: Param
    place: Place
    value: Any = None
    known: bool = False
    given: Argument | None = None

    @property
    def written(self) -> Any:
        """Its value as it is written ("60 deg"), None if that is not known."""
        if self.given is not None:
            return self.given.written
        return None if self.spec.required else self.spec.default


class Parameters:
    """The parameters of one tree file, in one use of it.

    Args:
        declarations: what the file declares.
        arguments: what is given from outside, by name; the names are declared.
        problems: takes every mistake.
        complete: whether every parameter must have a value: not in a sub-tree that is looked at alone.
    """

    def __init__(
        self,
        declarations: Mapping[str, Declaration],
        arguments: Mapping[str, Argument],
        problems: list[Problem],
        complete: bool = True,
    ) -> None:
        self._problems = problems
        self._used: set[str] = set()
        self._origins: dict[Place, str] = {}
        self._known = {
            name: self._parameter(declaration, arguments.get(name), complete)
            for name, declaration in declarations.items()
        }

    @property
    def values(self) -> dict[str, Any]:
        """The value of every parameter that is known before the run."""
        return {
            name: parameter.value
            for name, parameter in self._known.items()
            if parameter.known and not isinstance(parameter.value, Key) and parameter.spec.type is not NodeItem
        }

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def find(self, name: str) -> Parameter | None:
        """Return a parameter and mark it used; None if there is none of this name."""
        parameter = self._known.get(name)
        if parameter is not None:
            self._used.add(name)
        return parameter

    def resolve(self, item: Item) -> Item | None:
        """Return a value with every ``$name`` in it replaced; None if one of them has no value before the run.

        Raises:
            UserError: there is no such parameter, or its value is only known while the tree runs.
        """
        if isinstance(item.value, list):
            children = [self.resolve(child) for child in item.value]
            known = [child for child in children if child is not None]
            return Item(known, item.place) if len(known) == len(children) else None
        if isinstance(item.value, dict):
            pairs = {key: self.resolve(child) for key, child in item.value.items()}
            found = {key: child for key, child in pairs.items() if child is not None}
            return Item(found, item.place, item.key_places) if len(found) == len(pairs) else None
        name = reference(item)
        if name is None:
            return unescaped(item)
        parameter = self.find(name)
        if parameter is None:
            hint = meant(name, self._known)
            raise UserError(f"unknown parameter {item.value!r}", item.place, hint, "unknown-reference")
        if parameter.spec.type is NodeItem:
            raise UserError(f"{item.value!r} is a node", item.place, "use it where a node stands", "wrong-type")
        if isinstance(parameter.value, Key):
            hint = "it is a key of the blackboard there; only a whole parameter of a skill can be read from one"
            raise UserError(f"{item.value!r} is only known while the tree runs", item.place, hint, "not-dynamic")
        return self.item(parameter, item) if parameter.known else None

    def item(self, parameter: Parameter, use: Item) -> Item:
        """Return a parameter's value as it stands where it is used."""
        if parameter.given:
            place, origin = parameter.given.place, f"{use.value} is used at {use.place}"
        else:
            place, origin = use.place, f"{use.value} is declared at {parameter.place}"
        self._origins[place] = origin
        return item_of(parameter.value, place)

    def explain(self, problem: Problem) -> Problem:
        """Return a problem with a word on the parameter that the value came from, if it came from one."""
        origin = self._origins.get(problem.place) if problem.place else None
        if origin is None:
            return problem
        hint = "; ".join(part for part in (problem.hint.rstrip("."), origin) if part)
        return replace(problem, hint=hint)

    def report_unused(self) -> None:
        """Note a problem for every parameter that no node uses."""
        for name, parameter in self._known.items():
            if name not in self._used:
                hint = f"use it as ${name}, or remove it"
                message = f"the parameter {name!r} is not used"
                self._problems.append(Problem(message, parameter.place, hint, "unused-parameter"))

    def _parameter(self, declaration: Declaration, given: Argument | None, complete: bool) -> Parameter:
        spec, place = declaration.spec, declaration.place
        if given is not None:
            return Parameter(replace(spec, unit=spec.unit or given.unit), place, given.value, True, given)
        if declaration.default is None:
            if complete and not declaration.broken:
                hint = f"give it one: {spec.name}=... (in a shell --set {spec.name}=...), or a default"
                message = f"the parameter {spec.name!r} has no value"
                self._problems.append(Problem(message, place, hint, "missing-parameter"))
            return Parameter(spec, place)
        if spec.type is NodeItem:
            return Parameter(spec, place, declaration.default, True)
        try:
            return Parameter(spec, place, convert(spec, declaration.default), True)
        except UserError as error:
            self._problems += error.problems
            return Parameter(spec, place)


def meant(name: str, known: Iterable[str]) -> str:
    """Return a hint: what a name behind ``$`` that is not known most likely means."""
    if name.startswith("{") and name.endswith("}"):
        return f"write ${name[1:-1]}, without braces"
    return nearest(name, known) or "the tree declares no parameters and writes no keys"


def reference(item: Item) -> str | None:
    """Return the name that a value refers to (``$name``), None if it is no reference."""
    text = item.value
    return text[1:] if isinstance(text, str) and text.startswith("$") and not text.startswith("$$") else None


def references(item: Item) -> Iterator[Item]:
    """Yield every ``$name`` in a value."""
    if isinstance(item.value, (list, dict)):
        for part in item.value.values() if isinstance(item.value, dict) else item.value:
            yield from references(part)
    elif reference(item) is not None:
        yield item


def unescaped(item: Item) -> Item:
    """Return a value with texts that begin with ``$``, written ``$$``, as they are meant."""
    value = item.value
    if isinstance(value, str) and value.startswith("$$"):
        return Item(value[1:], item.place)
    if isinstance(value, list):
        return Item([unescaped(part) for part in value], item.place)
    if isinstance(value, dict):
        return Item({key: unescaped(part) for key, part in value.items()}, item.place, item.key_places)
    return item


def declarations(item: Item | None, what: str, problems: list[Problem]) -> dict[str, Declaration]:
    """Return what a mapping of names to defaults or long forms declares.

    Args:
        item: the mapping, None if the file has none.
        what: one of its names, for messages ("parameter").
        problems: takes every mistake.
    """
    found: dict[str, Declaration] = {}
    if item is None or item.value is None:
        return found
    if not isinstance(item.value, dict):
        message = f"the {what}s must be a mapping, not {item.kind}"
        parts = item.value if isinstance(item.value, list) else []
        hint = "name: {type: ...}" if what == "output" else "name: default"
        problems.append(Problem(message, item.place, hint + ", without dashes" * bool(parts), "wrong-type"))
        return {name: found for part in parts for name, found in _declared_in(part, what).items()}
    for name, value in item.value.items():
        place = item.key_places[name]
        if not KEY_NAME.match(name):
            hint = "letters, digits and _, not beginning with a digit"
            problems.append(Problem(f"{name!r} cannot be a {what}'s name", place, hint, "bad-name"))
        try:
            found[name] = _declaration(name, value, place, what)
        except UserError as error:
            problems += error.problems
            found[name] = Declaration(Param(name, Any), place, None, broken=True)
    return found


def _declared_in(item: Item, what: str) -> dict[str, Declaration]:
    """Return what an item of a list declares, which should be none."""
    return declarations(item, what, []) if isinstance(item.value, dict) else {}


def _declaration(name: str, item: Item, place: Place, what: str) -> Declaration:
    if not isinstance(item.value, dict):
        default = _plain(name, item, what) if item.value is not None else None
        return Declaration(_with_default(inferred(name, default or item), default), place, default)
    form: LongForm = read(LongForm, item, f"the {what} {name!r}")
    default = item.value.get("default")
    if default is not None and default.value is None:
        default = None
    if default is not None and form.type != "node":
        default = _plain(name, default, what)
    if form.unit and form.unit not in UNITS:
        raise UserError(
            f"unknown unit {form.unit!r}", item.value["unit"].place, nearest(form.unit, UNITS), "wrong-unit"
        )
    if form.type is not None:
        spec = Param(name, TYPES[form.type], doc=form.doc, unit=form.unit)
    elif default is not None:
        meant = inferred(name, default)
        spec = Param(name, meant.type, doc=form.doc, unit=form.unit or meant.unit)
    elif form.unit:
        spec = Param(name, float, doc=form.doc, unit=form.unit)
    else:
        hint = f"type: one of {', '.join(TYPES)}"
        message = f"the {what} {name!r} has neither a type nor a default"
        raise UserError(message, item.place, hint, "missing-key")
    if spec.unit and spec.type not in (float, int):
        message = f"the {what} {name!r} has a unit but is no number"
        raise UserError(message, item.value["unit"].place, code="wrong-type")
    return Declaration(_with_default(spec, default), place, default)


def _with_default(spec: Param, default: Item | None) -> Param:
    return spec if default is None else replace(spec, default=default.plain())


def _plain(name: str, default: Item, what: str) -> Item:
    """Return a default as it is meant.

    Raises:
        UserError: there is a reference in it.
    """
    for part in references(default):
        message = f"{part.value!r} cannot stand here: the {what} {name!r} begins with a plain value"
        hint = f"text that begins with $ is written with two: ${part.value}"
        raise UserError(message, part.place, hint, "unknown-reference")
    return unescaped(default)


def inferred(name: str, default: Item) -> Param:
    """Return what a default says about a parameter that declares nothing else: its type and unit."""
    if isinstance(default.value, str):
        unit = base_unit(default.value)  # "45 cm" is a number with a unit
        return Param(name, float, unit=unit or "") if unit or is_number_text(default.value) else Param(name, str)
    kinds = {bool: bool, int: float, float: float, list: list[Any]}  # 1 may become 0.5 with --set
    return Param(name, kinds.get(type(default.value), Any))
