"""Claims: what is asked of a run from outside, in the language of the tree's expressions and some more words.

``outcome == success``, ``reach runs and reach.hand_error < 3 cm``, ``distance(target) < 0.5 m or fell``.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any, cast

from humanoid_bt.core.errors import nearest
from humanoid_bt.core.messages import Mode
from humanoid_bt.core.units import readable
from humanoid_bt.decision.blackboard import KeyNotSet
from humanoid_bt.decision.robot import Robot
from humanoid_bt.session.breakpoints import NamesOf
from humanoid_bt.session.report import OUTCOMES
from humanoid_bt.testing.course import Course, Life, NoValue
from humanoid_bt.tree.expressions import grammar
from humanoid_bt.tree.expressions.expression import Expression, Truth
from humanoid_bt.tree.expressions.grammar import Syntax
from humanoid_bt.tree.expressions.linking import FUNCTIONS, Evaluate, Linker, Names, Unseen, Untold
from humanoid_bt.tree.expressions.quantities import NUMBER, TEXT, TRUTH, Type, number
from humanoid_bt.tree.expressions.vocabulary import PERCEPT, SEEN, Word

_STOPPED = (Mode.PROTECTIVE_STOP, Mode.EMERGENCY_STOP, Mode.DAMP)

WORDS: Mapping[str, Word[Course]] = {
    "outcome": Word(
        f"How the run ended: {', '.join(OUTCOMES)}. Before that it has no value.",
        TEXT,
        lambda course: course.end.outcome,
    ),
    "reason": Word("Why it ended so; ask contains(reason, 'text').", TEXT, lambda course: course.end.reason),
    "time": Word("Time since the run began.", number("s"), lambda course: course.time),
    "fell": Word("Whether the robot fell.", TRUTH, lambda course: course.fell),
    "touched": Word(
        "Whether the robot has touched any object of the scene, or the stand of one.",
        TRUTH,
        lambda course: bool(course.touched),
    ),
    "touched_objects": Word(
        "The names of those, in the order in which it touched them; ask contains(touched_objects, 'box').",
        TEXT,
        lambda course: ", ".join(course.touched),
    ),
    "bumped": Word(
        "Whether it has touched one with anything but a hand that was sent there.",
        TRUTH,
        lambda course: bool(course.bumped),
    ),
    "stopped": Word("Whether the supervisor stops the robot now.", TRUTH, lambda course: course.mode in _STOPPED),
    "estop": Word("Whether an emergency stop is in force.", TRUTH, lambda course: course.mode is Mode.EMERGENCY_STOP),
    "stops": Word("How many stops the supervisor has ordered so far.", NUMBER, lambda course: course.stops),
}
"""What can be asked of a run, beside what its tree can ask."""

VERBS: Mapping[str, tuple[str, Callable[[Life], bool]]] = {
    "runs": ("It runs now.", operator.attrgetter("runs")),
    "ran": ("It had its turn at least once.", operator.attrgetter("ran")),
    "succeeded": ("It ended last with success, and has not begun again.", lambda life: life.ended == "succeeded"),
    "failed": ("It ended last with failure, and has not begun again.", lambda life: life.ended == "failed"),
    "halted": ("It was halted while it ran, and has not begun again.", lambda life: life.ended == "halted"),
}
"""``reach runs``: what can be asked of a node, with one line and how it is found out."""

CONTAINS = "contains"
"""``contains(reason, 'never seen')``: whether a text stands in another."""

FEEDBACK = "feedback"
"""``reach.feedback``: what a node said as it began or ended, of several the one that runs or ended last."""

_RESULT_TYPES = {bool: TRUTH, str: TEXT}


class RunNames(NamesOf):
    """What names mean in claims about a run: what they mean in its tree, and what the run is asked.

    Args:
        course: what the run has come to.
        percepts: those that there may be; any if None.
    """

    def __init__(self, course: Course, percepts: Collection[str] | None = None) -> None:
        super().__init__(course.tree)
        self.course, self.percepts = course, percepts

    @property
    def known(self) -> Iterator[str]:
        """The names of words, results, parameters and keys."""
        yield from WORDS
        yield from self.course.results
        yield from super().known

    def value(self, name: str) -> tuple[Type, Callable[[], Any]] | None:
        """Return type and value of a name, None if there is none."""
        if (word := WORDS.get(name)) is not None:
            return word.type, lambda: word.of(self.course)
        if (known := super().value(name)) is not None:
            return known
        return self.result(name, self.course.lives(self.course.reporting(name)))

    def result(self, name: str, lives: list[Life]) -> tuple[Type, Callable[[], Any]] | None:
        """Return type and value of what one of some nodes reports under a name, None if none declares it."""
        declared = next((results[name] for life in lives if name in (results := life.node.type.results)), None)
        if declared is None:
            return None
        kind = _RESULT_TYPES.get(declared.type) or number(declared.unit)
        return kind, lambda: self.course.result(name, lives)


class _RunLinker(Linker):
    """Links a claim: as an expression of the tree, and to what the run is asked."""

    @property
    def _run(self) -> RunNames:
        return cast(RunNames, self._names)

    def _name(self, name: str) -> tuple[Type, Evaluate]:
        if self._run.value(name) is None:
            hint = nearest(name, self._run.known)
            if self._run.course.nodes(name):
                hint = f"of a node ask: {name} runs, or {', '.join(list(VERBS)[1:])}"
            raise self.mistake(f"unknown name {name!r}", hint)
        return super()._name(name)

    def _doing(self, syntax: grammar.Doing) -> tuple[Type, Evaluate]:
        lives, does = self._lives(syntax.node), VERBS[syntax.verb][1]
        return TRUTH, lambda _robot: any(map(does, lives))

    def _percept(self, written: str, name: str) -> tuple[Type, Evaluate]:
        if self._run.course.nodes(written) and (name == FEEDBACK or name not in (*PERCEPT, SEEN)):
            return self._of_node(written, name)
        percept = self._run.percept(written)
        if self._run.percepts is not None and percept not in self._run.percepts:
            hint = nearest(percept, self._run.percepts) or "its scene publishes none"
            raise self.mistake(f"there is no percept {percept!r} in this run, nor a node of this name", hint)
        return super()._percept(written, name)

    def _of_node(self, node: str, name: str) -> tuple[Type, Evaluate]:
        lives = self._lives(node)
        if name == FEEDBACK:
            return TEXT, lambda _robot: self._run.course.feedback(lives)
        found = self._run.result(name, lives)
        if found is None:
            known = {result for life in lives for result in life.node.type.results}
            raise self.mistake(f"the node {node!r} reports no {name!r}", nearest(name, {*known, FEEDBACK}))
        kind, value = found
        return kind, lambda _robot: value()

    def _call(self, name: str, arguments: tuple[Syntax, ...]) -> tuple[Type, Evaluate]:
        if name != CONTAINS:
            return super()._call(name, arguments)
        linked = [self.link(argument) for argument in arguments]
        if len(linked) != 2 or not all(kind.goes_with(TEXT) for kind, _ in linked):
            raise self.mistake(f"{CONTAINS}() takes two texts", f"{CONTAINS}(reason, 'never seen')")
        (_, whole), (_, part) = linked
        return TRUTH, lambda robot: str(part(robot)) in str(whole(robot))

    def _comparison(self, syntax: grammar.Comparison) -> tuple[Type, Evaluate]:
        named = _outcome_named(syntax)
        if named is None:
            return super()._comparison(syntax)
        name = named.name if isinstance(named, grammar.Name) else named.value
        if name not in OUTCOMES:
            self._at = named.at if isinstance(named, grammar.Name) else self._at
            raise self.mistake(f"no run ends with {name!r}", nearest(str(name), OUTCOMES))
        return super()._comparison(replace(syntax, left=grammar.Name("outcome"), right=grammar.Literal(name)))

    def _lives(self, name: str) -> list[Life]:
        """Return what the nodes of a name do.

        Raises:
            UserError: there are none.
        """
        course = self._run.course
        if found := course.nodes(name):
            return course.lives(found)
        raise self.mistake(f"the tree {course.tree.name!r} has no node {name!r}", nearest(name, course.node_names))


class _Part(Expression):
    """Something that is asked of a run."""

    verbs = tuple(VERBS)
    linker = _RunLinker


class Claim(Truth):
    """What is true or false of a run at a moment.

    Attributes:
        untold: what it asks of a percept that was seen and is not told of it, "" if that did not happen.
    """

    described = "claim about the run"
    verbs = tuple(VERBS)
    linker = _RunLinker

    untold = ""
    _names: RunNames | None = None

    def link(self, names: Names) -> None:
        """Look up its names and check its types.

        Args:
            names: those of a run.

        Raises:
            UserError: a name means nothing, or types or units do not go together.
        """
        super().link(names)
        self._names, self.untold = cast(RunNames, names), ""

    def holds(self, robot: Robot) -> bool | None:
        """Return whether it is true now, None if something that it asks has no value yet.

        Raises:
            TypeError: the value of a key has the wrong type.
            ArithmeticError: something cannot be computed.
        """
        try:
            return bool(self.evaluate(robot))
        except Untold as untold:
            self.untold = str(untold)
            return None
        except (Unseen, KeyNotSet, NoValue):
            return None

    @property
    def asks_outcome(self) -> bool:
        """Whether it asks how the run ended."""
        return "outcome" in grammar.names(self.syntax)

    def values(self, robot: Robot) -> dict[str, str]:
        """Return everything that it asks and the value that this has now, as people read it."""
        assert self._names is not None, "a claim is linked before it is asked"
        asked = {_shown(part): part for part in _asked(self.syntax)}
        return {shown: self._now(part, robot) for shown, part in asked.items()}

    def _now(self, syntax: Syntax, robot: Robot) -> str:
        """Return what a part of it has for a value now."""
        assert self._names is not None
        if isinstance(syntax, grammar.Doing):
            course = self._names.course
            return " | ".join(life.said for life in course.lives(course.nodes(syntax.node)))
        part = _Part(_shown(syntax), self.place, syntax)
        part.link(self._names)
        try:
            return readable(part.evaluate(robot), part.type.unit)
        except Unseen as error:
            return f"no value: {error}"
        except (KeyNotSet, NoValue):
            return "no value yet"


def _outcome_named(syntax: grammar.Comparison) -> grammar.Name | grammar.Literal | None:
    """Return what the outcome is compared with, if that is a name of one: ``outcome == success``."""
    for one, other in ((syntax.left, syntax.right), (syntax.right, syntax.left)):
        if one == grammar.Name("outcome") and isinstance(other, (grammar.Name, grammar.Literal)):
            return other
    return None


def _asked(syntax: Syntax | None) -> Iterator[Syntax]:
    """Yield the parts of a claim that ask something."""
    match syntax:
        case grammar.Name() | grammar.Attribute() | grammar.Doing():
            yield syntax
        case grammar.Call(name, arguments) if name in (*FUNCTIONS, CONTAINS):
            for argument in arguments:
                yield from _asked(argument)
        case grammar.Call():
            yield syntax
        case grammar.Unary(_, operand):
            yield from _asked(operand)
        case grammar.Binary(_, left, right):
            yield from _asked(left)
            yield from _asked(right)
        case grammar.Comparison(_, left, right, hysteresis):
            for part in (grammar.Name("outcome"),) if _outcome_named(syntax) else (left, right, hysteresis):
                yield from _asked(part)


def _shown(syntax: Syntax) -> str:
    match syntax:
        case grammar.Attribute(of, name):
            return f"{of}.{name}"
        case grammar.Call(name, (grammar.Name(of), *_)):
            return f"{name}({of})"
        case grammar.Doing(node):
            return node
        case grammar.Name(name):
            return name
    return ""
