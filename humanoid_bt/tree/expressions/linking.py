"""Linking expressions: looking up their names, checking types and units, and making what evaluates them."""

from __future__ import annotations

import operator
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, cast

from humanoid_bt.core.errors import HumanoidBtError, Place, UserError, nearest
from humanoid_bt.core.units import factors, readable_pair
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.expressions import grammar
from humanoid_bt.tree.expressions.grammar import Syntax
from humanoid_bt.tree.expressions.held import Held
from humanoid_bt.tree.expressions.quantities import ANYTHING, NODE, NUMBER, TEXT, TRUTH, Type, number, type_of
from humanoid_bt.tree.expressions.vocabulary import PERCEPT, SEEN, STATE

Evaluate = Callable[[Robot], Any]
"""Returns a value, from what the robot knows at the start of the tick."""

CODE = "expression"
"""The code of every mistake in an expression."""

_OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
FUNCTIONS: dict[str, Callable[..., Any]] = {"abs": abs, "min": min, "max": max}
"""Functions of numbers."""

IS_SET = "is_set"
"""``is_set(key)``: whether the blackboard has a value for a key."""


class Unseen(HumanoidBtError):  # noqa: N818 (the name says it)
    """A percept was asked for something that is not known of it: before it was ever seen, most often."""


class Untold(Unseen):
    """A percept that was seen was asked for something that its source does not tell."""


class Names(Protocol):
    """What the names of one tree mean to its expressions."""

    def value(self, name: str) -> tuple[Type, Callable[[], Any]] | None:
        """Return type and value of a parameter or a key of the blackboard, None if there is none of this name."""

    def percept(self, name: str) -> str:
        """Return the percept that a name means: the value of a parameter of this name, else the name itself.

        "" is a percept that is not known: the parameter of a sub-tree that is looked at alone has no value.
        """

    def is_set(self, name: str) -> Callable[[], bool] | None:
        """Return what tells whether a key has a value, None if there is no such key."""

    @property
    def fixed(self) -> Collection[str]:
        """The names of all parameters whose value is known before the run."""

    @property
    def known(self) -> Iterator[str]:
        """The names of all parameters and keys, for hints."""


@dataclass
class Watched:
    """One comparison as it went the last time: what people are told about a condition.

    Attributes:
        source: how its left side is written.
        operator: how it compares.
        steady: whether it need no hysteresis: nothing in it jitters, or it has one.
        type: of what it compares.
        left, right: what it compared; `left` is None before the first time, and where it was not looked at.
        text: the same in words.
        held: what its hysteresis remembers.
    """

    source: str
    operator: str
    steady: bool
    type: Type = ANYTHING
    left: Any = None
    right: Any = None
    held: Held = field(default_factory=Held)

    @property
    def text(self) -> str:
        """What was compared, in words."""
        left, right = readable_pair(self.left, self.right, self.type.unit)
        return f"{self.source} {left} {self.operator} {right}"


