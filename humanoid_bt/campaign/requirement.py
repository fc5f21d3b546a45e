"""Requirements: what a campaign must show, in the expression language of trees (``success >= 95 %``)."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, cast

from humanoid_bt.campaign.statistics import QUANTILES, Spread
from humanoid_bt.campaign.summary import TIME, Summary, percent
from humanoid_bt.core.errors import UserError, nearest
from humanoid_bt.core.units import readable
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.expressions import grammar
from humanoid_bt.tree.expressions.expression import Truth
from humanoid_bt.tree.expressions.grammar import Binary, Comparison, Literal, Name, Syntax, Unary
from humanoid_bt.tree.expressions.quantities import NUMBER, Type, number

_SHARES: Mapping[str, tuple[str, Callable[[Summary], float]]] = {
    "success": ("Share of trials that succeeded.", lambda summary: summary.success.share),
    "success_low": ("Low end of its 95 % interval.", lambda summary: summary.success.interval.low),
    "success_high": ("High end of it.", lambda summary: summary.success.interval.high),
}
_COUNTS: Mapping[str, tuple[str, Callable[[Summary], float]]] = {
    "trials": ("Trials that are done.", lambda summary: summary.done),
    "failures": ("Those that did not succeed.", lambda summary: summary.done - summary.success.count),
    "fell": ("Those in which the robot fell.", lambda summary: summary.fell),
    "bumped": ("Those in which it touched something that no hand was sent to.", lambda summary: summary.bumped),
    "stopped": ("Those that were stopped for safety.", lambda summary: summary.outcomes.get("stopped", 0)),
    "missed": ("Those in which a push or an event of the script never happened.", lambda summary: summary.incomplete),
    "errors": ("Those in which a skill raised an exception.", lambda summary: summary.outcomes.get("error", 0)),
    "hung": ("Those that took too long on the wall clock.", lambda summary: summary.outcomes.get("hung", 0)),
    "crashed": ("Those whose process died.", lambda summary: summary.outcomes.get("crashed", 0)),
}
NAMES = {name: doc for name, (doc, _) in {**_SHARES, **_COUNTS}.items()}
"""What a requirement can ask of every campaign, beside ``time_p95``, ``hand_error_median`` and the like."""


@dataclass(frozen=True)
class Verdict:
    """Whether a requirement is met.

    Attributes:
        text: the requirement.
        met: whether it is.
        why: the numbers that decide it.
    """

    text: str
    met: bool
    why: str


class Requirement:
    """One requirement.

    Args:
        expression: true where it is met.
        reported: what skills of the trees report, each with its unit.

    Raises:
        UserError: a name in it means nothing, or units do not go together.
    """

    def __init__(self, expression: Truth, reported: Mapping[str, str]) -> None:
        self._expression = expression
        self._names = _Names({TIME: "s", **reported})
        for name in grammar.names(expression.syntax):
            if name not in self._names.known:
                hint = nearest(name, self._names.known)
                raise UserError(f"unknown name {name!r} in {expression.text!r}", expression.place, hint, "expression")
        for name, value in _beside_shares(expression.syntax):
            hint = f"did you mean {value:g} %?" if 1 < value <= 100 else "valid: 0 % to 100 %"
            message = f"{name!r} is a share, from 0 to 1, and never {value:g}"
            raise UserError(message, expression.place, hint, "expression")
        expression.link(self._names)
        self.judge(None)

    def judge(self, summary: Summary | None) -> Verdict:
        """Return whether a campaign meets it; None for a campaign of which nothing is known."""
        self._names.summary = summary
        used = dict.fromkeys(grammar.names(self._expression.syntax))
        text, why = self._expression.text, ", ".join(map(self._names.told, used))
        try:
            return Verdict(text, bool(self._expression.evaluate(cast(Robot, _Nobody()))), why)
        except _Unknown:
            return Verdict(text, False, why)
        except ArithmeticError as error:
            return Verdict(text, False, f"{why}: it cannot be computed ({error})")


def _beside_shares(syntax: Syntax) -> Iterator[tuple[str, float]]:
    """Yield the shares in an expression that are compared with a number that none can be, each with that number."""
    match syntax:
        case Comparison(left=left, right=right):
            for one, other in ((left, right), (right, left)):
                value = _constant(other)
                if isinstance(one, Name) and one.name in _SHARES and value is not None and not 0 <= value <= 1:
                    yield one.name, value
        case Unary(operand=operand):
            yield from _beside_shares(operand)
        case Binary(left=left, right=right):
            yield from _beside_shares(left)
            yield from _beside_shares(right)


def _constant(syntax: Syntax) -> float | None:
    """Return the number that an expression is, None if it is more than that."""
    match syntax:
        case Literal(value=bool() | str()):
            return None
        case Literal(value=value):
            return float(value)
        case Unary(operator="-", operand=operand):
            value = _constant(operand)
            return None if value is None else -value
    return None


class _Unknown(Exception):  # noqa: N818 (the name says it)
    """No trial tells what is asked for."""


class _Names:
    """What names mean in a requirement."""

    def __init__(self, quantities: Mapping[str, str]) -> None:
        self._quantities = {
            f"{name}_{quantile}": (name, unit, share)
            for name, unit in quantities.items()
            for quantile, share in QUANTILES.items()
        }
        self.summary: Summary | None = None

    def value(self, name: str) -> tuple[Type, Callable[[], Any]] | None:
        """Return type and value of a name, None if it means nothing."""
        if name in self._quantities:
            return number(self._quantities[name][1]), lambda: self._now(name)
        return (NUMBER, lambda: self._now(name)) if name in NAMES else None

    def percept(self, name: str) -> str:
        """Refuse to be asked of a percept."""
        raise UserError(f"a campaign has no percept {name!r}", hint=f"valid: {', '.join(self.known)}")

    def is_set(self, _name: str) -> Callable[[], bool] | None:
        """Return None: there is no blackboard."""

    @property
    def fixed(self) -> Collection[str]:
        """No names: all are known when the campaign has run."""
        return ()

    @property
    def known(self) -> Iterator[str]:
        """All names."""
        yield from (*NAMES, *self._quantities)

    def told(self, name: str) -> str:
        """Return a name and its value as people read it."""
        try:
            value = self._now(name)
        except _Unknown as unknown:
            return str(unknown)
        if name in _SHARES:
            return f"{name} is {percent(value)}"
        return f"{name} is {readable(value, self._quantities[name][1] if name in self._quantities else '')}"

    def _now(self, name: str) -> float:
        if self.summary is None:
            return 1.0
        if name in NAMES:
            value = {**_SHARES, **_COUNTS}[name][1](self.summary)
        else:
            quantity, _, share = self._quantities[name]
            _, spread = self.summary.spreads.get(quantity, ("", Spread.of([])))
            value = spread.quantile(share)
        if math.isnan(value):
            raise _Unknown(f"{name} is not known: no trial {'is done' if name in NAMES else 'that succeeded has it'}")
        return value


class _Nobody:
    """Where a robot would be asked: a campaign has none."""

    def __getattr__(self, name: str) -> Any:
        raise UserError("a requirement is about a campaign, not about a robot", hint=f"valid: {', '.join(NAMES)}")
