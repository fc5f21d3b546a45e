"""Reading declared parameters: from the values of a file to those of a class, with every mistake in its place."""

from __future__ import annotations

import dataclasses
import difflib
import re
import sys
import types
import typing
from collections.abc import Collection, Iterable, Iterator, Mapping
from keyword import iskeyword
from typing import Any, Literal, Protocol, runtime_checkable

from humanoid_bt.core.errors import Problem, UserError, nearest
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import Param, params_of, type_name
from humanoid_bt.core.units import factors, in_si, is_number_text, written_quantity


def convert(spec: Param, item: Item) -> Any:
    """Return a value as a declared parameter's type.

    Raises:
        UserError: the value has the wrong type or unit, or is out of bounds.
    """
    return _convert(spec.type, item, spec)


@runtime_checkable
class Judged(Protocol):
    """A dataclass whose values can be wrong together, though each of them is right."""

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what is wrong, whatever else is.

        Args:
            item: the mapping as it is written.
            values: those of its values that could be read.
        """


def read(cls: type, item: Item, what: str = "") -> Any:
    """Read a YAML mapping into a dataclass whose fields are declared with :func:`param`.

    Args:
        cls: the dataclass.
        item: the mapping.
        what: what is being read, for messages ("robot", "scene").

    Raises:
        UserError: with every problem found, each with its place.
    """
    if not isinstance(item.value, dict):
        raise UserError(f"{what or 'this'} must be a mapping, not {item.kind}", item.place, code="wrong-type")
    values, problems = read_values(params_of(cls), item, what, noun="key")
    if isinstance(cls, Judged):
        problems += cls.mistakes(item, values)
    if problems:
        raise UserError(problems)
    return cls(**{name + "_" * iskeyword(name): value for name, value in values.items()})


def read_values(
    params: Mapping[str, Param],
    item: Item,
    what: str = "",
    also: frozenset[str] = frozenset(),
    noun: Literal["parameter", "key"] = "parameter",
) -> tuple[dict[str, Any], list[Problem]]:
    """Convert a mapping's items by their declarations; return the values and every problem.

    Keys in ``also`` are left to the caller. Missing parameters with a default are not in the values. ``noun`` is
    what a key is called in messages.
    """
    values: dict[str, Any] = {}
    problems: list[Problem] = []
    of = f" of {what}" if what else ""
    unknown = [key for key in item.value if key not in params and key not in also]
    missing = [name for name, spec in params.items() if spec.required and name not in item.value]
    for key, child in item.value.items():
        if key in params:
            try:
                values[key] = convert(params[key], child)
            except UserError as error:
                problems += error.problems
        elif key in unknown:
            message, code = f"unknown {noun} {key!r}{of}", f"unknown-{noun}"
            hint = nearest(key, [*params, *also])
            if len(missing) == 1 and not hint.startswith("did"):
                hint = needed(params[missing[0]])
            problems.append(Problem(message, item.key_places.get(key, item.place), hint, code=code))
    for name in missing[len(unexplained(unknown, [*params, *also], missing)) :]:
        message = f"the {noun} {name!r}{of} is missing"
        problems.append(Problem(message, item.place, needed(params[name]), code=f"missing-{noun}"))
    return values, problems


def unexplained(unknown: Collection[str], known: Collection[str], missing: Collection[str]) -> list[str]:
    """Return the unknown keys that are most likely misspelt for one of the missing: those like no other known one."""
    others = [name for name in known if name not in missing]
    return [key for key in unknown if not difflib.get_close_matches(key, others, n=1)]


def needed(spec: Param) -> str:
    """Return a hint: how a parameter that is missing is written."""
    kind: Any = spec.type
    if dataclasses.is_dataclass(kind):
        keys = [f"{name}: ..." for name, inner in params_of(typing.cast("type", kind)).items() if inner.required]
        if keys:  # some are written as text
            return f"{spec.name}: {{{', '.join(keys)}}}  # {spec.doc}"
    return f"{spec.name}: {spec.type_name}" + f"  # {spec.doc}" * bool(spec.doc)


def _wrong(item: Item, spec: Param, kind: Any) -> UserError:
    message = f"{spec.name!r} must be {with_article(type_name(kind))}, not {_shown(item)}"
    hint = _number_hint(item.value, spec) if kind in (float, int) and isinstance(item.value, str) else spec.doc
    return UserError(message, item.place, hint, code="wrong-type")


def _number_hint(text: str, spec: Param) -> str:
    """Return how a text that is no number would be one, else in what the number is."""
    plain = re.split(r"(?<!\s)\s*(?:#|//)", text)[0]
    pointed = re.sub(r"(?<=\d),(?=\d)", ".", plain)
    if pointed != text and (written_quantity(pointed) or is_number_text(pointed) or pointed.replace(".", "").isdigit()):
        return f"write {pointed}" + ("; a comment begins with a blank and #" if plain != text else ", with a point")
    units = f"a number in {', '.join(factors(spec.unit))}" if factors(spec.unit) else ""
    return ": ".join(filter(None, [units, spec.doc]))


def _shown(item: Item) -> str:
    if isinstance(item.value, (dict, list)) or item.value is None:
        return item.kind
    return f"{item.kind} {item.value!r}"


def _choice(item: Item) -> str:
    return item.kind if isinstance(item.value, (dict, list)) or item.value is None else repr(item.value)


def with_article(noun: str) -> str:
    """Return a noun with its article: ``a number``; some take none, and no noun is a value."""
    if not noun:
        return "a value"
    if noun.startswith(("text", "true", "anything")) or "|" in noun:
        return noun
    return ("an " if noun[0] in "aeiou" else "a ") + noun


def _one(many: str) -> str:
    """Return a plural's singular: push of pushes, event of events; what would leave nothing is a word of its own."""
    return re.sub(r"(?<=sh|ch|ss)es$|(?<=.)s$", "", many)


