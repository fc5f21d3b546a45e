"""Expressions: what a tree asks of its parameters, the blackboard, percepts and the robot's state.

An expression is read (:class:`Expression`), linked to the names of its tree, which checks types and units, and then
evaluated against the snapshot of a tick.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.items import Item
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.expressions import grammar
from humanoid_bt.tree.expressions.grammar import Syntax, SyntaxMistake
from humanoid_bt.tree.expressions.linking import CODE, Evaluate, Linker, Names, Watched, constant, within
from humanoid_bt.tree.expressions.quantities import ANYTHING, TRUTH, Type

_LinkerType = type[Linker]  # "type" is a field of expressions


@dataclass
class Expression:
    """One expression of a tree.

    Attributes:
        text: as it is written.
        place: where.
        text_at: how many columns behind its place its first character stands, None if that is not known.
        type: of its value, once it is linked.
        percepts: the percepts that it reads, once it is linked.
        keys: the keys of the blackboard that it reads, once it is linked.
        comparisons: its comparisons, once it is linked.
    """

    text: str
    place: Place
    syntax: Syntax
    text_at: int | None = None
    type: Type = ANYTHING
    percepts: list[str] = field(default_factory=list)
    keys: list[str] = field(default_factory=list)
    comparisons: list[Watched] = field(default_factory=list)
    _evaluate: Evaluate | None = None

    wanted: ClassVar[Type | None] = None
    """The type that its value must have, None for any."""

    described: ClassVar[str] = "expression"
    """What it is called in messages."""

    verbs: ClassVar[tuple[str, ...]] = ()
    """What it can ask of nodes."""

    linker: ClassVar[_LinkerType] = Linker
    """What links it."""

    @classmethod
    def from_item(cls, item: Item, parameter: str) -> Self:
        """Read an expression from a YAML value: text, or a plain number or boolean.

        Raises:
            UserError: it is none.
        """
        if isinstance(item.value, bool):
            text = "true" if item.value else "false"
        elif isinstance(item.value, (int, float)):
            text = repr(item.value)
        elif isinstance(item.value, str):
            text = item.value
        else:
            hint = "like distance(target) < 0.5 m"
            raise UserError(f"{parameter!r} must be an expression, not {item.kind}", item.place, hint, "wrong-type")
        return cls.parse(text, item.place, item.text_at)

    @classmethod
    def parse(cls, text: str, place: Place | None = None, text_at: int | None = None) -> Self:
        """Read an expression.

        Args:
            text: the expression.
            place: where it is written.
            text_at: how many columns behind its place its first character stands, None if that is not known.

        Raises:
            UserError: it is none.
        """
        try:
            return cls(text, place or Place(""), grammar.parse(text, cls.verbs), text_at)
        except SyntaxMistake as mistake:
            where = within(place, text_at, mistake.at) if place else None
            raise UserError(f"{text!r} is no expression: {mistake}", where, mistake.hint, CODE) from mistake

    def __str__(self) -> str:
        return self.text

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expression) and other.syntax == self.syntax

    __hash__ = None  # type: ignore[assignment]  # it is mutable, and equal by what it says

    @property
    def linked(self) -> bool:
        """Whether its names have been looked up."""
        return self._evaluate is not None

    def link(self, names: Names) -> None:
        """Look up its names and check its types.

        Args:
            names: what names mean.

        Raises:
            UserError: a name means nothing, or types or units do not go together.
        """
        linker = self.linker(self.text, self.place, self.text_at, names)
        self.type, evaluate = linker.link(self.syntax)
        self.percepts, self.keys, self.comparisons = linker.percepts, linker.keys, linker.comparisons
        if self.wanted is not None:
            if not self.type.goes_with(self.wanted):
                raise linker.mistake(f"it is {self.type}, but must be {self.wanted}", "like distance(target) < 0.5 m")
            evaluate = linker.only(self.wanted, self.syntax, self.type, evaluate)
        self._evaluate = evaluate

    def evaluate(self, robot: Robot) -> Any:
        """Return its value now.

        Raises:
            Unseen: it asks something of a percept that was never seen.
            KeyNotSet: it reads a key that nothing has written yet.
            TypeError: the value of a key has the wrong type.
        """
        assert self._evaluate is not None, "an expression is linked before it is evaluated"
        return self._evaluate(robot)

    @property
    def constant(self) -> Any:
        """Its value if it is written in nothing but numbers and words (``true``, ``1 < 2``), else None."""
        return None if self._evaluate is None else constant(self.syntax, self._evaluate)

    def forget(self) -> None:
        """Forget which comparisons held: hysteresis begins anew."""
        for comparison in self.comparisons:
            comparison.held.holds = False

    def explain(self) -> str:
        """Return in words what was compared the last time."""
        compared = [comparison.text for comparison in self.comparisons if comparison.left is not None]
        return ", ".join(compared) or self.text


class Truth(Expression):
    """An expression that is true or false: what conditions ask."""

    wanted = TRUTH
