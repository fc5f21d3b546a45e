"""Declared parameters: name, type, unit, default and a one-line doc, said once where they are used.

Skills, tree nodes, robots and scenes all declare what they accept with :func:`param`; reading, checking,
help texts and documentation come from that one declaration.

    @dataclass(frozen=True)
    class Noise:
        position: float = param(0.01, unit="m", minimum=0, doc="Standard deviation.")

    noise = read(Noise, document.load(path))  # see humanoid_bt.core.reading
"""

from __future__ import annotations

import dataclasses
import functools
import types
import typing
from collections.abc import Mapping
from keyword import iskeyword
from typing import Any, NewType

from humanoid_bt.core.units import UNITS, base_unit

PerceptName = NewType("PerceptName", str)
"""The type of a parameter that names a percept; checks use it to see who reads what."""

_REQUIRED: Any = object()


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
        return type_name(self.type) + (f" [{self.unit}]" if self.unit else "")


def param(
    default: Any = _REQUIRED,
    *,
    doc: str,
    unit: str = "",
    minimum: float | None = None,
    above: float | None = None,
    maximum: float | None = None,
) -> Any:
    """Declare a parameter: the value of an annotated attribute of a dataclass, a skill or a tree node.

    Args:
        default: its value if none is given; without one it must be given.
        doc: one line.
        unit: SI unit of a number, of :data:`~humanoid_bt.core.units.UNITS`; it may be written in others of its kind.
        minimum, above, maximum: bounds of a number; it may not be equal to ``above``.

    Raises:
        ValueError: there is no such unit.
    """
    if unit and unit not in UNITS:
        instead = base_unit(f"1 {unit}")
        hint = f"unit={instead!r}, and a value may be written in {unit}" if instead else f"valid: {', '.join(UNITS)}"
        raise ValueError(f"a parameter has no unit {unit!r}; {hint}")
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
        fields = {written(field.name): field for field in dataclasses.fields(cls)}
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
    hints = {written(name): hint for name, hint in typing.get_type_hints(cls).items()}
    for name, spec in declared.items():
        found[name] = dataclasses.replace(spec, name=name, type=hints[name])
    return found


def own(value: Any) -> Any:
    """Return a value whose lists and mappings are its own: who changes them changes nobody else's."""
    if type(value) is list:
        return [own(part) for part in value]
    return {key: own(part) for key, part in value.items()} if type(value) is dict else value


def written(field: str) -> str:
    """Return how a dataclass's field is written in files: ``raise`` for ``raise_``, as Python has a word ``raise``."""
    return field[:-1] if field.endswith("_") and iskeyword(field[:-1]) else field


def type_name(kind: Any) -> str:  # noqa: PLR0911 (a table of cases)
    """Return a type as people read it: ``number``, ``left | right``, ``list of numbers``."""
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Literal:
        return " | ".join(str(arg) for arg in args)
    if kind is Any:
        return "anything"
    if origin in (typing.Union, types.UnionType):
        return " or ".join(type_name(arg) for arg in args if arg is not type(None))
    if args == (Any,):
        return "list"
    if origin in (list, tuple):
        inner = [arg for arg in args if arg is not Ellipsis]
        return f"list of {'' if Ellipsis in args or origin is list else len(inner)} {type_name(inner[0])}s".replace(
            "  ", " "
        )
    if origin is dict:
        return f"mapping of {type_name(args[1])}"
    if kind is PerceptName:
        return "percept"
    if isinstance(kind, typing.NewType):
        return str(kind.__name__).removesuffix("Item").lower()
    if hasattr(kind, "described"):
        return str(kind.described)
    return {float: "number", int: "whole number", str: "text", bool: "true or false"}.get(kind) or str(
        getattr(kind, "__name__", kind)
    )
