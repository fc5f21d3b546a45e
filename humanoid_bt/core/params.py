"""Declared parameters: name, type, unit, default and a one-line doc, said once where they are used.

Skills, tree nodes, robots and scenes all declare what they accept with :func:`param`; reading, checking,
help texts and documentation come from that one declaration.

    @dataclass(frozen=True)
    class Noise:
        position: float = param(0.01, unit="m", minimum=0, doc="Standard deviation.")

    noise = read(Noise, document.load(path))
"""

from __future__ import annotations

import copy
import dataclasses
import functools
import math
import re
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any, Literal, NewType

from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.files.document import Item

PerceptName = NewType("PerceptName", str)
"""The type of a parameter that names a percept; checks use it to see who reads what."""

_REQUIRED: Any = object()
_READ_AT_START = "_read_at_start"

_UNITS: dict[str, dict[str, float]] = {  # declared unit -> what may be written, and its factor
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0},
    "rad": {"rad": 1.0, "deg": math.pi / 180},
    "m/s": {"m/s": 1.0, "cm/s": 0.01},
    "rad/s": {"rad/s": 1.0, "deg/s": math.pi / 180},
    "kg": {"kg": 1.0, "g": 0.001},
    "N": {"N": 1.0},
    "Nm": {"Nm": 1.0},
    "Hz": {"Hz": 1.0},
}
UNITS = tuple(_UNITS)
"""SI units that a parameter can declare."""

_EXPONENT = re.compile(r"^[-+]?(?:\d+\.?\d*|\.\d+)[eE][-+]?\d+$")  # YAML 1.1 reads 1e-3 as text
_QUANTITY = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z/]+)\s*$")


@dataclasses.dataclass(frozen=True)
class Param:
    """One declared parameter.

    Attributes:
        name: as written in files.
        type: its Python type.
        default: its default, or :data:`REQUIRED`.
        doc: one line.
        unit: SI unit of a number, "" for none.
        minimum, above, maximum: bounds of a number; ``above`` is exclusive.
    """

    name: str
    type: Any
    default: Any = _REQUIRED
    doc: str = ""
    unit: str = ""
    minimum: float | None = None
    above: float | None = None
    maximum: float | None = None

    @property
    def required(self) -> bool:
        """Whether the parameter has no default."""
        return self.default is _REQUIRED

    @property
    def type_name(self) -> str:
        """The type as people read it: ``number [m]``, ``left | right``."""
        return _type_name(self.type) + (f" [{self.unit}]" if self.unit else "")

    def convert(self, item: Item) -> Any:
        """Return the value of a YAML item as this parameter's type.

        Raises:
            UserError: the value has the wrong type or unit, or is out of bounds.
        """
        return _convert(self.type, item, self)


def param(
    default: Any = _REQUIRED,
    *,
    doc: str,
    unit: str = "",
    minimum: float | None = None,
    above: float | None = None,
    maximum: float | None = None,
) -> Any:
    """Declare a parameter: the value of an annotated attribute of a dataclass, a skill or a tree node."""
    declared = Param("", None, default, doc, unit, minimum, above, maximum)
    if default is _REQUIRED:
        return dataclasses.field(metadata={"param": declared})
    if isinstance(default, (list, dict)):
        return dataclasses.field(default_factory=default.copy, metadata={"param": declared})
    return dataclasses.field(default=default, metadata={"param": declared})


def params_of(cls: type) -> dict[str, Param]:
    """Return the declared parameters of a class, inherited ones first.

    Dataclasses and plain classes (skills, tree nodes) are read alike.
    """
    return dict(_params_of(cls))


@functools.cache
def _params_of(cls: type) -> Mapping[str, Param]:
    found: dict[str, Param] = {}
    if dataclasses.is_dataclass(cls):
        fields = {field.name: field for field in dataclasses.fields(cls)}
    else:
        fields = {
            name: value
            for base in reversed(cls.__mro__)
            for name, value in vars(base).items()
            if isinstance(value, dataclasses.Field)
        }
    declared = {name: field.metadata["param"] for name, field in fields.items() if "param" in field.metadata}
    if not declared:
        return found
    hints = typing.get_type_hints(cls)
    for name, spec in declared.items():
        found[name] = dataclasses.replace(spec, name=name, type=hints[name])
    return found