def _convert(kind: Any, item: Item, spec: Param, what: str = "") -> Any:  # noqa: PLR0911 (a table of cases)
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if kind is Any:
        return item.plain()
    if origin in (typing.Union, types.UnionType):
        return _convert_union(args, item, spec)
    if origin is typing.Literal:
        if not any(type(item.value) is type(arg) and item.value == arg for arg in args):
            quoted = isinstance(item.value, str) and item.value in map(str, args)
            hint = f"write {item.value}, without quotes" if quoted else nearest(str(item.value), [str(a) for a in args])
            raise UserError(f"{spec.name!r} cannot be {_choice(item)}", item.place, hint, code="wrong-choice")
        return item.value
    if origin in (list, tuple):
        return _convert_sequence(origin, args, item, spec)
    if origin is dict:
        if not isinstance(item.value, dict):
            raise _wrong(item, spec, kind)
        what = f"the {_one(spec.name)}"
        parts = [
            (args[1], child, f"{what} {key!r}", dataclasses.replace(spec, name=key))
            for key, child in item.value.items()
        ]
        return dict(zip(item.value, _convert_all(parts), strict=True))
    if hasattr(kind, "from_item"):  # a type that reads itself
        return kind.from_item(item, spec.name)
    if dataclasses.is_dataclass(kind):
        assert isinstance(kind, type)
        return read(kind, item, what or repr(spec.name))
    if kind in (float, int):
        return _convert_number(kind, item, spec)
    python_type = getattr(kind, "__supertype__", kind)
    if not isinstance(item.value, python_type):
        raise _wrong(item, spec, kind)
    return item.value


def _convert_union(args: tuple[Any, ...], item: Item, spec: Param) -> Any:
    if item.value is None and type(None) in args:
        return None
    kinds = [arg for arg in args if arg is not type(None)]
    if len(kinds) == 1:
        return _convert(kinds[0], item, spec)
    lists = [kind for kind in kinds if typing.get_origin(kind) in (list, tuple)]
    for kind in kinds:
        try:
            return _convert(kind, item, spec)
        except UserError:
            meant = kind in (float, int) if _is_number(item.value) else isinstance(item.value, list) and [kind] == lists
            if meant:
                raise  # what is wrong with it says more than what else it could be
    raise _wrong(item, spec, spec.type)


def is_finite(number: float) -> bool:
    """Return whether a number is one; a whole number beyond what a float holds is as good as infinite."""
    return abs(number) <= sys.float_info.max


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _convert_sequence(origin: Any, args: tuple[Any, ...], item: Item, spec: Param) -> Any:
    if not isinstance(item.value, list):
        raise _wrong(item, spec, origin[args])
    kinds = [args[0]] * len(item.value) if origin is list or Ellipsis in args else list(args)
    if len(kinds) != len(item.value):
        message = f"{spec.name!r} must have {len(kinds)} values, not {len(item.value)}"
        raise UserError(message, item.place, spec.doc, code="wrong-length")
    what = with_article(_one(spec.name))
    return origin(_convert_all((kind, part, what, spec) for kind, part in zip(kinds, item.value, strict=True)))


def _convert_all(parts: Iterable[tuple[Any, Item, str, Param]]) -> list[Any]:
    """Convert the parts of a list or a mapping, each as what it is; what is wrong with them is raised together."""
    values: list[Any] = []
    problems: list[Problem] = []
    for kind, item, what, spec in parts:
        try:
            values.append(_convert(kind, item, spec, what))
        except UserError as error:
            problems += error.problems
    if problems:
        raise UserError(problems)
    return values


def _convert_number(kind: Any, item: Item, spec: Param) -> float | int:
    value = item.value
    if isinstance(value, str) and (written := written_quantity(value)):
        number, unit = written
        allowed = factors(spec.unit)
        if unit not in allowed:
            valid = ", ".join(allowed) if allowed else "a plain number"
            message = f"{spec.name!r} has the unit {unit!r}"
            raise UserError(message, item.place, f"valid: {valid}", code="wrong-unit")
        value = in_si(number, allowed[unit])
    elif isinstance(value, str) and is_number_text(value):
        value = float(value)
    if not _is_number(value):
        raise _wrong(item, spec, kind)
    if not is_finite(value):
        raise UserError(f"{spec.name!r} must be finite, not {str(value)[:20]}", item.place, code="out-of-range")
    if kind is int and value != int(value):
        raise _wrong(item, spec, kind)
    low, above, high = spec.minimum, spec.above, spec.maximum
    bad = (low is not None and value < low) or (above is not None and value <= above)
    if bad or (high is not None and value > high):
        bounds = [f">= {low:g}" if low is not None else "", f"> {above:g}" if above is not None else ""]
        bounds.append(f"<= {high:g}" if high is not None else "")
        wanted = " and ".join(bound for bound in bounds if bound)
        message = f"{spec.name!r} must be {wanted}, not {item.value!r}"
        raise UserError(message, item.place, _within(kind, spec), code="out-of-range")
    converted: float | int = kind(value)
    return converted


def _within(kind: Any, spec: Param) -> str:
    """Return a hint: which numbers a parameter takes, and in what."""
    low, above, high = spec.minimum, spec.above, spec.maximum
    if low is not None and low == high:
        return f"write {low:g}"
    bounds = [f"above {above:g}" if above is not None else "", f"from {low:g}" if low is not None else ""]
    bounds.append(f"{'to' if low is not None else 'up to'} {high:g}" if high is not None else "")
    return " ".join(filter(None, [with_article(type_name(kind)), *bounds])) + (f", in {spec.unit}" if spec.unit else "")