class Linker:
    """Links one expression.

    Args:
        text: the expression, for messages.
        place: where it is written.
        text_at: how many columns behind its place its first character stands, None if that is not known.
        names: what names mean.

    Attributes:
        percepts, keys: those that were linked so far.
        comparisons: those that were linked so far.
    """

    def __init__(self, text: str, place: Place, text_at: int | None, names: Names) -> None:
        self._text, self._place, self._text_at = text, place, text_at
        self._names = names
        self.percepts: list[str] = []
        self.keys: list[str] = []
        self.comparisons: list[Watched] = []
        self._at = 0  # index in the text of the part that is linked

    def mistake(self, message: str, hint: str = "") -> UserError:
        """Return an error about the part that is linked."""
        place = within(self._place, self._text_at, self._at)
        return UserError(f"in {self._text!r}: {message}", place, hint, CODE)

    def link(self, syntax: Syntax) -> tuple[Type, Evaluate]:
        """Return type and evaluation of a part; what is raised meanwhile is about it."""
        outside = self._at
        self._at = outside if isinstance(syntax, grammar.Literal) else syntax.at
        found = self._link(syntax)
        self._at = outside
        return found

    def _link(self, syntax: Syntax) -> tuple[Type, Evaluate]:  # noqa: PLR0911 (a table of cases)
        match syntax:
            case grammar.Literal(value, unit):
                kind = number(unit) if unit else type_of(value)
                return kind, lambda _robot: value
            case grammar.Name(name, _):
                return self._name(name)
            case grammar.Attribute(of, name, _):
                return self._state(name) if of == "state" else self._percept(of, name)
            case grammar.Call(name, arguments, _):
                return self._call(name, arguments)
            case grammar.Unary(sign, operand, _):
                return self._unary(sign, operand)
            case grammar.Binary("and" | "or" as word, left, right, _):
                return self._logic(word, left, right)
            case grammar.Binary(sign, left, right, _):
                return self._arithmetic(sign, left, right)
            case grammar.Comparison():
                return self._comparison(syntax)
            case grammar.Doing():
                return self._doing(syntax)

    def _doing(self, _syntax: grammar.Doing) -> tuple[Type, Evaluate]:
        raise self.mistake("a tree cannot ask what its nodes do")

    def _name(self, name: str) -> tuple[Type, Evaluate]:
        found = self._names.value(name)
        if found is None:
            hint = nearest(name, self._names.known) or "the tree declares no parameters and writes no keys"
            raise self.mistake(f"unknown name {name!r}", f"{hint}; of a percept ask distance({name}) or the like")
        kind, value = found
        if kind == NODE:
            raise self.mistake(f"{name!r} is {NODE}", f"use it as ${name} where a node stands")
        if self._names.is_set(name) is not None:
            self.keys.append(name)
        return kind, lambda _robot: value()

    def _state(self, name: str) -> tuple[Type, Evaluate]:
        if name not in STATE:
            raise self.mistake(f"the state has no {name!r}", nearest(name, STATE))
        of = STATE[name].of
        return STATE[name].type, lambda robot: of(robot.state)

    def _percept(self, written: str, name: str) -> tuple[Type, Evaluate]:
        percept = self._names.percept(written)
        if self._names.is_set(written) is not None and (key := self._names.value(written)) and key[0] == TEXT:
            message = f"{written!r} names a percept: it must be known before the run, and is a key of the blackboard"
            raise self.mistake(message, "name the percept itself, or call the key otherwise if a percept is called so")
        if name == SEEN:
            self.percepts.append(percept)
            return TRUTH, lambda robot: robot.track(percept) is not None
        if name not in PERCEPT:
            raise self.mistake(f"a percept has no {name!r}", nearest(name, [*PERCEPT, SEEN]))
        self.percepts.append(percept)
        of = PERCEPT[name].of

        def ask(robot: Robot) -> Any:
            track = robot.track(percept)
            if track is None:
                raise Unseen(robot.why_unseen(percept))
            answer = of(track)
            if answer is None:
                raise Untold(f"nobody tells the {name} of {percept!r}")
            return answer

        return PERCEPT[name].type, ask

    def _call(self, name: str, arguments: tuple[Syntax, ...]) -> tuple[Type, Evaluate]:
        if name in PERCEPT or name in (SEEN, IS_SET):
            if len(arguments) != 1 or not isinstance(arguments[0], grammar.Name):
                what = "key of the blackboard" if name == IS_SET else "percept"
                raise self.mistake(f"{name}() takes the name of one {what}")
            argument = arguments[0].name
            return self._is_set(argument) if name == IS_SET else self._percept(argument, name)
        if name not in FUNCTIONS:
            raise self.mistake(f"unknown function {name!r}", nearest(name, [*PERCEPT, SEEN, IS_SET, *FUNCTIONS]))
        least = 1 if name == "abs" else 2
        if len(arguments) < least or (name == "abs" and len(arguments) > 1):
            raise self.mistake(f"{name}() takes {'one number' if name == 'abs' else 'two or more numbers'}")
        linked = [self._number(argument, f"{name}()") for argument in arguments]
        kind = linked[0][0]
        for other, _ in linked[1:]:
            if not kind.goes_with(other):
                raise self.mistake(f"{kind} and {other} cannot be compared")
            kind = other if kind.exponents is None else kind
        function, values = FUNCTIONS[name], [value for _, value in linked]
        return kind, lambda robot: function(*[value(robot) for value in values])

    def _is_set(self, name: str) -> tuple[Type, Evaluate]:
        is_set = self._names.is_set(name)
        if is_set is None:
            raise self.mistake(f"the blackboard has no key {name!r}", nearest(name, self._names.known))
        return TRUTH, lambda _robot: is_set()

    def _unary(self, sign: str, operand: Syntax) -> tuple[Type, Evaluate]:
        if sign == "not":
            value = self._truth(operand, "not")
            return TRUTH, lambda robot: not value(robot)
        kind, value = self._number(operand, "-")
        return kind, lambda robot: -value(robot)

    def _logic(self, word: str, left: Syntax, right: Syntax) -> tuple[Type, Evaluate]:
        first, before = self._truth(left, word), len(self.comparisons)
        second, skipped, decides = self._truth(right, word), self.comparisons[before:], word == "or"

        def decide(robot: Robot) -> Any:
            answer = first(robot)
            if bool(answer) is not decides:
                return second(robot)
            for comparison in skipped:
                comparison.left = None
            return answer

        return TRUTH, decide

    def _arithmetic(self, sign: str, left: Syntax, right: Syntax) -> tuple[Type, Evaluate]:
        (kind, first), (other, second) = self._number(left, sign), self._number(right, sign)
        if sign in ("*", "/"):
            result = kind.times(other, 1 if sign == "*" else -1)
        else:
            if not kind.goes_with(other):
                raise self.mistake(f"{kind} and {other} cannot be {'added' if sign == '+' else 'subtracted'}")
            result = other if kind.exponents is None else kind
        if sign == "/":
            return result, self._quotient(first, second, right)
        compute = _OPERATORS[sign]
        return result, lambda robot: compute(first(robot), second(robot))

    def _quotient(self, first: Evaluate, second: Evaluate, divisor: Syntax) -> Evaluate:
        why = f"in {self._text!r}: {_called(divisor, 'what is divided by')} is 0"

        def divide(robot: Robot) -> Any:
            above, below = first(robot), second(robot)
            if below == 0:
                raise ZeroDivisionError(why)
            return above / below

        return divide

    def _comparison(self, syntax: grammar.Comparison) -> tuple[Type, Evaluate]:
        before = len(self.percepts)
        (kind, left), (other, right) = self.link(syntax.left), self.link(syntax.right)
        sign = syntax.operator
        if not kind.goes_with(other):
            raise self.mistake(f"{kind} and {other} cannot be compared", _asked(syntax, kind, other))
        self._check_choice(syntax)
        ordered = sign not in ("==", "!=")
        if (ordered and TEXT in (kind, other)) or (ordered and TRUTH in (kind, other)):
            raise self.mistake(f"{kind} and {other} have no order: {sign!r} is for numbers")
        if ordered:
            left = self.only(NUMBER, syntax.left, kind, left)
            right = self.only(NUMBER, syntax.right, other, right)
        jitters = len(self.percepts) > before and ordered
        watched = Watched(syntax.source, sign, not jitters, kind if kind.unit else other)
        self.comparisons.append(watched)
        compare = _OPERATORS[sign]
        if syntax.hysteresis is None:

            def plain(robot: Robot) -> bool:
                watched.left, watched.right = left(robot), right(robot)
                return bool(compare(watched.left, watched.right))

            return TRUTH, plain
        if not ordered:
            raise self.mistake(f"{sign!r} has no hysteresis")
        width_type, width = self._number(syntax.hysteresis, "hysteresis")
        if not width_type.goes_with(kind):
            valid = f"valid: {', '.join(factors(kind.unit))}" if factors(kind.unit) else ""
            raise self.mistake(f"the hysteresis of {kind} cannot be {width_type}", valid)
        fixed = constant(syntax.hysteresis, width, self._names.fixed)
        if fixed is not None and fixed < 0:
            raise self.mistake("a hysteresis cannot be negative", "how much farther it goes on holding, like 5 cm")
        watched.steady = watched.steady or fixed != 0
        looser, held = 1 if sign in ("<", "<=") else -1, watched.held

        def with_hysteresis(robot: Robot) -> bool:
            loosened = held.ask(robot)
            watched.left, watched.right = left(robot), right(robot)
            limit = watched.right + looser * width(robot) if loosened else watched.right
            held.holds = bool(compare(watched.left, limit))
            return held.holds

        return TRUTH, with_hysteresis

    def _check_choice(self, syntax: grammar.Comparison) -> None:
        """Refuse what the state is compared with if it never is that."""
        for part, other in ((syntax.left, syntax.right), (syntax.right, syntax.left)):
            if not (isinstance(part, grammar.Attribute) and isinstance(other, grammar.Literal)):
                continue
            if (choices := choices_of(part)) and other.value not in choices:
                raise self.mistake(
                    f"{part.of}.{part.name} is never {other.value!r}", nearest(str(other.value), choices)
                )

    def _truth(self, syntax: Syntax, word: str) -> Evaluate:
        kind, value = self.link(syntax)
        if not kind.goes_with(TRUTH):
            raise self.mistake(f"{word!r} needs true or false, not {kind}")
        return self.only(TRUTH, syntax, kind, value)

    def _number(self, syntax: Syntax, what: str) -> tuple[Type, Evaluate]:
        kind, value = self.link(syntax)
        if kind.kind not in ("number", "anything"):
            raise self.mistake(f"{what!r} needs {NUMBER.kind}s, not {kind}")
        return kind, self.only(NUMBER, syntax, kind, value)

    def only(self, wanted: Type, syntax: Syntax, kind: Type, evaluate: Evaluate) -> Evaluate:
        """Return the evaluation of a part that raises TypeError where its value is not of the kind that is wanted.

        Args:
            wanted: a type of that kind.
            syntax, kind, evaluate: the part, its type, and its evaluation.
        """
        if kind.kind != "anything":
            return evaluate
        what = f"in {self._text!r}: {_called(syntax, 'a part of it')}"

        def evaluate_checked(robot: Robot) -> Any:
            value = evaluate(robot)
            if type_of(value).kind != wanted.kind:
                raise TypeError(f"{what} is {value!r}, not {wanted}")
            return value

        return evaluate_checked