def assign(target: Any, values: Mapping[str, Any]) -> None:
    """Set an instance's declared parameters as attributes: the values given, defaults for the rest.

    A parameter that is given a key of the blackboard gets the key's value each time the node starts.

    Raises:
        TypeError: a required parameter is missing, or a value is for none that is declared.
    """
    declared, owner = params_of(type(target)), type(target).__name__
    read_at_start: dict[str, Key] = {}
    if unknown := [name for name in values if name not in declared]:
        raise TypeError(f"{owner} has no parameter {', '.join(map(repr, unknown))}")
    for name, spec in declared.items():
        if name not in values and spec.required:
            raise TypeError(f"{owner} needs the parameter {name!r}")
        value = values[name] if name in values else copy.copy(spec.default)
        if isinstance(value, str) and (reads_itself := _reads_itself(spec.type)):
            value = reads_itself.from_item(Item(value, Place(owner)), name)
        if isinstance(value, Key) and not _names_key(spec.type):
            read_at_start[name] = value
            value = None if spec.required else copy.copy(spec.default)
        setattr(target, name, value)
    if read_at_start:
        vars(target)[_READ_AT_START] = read_at_start
        target.initialise = functools.partial(_start, target, declared, read_at_start, target.initialise)


def _start(target: Any, declared: Mapping[str, Param], keys: Mapping[str, Key], initialise: Callable[[], None]) -> None:
    """Give parameters the values of the keys they were given, then start the node."""
    for name, key in keys.items():
        place = Place(f"the blackboard's {key.name!r}")
        setattr(target, name, declared[name].convert(item_of(key.value, place)))
    initialise()


def keys_read(target: Any) -> dict[str, Key]:
    """Return the parameters of an instance that are read from the blackboard each time it starts."""
    found: dict[str, Key] = vars(target).get(_READ_AT_START, {})
    return found


def _names_key(kind: Any) -> bool:
    return kind is Key or Key in typing.get_args(kind)


def _reads_itself(kind: Any) -> Any:
    """Return the type among those of a parameter that reads itself from text, None if there is none."""
    return next((inner for inner in (kind, *typing.get_args(kind)) if hasattr(inner, "from_item")), None)


def is_number_text(text: str) -> bool:
    """Return whether text is a number that YAML 1.1 takes for text (``1e-3``)."""
    return _EXPONENT.match(text) is not None


def quantity(text: str) -> tuple[float, str] | None:
    """Return a written quantity in its SI unit ("45 cm" -> 0.45, "m"), None if it is none."""
    match = _QUANTITY.match(text)
    for unit, known in _UNITS.items():
        if match and match[2] in known:
            return float(match[1]) * known[match[2]], unit
    return None


def written_units(unit: str) -> tuple[str, ...]:
    """Return the units in which a quantity of an SI unit may be written; none for ""."""
    return tuple(_UNITS.get(unit, ()))


def base_unit(text: str) -> str | None:
    """Return the SI unit of a written quantity ("45 cm" -> "m"), None if it is none."""
    found = quantity(text)
    return found[1] if found else None


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
    values, problems = read_values(params_of(cls), item, what)
    if problems:
        raise UserError(problems)
    return cls(**values)


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
    for key, child in item.value.items():
        if key in params:
            try:
                values[key] = params[key].convert(child)
            except UserError as error:
                problems += error.problems
        elif key not in also:
            hint = nearest(key, [*params, *also])
            message, code = f"unknown {noun} {key!r}{of}", f"unknown-{noun}"
            problems.append(Problem(message, item.key_places.get(key), hint, code=code))
    for name, spec in params.items():
        if spec.required and name not in item.value:
            hint = f"{name}: {spec.type_name}  # {spec.doc}"
            message = f"the {noun} {name!r}{of} is missing"
            problems.append(Problem(message, item.place, hint, code=f"missing-{noun}"))
    return values, problems


