"""Text with expressions in it: ``the target is {distance(target)} away``."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import ClassVar

from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.items import Item
from humanoid_bt.core.units import readable
from humanoid_bt.decision.blackboard import KeyNotSet
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.expressions.linking import CODE, Unseen

_PIECE = re.compile(
    r"""(?P<text>[^{}]+) | (?P<brace>\{\{|\}\}) | \{(?P<expression>(?:[^{}'"]|'[^']*'|"[^"]*")*)\}""", re.VERBOSE
)
_REFERENCE = re.compile(r"\$[A-Za-z_]\w*")


@dataclass(frozen=True)
class Template:
    """Text with expressions in braces; ``{{`` and ``}}`` stand for braces.

    Attributes:
        text: as it is written.
        parts: plain texts and expressions, in order; these are linked before it is filled.
    """

    text: str
    parts: tuple[str | Expression, ...]

    described: ClassVar[str] = "text with {expressions}"
    """What it is called in messages."""

    @classmethod
    def from_item(cls, item: Item, parameter: str) -> Template:
        """Read a template from a YAML value; a lone ``$name`` is an expression.

        Raises:
            UserError: it is no text, or an expression in it is none.
        """
        if isinstance(item.value, (dict, list, type(None))):
            hint = "like the target is {distance(target)} away"
            raise UserError(f"{parameter!r} must be text, not {item.kind}", item.place, hint, "wrong-type")
        text = " ".join((readable(item.value) if isinstance(item.value, bool) else str(item.value)).split())
        return cls(text, parts_of(text, item.place))

    @property
    def expressions(self) -> list[Expression]:
        """The expressions in it."""
        return [part for part in self.parts if isinstance(part, Expression)]

    def __str__(self) -> str:
        return self.text

    def fill(self, robot: Robot) -> str:
        """Return the text with the values that its expressions have now; what has none is said to have none.

        Raises:
            TypeError: the value of a key has the wrong type.
        """
        return "".join(part if isinstance(part, str) else _value(part, robot) for part in self.parts)


def parts_of(text: str, place: Place) -> tuple[str | Expression, ...]:
    """Return the plain texts and the expressions of a text, in order.

    A lone ``$name`` is an expression; of text that begins with ``$$``, one ``$`` is meant.

    Raises:
        UserError: a brace stands alone, or an expression is none.
    """
    if _REFERENCE.fullmatch(text):
        return (Expression.parse(text, place),)
    found: list[str | Expression] = []
    at = 1 if text.startswith("$$") else 0
    while at < len(text):
        piece = _PIECE.match(text, at)
        if piece is None:
            message = f"a brace of {text!r} stands alone, at {text[at : at + 20]!r}"
            raise UserError(message, place, "{expression}; for a brace itself {{ or }}", CODE)
        if piece["expression"] is not None:
            found.append(Expression.parse(piece["expression"].strip(), place))
        else:
            found.append(piece["text"] or piece["brace"][0])
        at = piece.end()
    return tuple(found)


def _value(expression: Expression, robot: Robot) -> str:
    try:
        value = expression.evaluate(robot)
    except Unseen:
        return "(never seen)"
    except KeyNotSet:
        return "(not set)"
    return readable(value, expression.type.unit)