def choices_of(syntax: Syntax) -> tuple[str, ...]:
    """Return all texts that a part of an expression can be, none if it can be any, or is no text."""
    return STATE[syntax.name].choices if isinstance(syntax, grammar.Attribute) and syntax.of == "state" else ()


def constant(syntax: Syntax, evaluate: Evaluate, fixed: Collection[str] = ()) -> Any:
    """Return the value of what is written in nothing but numbers, words (``true``) and fixed names, else None."""
    if not is_constant(syntax, fixed):
        return None
    try:
        return evaluate(cast(Robot, None))
    except (ArithmeticError, TypeError):
        return None


def is_constant(syntax: Syntax, fixed: Collection[str] = ()) -> bool:
    """Return whether an expression asks nothing of a run: no name but those of fixed values, and no hysteresis."""
    match syntax:
        case grammar.Literal():
            return True
        case grammar.Name(name):
            return name in fixed
        case grammar.Call(name, arguments):
            return name in FUNCTIONS and all(is_constant(argument, fixed) for argument in arguments)
        case grammar.Unary(_, operand):
            return is_constant(operand, fixed)
        case grammar.Binary(_, left, right) | grammar.Comparison(_, left, right, None):
            return is_constant(left, fixed) and is_constant(right, fixed)
    return False


def _asked(syntax: grammar.Comparison, left: Type, right: Type) -> str:
    """Return a hint on a text that is compared with a number: most likely it names a percept."""
    for part, kind, other in ((syntax.left, left, right), (syntax.right, right, left)):
        if isinstance(part, grammar.Name) and kind == TEXT and other.kind == "number":
            return f"of a percept ask distance({part.name}) or the like"
    return ""


def _called(syntax: Syntax, otherwise: str) -> str:
    """Return what a part of an expression is called in messages: its name, else as given."""
    match syntax:
        case grammar.Name(name):
            return repr(name)
        case grammar.Attribute(of, name):
            return repr(f"{of}.{name}")
        case grammar.Call(name, (grammar.Name(of),)):
            return repr(f"{name}({of})")
    return otherwise


def within(place: Place, text_at: int | None, index: int) -> Place:
    """Return the place of a character of an expression, as near as that is known."""
    if text_at is None or not place.line:
        return place
    return replace(place, column=place.column + text_at + index)