def _type_name(kind: Any) -> str:  # noqa: PLR0911 (a table of cases)
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Literal:
        return " | ".join(str(arg) for arg in args)
    if kind is Any:
        return "anything"
    if origin in (typing.Union, types.UnionType):
        return " or ".join(_type_name(arg) for arg in args if arg is not type(None))
    if args == (Any,):
        return "list"
    if origin in (list, tuple):
        inner = [arg for arg in args if arg is not Ellipsis]
        return f"list of {'' if Ellipsis in args or origin is list else len(inner)} {_type_name(inner[0])}s".replace(
            "  ", " "
        )
    if origin is dict:
        return f"mapping of {_type_name(args[1])}"
    if kind is PerceptName:
        return "percept"
    if hasattr(kind, "described"):
        return str(kind.described)
    return {float: "number", int: "whole number", str: "text", bool: "true or false"}.get(kind) or str(
        getattr(kind, "__name__", kind)
    )


def _wrong(item: Item, spec: Param, kind: Any) -> UserError:
    message = f"{spec.name!r} must be {_article(_type_name(kind))}, not {_shown(item)}"
    return UserError(message, item.place, spec.doc, code="wrong-type")


def _shown(item: Item) -> str:
    if isinstance(item.value, (dict, list)) or item.value is None:
        return item.kind
    return f"{item.kind} {item.value!r}"


def _article(noun: str) -> str:
    if noun.startswith(("text", "true")) or "|" in noun:
        return noun
    return ("an " if noun[0] in "aeiou" else "a ") + noun


def _convert(kind: Any, item: Item, spec: Param) -> Any:  # noqa: PLR0911 (a table of cases)
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if kind is Any:
        return item.plain()
    if origin in (typing.Union, types.UnionType):
        return _convert_union(args, item, spec)
    if origin is typing.Literal:
        if not any(type(item.value) is type(arg) and item.value == arg for arg in args):
            hint = nearest(str(item.value), [str(a) for a in args])
            raise UserError(f"{spec.name!r} cannot be {_shown(item)}", item.place, hint, code="wrong-choice")
        return item.value
    if origin in (list, tuple):
        return _convert_sequence(origin, args, item, spec)
    if origin is dict:
        if not isinstance(item.value, dict):
            raise _wrong(item, spec, kind)
        return {key: _convert(args[1], child, spec) for key, child in item.value.items()}
    if hasattr(kind, "from_item"):  # a type that reads itself
        return kind.from_item(item, spec.name)
    if dataclasses.is_dataclass(kind):
        assert isinstance(kind, type)
        return read(kind, item, repr(spec.name))
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
    for kind in kinds:
        try:
            return _convert(kind, item, spec)
        except UserError:
            if kind in (float, int) and _is_number(item.value):
                raise  # it is out of bounds, which says more than what else it could be
    raise _wrong(item, spec, spec.type)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _convert_sequence(origin: Any, args: tuple[Any, ...], item: Item, spec: Param) -> Any:
    if not isinstance(item.value, list):
        raise _wrong(item, spec, origin[args])
    kinds = [args[0]] * len(item.value) if origin is list or Ellipsis in args else list(args)
    if len(kinds) != len(item.value):
        message = f"{spec.name!r} must have {len(kinds)} values, not {len(item.value)}"
        raise UserError(message, item.place, spec.doc, code="wrong-length")
    return origin(_convert(kind, child, spec) for kind, child in zip(kinds, item.value, strict=True))


def _convert_number(kind: Any, item: Item, spec: Param) -> float | int:
    value = item.value
    if isinstance(value, str) and (match := _QUANTITY.match(value)):
        allowed = _UNITS.get(spec.unit, {})
        if match[2] not in allowed:
            valid = ", ".join(allowed) if allowed else "a plain number"
            message = f"{spec.name!r} has the unit {match[2]!r}"
            raise UserError(message, item.place, f"valid: {valid}", code="wrong-unit")
        value = float(match[1]) * allowed[match[2]]
    elif isinstance(value, str) and is_number_text(value):
        value = float(value)
    if not _is_number(value):
        raise _wrong(item, spec, kind)
    try:
        finite = math.isfinite(value)
    except OverflowError:  # a whole number beyond what a float holds
        finite = False
    if not finite:
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
        raise UserError(message, item.place, spec.doc, code="out-of-range")
    number: float | int = kind(value)
    return number


def item_of(value: Any, place: Place) -> Item:
    """Wrap a plain Python value (a default, a ``--set`` argument) as an item with one place."""
    if isinstance(value, dict):
        return Item({key: item_of(child, place) for key, child in value.items()}, place)
    if isinstance(value, (list, tuple)):
        return Item([item_of(child, place) for child in value], place)
    return Item(value, place)
