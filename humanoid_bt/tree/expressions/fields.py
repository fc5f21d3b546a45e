"""Fields of a message: values and expressions, nested as the message is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.units import readable
from humanoid_bt.decision.calls import UNKNOWN
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.expressions.template import parts_of

_SAMPLES: dict[str, Any] = {"number": 0, "text": "", "truth": False}


@dataclass(frozen=True)
class _Text:
    """Text with expressions in it."""

    parts: tuple[str | Expression, ...]


class Fields(Mapping[str, Any]):
    """What is written into the fields of a message, by their names.

    A value is a number, a truth, text, a list or a mapping of these. ``{expression}`` alone, or ``$name``, is the value
    of the expression, in SI units; with text around it, it is put into the text.

    Args:
        written: as it is written.
        values: the same, with expressions in the place of their text.
        places: path of a field, ``pose.position.x``, -> where it is written.
    """

    described: ClassVar[str] = "mapping of fields"

    def __init__(self, written: Mapping[str, Any], values: Mapping[str, Any], places: Mapping[str, Place]) -> None:
        self.written, self._values, self.places = written, values, places

    @classmethod
    def of(cls, value: Mapping[str, Any]) -> Fields:
        """Return the fields that a mapping of Python stands for; raises as :meth:`from_item`."""
        return value if isinstance(value, Fields) else cls.from_item(item_of(dict(value), Place("")), "fields")

    @classmethod
    def from_item(cls, item: Item, parameter: str) -> Fields:
        """Read fields from a YAML mapping.

        Raises:
            UserError: it is none, or an expression in it is none.
        """
        if not isinstance(item.value, dict):
            hint = "like {data: true}; of a message in a message: {pose: {position: {x: 0.5}}}"
            raise UserError(
                f"{parameter!r} must be a mapping of fields, not {item.kind}", item.place, hint, "wrong-type"
            )
        places: dict[str, Place] = {}
        return cls(item.plain(), _read(item, "", places), places)

    def __getitem__(self, name: str) -> Any:
        return self.written[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.written)

    def __len__(self) -> int:
        return len(self.written)

    def __repr__(self) -> str:
        return f"Fields({dict(self.written)})"

    @property
    def expressions(self) -> list[Expression]:
        """The expressions in it."""
        return list(_expressions(self._values))

    @property
    def percepts(self) -> list[str]:
        """The percepts that its expressions read, once these are linked."""
        return list(dict.fromkeys(percept for expression in self.expressions for percept in expression.percepts))

    def evaluate(self, robot: Robot) -> dict[str, Any]:
        """Return the values that the fields have now.

        Raises:
            Unseen: an expression asks something of a percept that was never seen.
            KeyNotSet: one reads a key that nothing has written yet.
            TypeError: the value of a key has the wrong type.
        """
        found: dict[str, Any] = _filled(self._values, lambda expression: expression.evaluate(robot))
        return found

    @property
    def sample(self) -> dict[str, Any]:
        """Values of the types that the fields will have, UNKNOWN where that is not known; to be checked."""
        found: dict[str, Any] = _filled(self._values, lambda one: _SAMPLES.get(one.type.kind, UNKNOWN))
        return found


def _read(item: Item, path: str, places: dict[str, Place]) -> Any:
    places.setdefault(path, item.place)
    value = item.value
    if isinstance(value, dict):
        places.update({_below(path, name): place for name, place in item.key_places.items()})
        return {name: _read(child, _below(path, name), places) for name, child in value.items()}
    if isinstance(value, list):
        return [_read(child, _below(path, str(index)), places) for index, child in enumerate(value)]
    if value is None:
        raise UserError(f"the field {path!r} has no value", item.place, "leave it out for its default", "wrong-type")
    if not isinstance(value, str):
        return value
    parts = parts_of(value, item.place)
    if len(parts) == 1:
        return parts[0]
    return _Text(parts) if any(isinstance(part, Expression) for part in parts) else "".join(map(str, parts))


def _below(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


def _expressions(value: Any) -> Iterator[Expression]:
    if isinstance(value, Expression):
        yield value
    elif isinstance(value, (Mapping, list, _Text)):
        for part in (
            value.parts if isinstance(value, _Text) else value.values() if isinstance(value, Mapping) else value
        ):
            yield from _expressions(part)


def _filled(value: Any, fill: Any) -> Any:
    if isinstance(value, Expression):
        return fill(value)
    if isinstance(value, Mapping):
        return {name: _filled(part, fill) for name, part in value.items()}
    if isinstance(value, list):
        return [_filled(part, fill) for part in value]
    if isinstance(value, _Text):
        return "".join(part if isinstance(part, str) else readable(fill(part), part.type.unit) for part in value.parts)
    return value
