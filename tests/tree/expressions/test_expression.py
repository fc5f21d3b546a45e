"""Expressions: what they mean, what is refused, and how hysteresis works."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.messages import Percept
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.expressions.expression import Expression, Truth
from humanoid_bt.tree.expressions.grammar import MAX_DEPTH, MAX_LENGTH
from humanoid_bt.tree.expressions.linking import Unseen
from humanoid_bt.tree.expressions.quantities import ANYTHING, NUMBER, TEXT, TRUTH, Type, number
from tests.tree.helpers import make_robot, make_state


class Names:
    """Parameters ``near`` [m], ``side``, ``ready``, ``thing`` (a percept) and the key ``count``."""

    def __init__(self) -> None:
        self.count = Key("count")
        self.values: dict[str, tuple[Type, Any]] = {
            "near": (number("m"), 0.5),
            "side": (TEXT, "left"),
            "ready": (TRUTH, True),
            "thing": (TEXT, "cup"),
            "patience": (number("s"), 2.0),
        }

    @property
    def fixed(self) -> Collection[str]:
        return self.values

    @property
    def known(self) -> Iterator[str]:
        yield from (*self.values, "count")

    def value(self, name: str) -> tuple[Type, Callable[[], Any]] | None:
        if name == "count":
            return ANYTHING, lambda: self.count.value
        if name not in self.values:
            return None
        kind, value = self.values[name]
        return kind, lambda: value

    def percept(self, name: str) -> str:
        return self.values[name][1] if name in self.values else name

    def is_set(self, name: str) -> Callable[[], bool] | None:
        return (lambda: self.count.is_set) if name == "count" else None


@pytest.fixture
def names() -> Names:
    return Names()


@pytest.fixture
def robot() -> Robot:
    """A robot at the origin that sees a cup 0.4 m ahead, 0.3 m to the left."""
    robot = make_robot(CycleClock())
    see(robot, 0.4, 0.3)
    return robot


def see(robot: Robot, x: float, y: float = 0.0) -> None:
    time = robot.clock.now()
    robot.begin_tick(make_state(time), {"cup": Percept("cup", time, np.array([x, y, 1.0]), 0.8)})
    robot.clock._engine.cycle += 100  # type: ignore[attr-defined]  # a test moves time


def evaluate(text: str, names: Names, robot: Robot) -> Any:
    expression = Expression.parse(text)
    expression.link(names)
    return expression.evaluate(robot)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("7 - 2 - 1", 4),
        ("8 / 2 / 2", 2),
        ("-2 - -3", 1),
        ("1e-3 * 1000", 1),
        ("2 < 3", True),
        ("1 < 2 < 3", True),
        ("1 < 3 < 2", False),
        ("true and not false", True),
        ("false or true and false", False),
        ("not not true", True),
        ("'left' == side", True),
        ('side != "left"', False),
        ("side == 'right' or ready", True),
        ("min(3, 1, 2) + max(1, 2) + abs(-4)", 7),
        ("near", 0.5),
        ("$near * 2", 1.0),
        ("50 cm == near", True),
        ("90 deg > 1.5", True),
        ("0.5 s + 500 ms", 1.0),
        ("2 m / 4 s < 1 m/s", True),
        ("1.5 min == 90 s", True),
        ("distance(cup)", 0.5),
        ("cup.distance <= near", True),
        ("cup.distance == distance(thing)", True),
        ("cup.confidence > 0.6 and cup.height > 50 cm", True),
        ("cup.confidence > 60 % and 5% == 0.05 and not 12.5 % > 0.125", True),
        ("bearing(cup) > 30 deg", True),
        ("seen(cup) and not seen(ball)", True),
        ("seen(ball) and distance(ball) < 1", False),
        ("is_set(count)", False),
        ("state.standing and state.mode == 'run'", True),
        ("state.time == 0 s and state.speed < 1 cm/s", True),
    ],
)
def test_what_expressions_mean(text: str, value: object, names: Names, robot: Robot) -> None:
    assert evaluate(text, names, robot) == pytest.approx(value)


def test_a_key_is_read_when_the_expression_is_evaluated(names: Names, robot: Robot) -> None:
    expression = Expression.parse("count + 1 >= 3 and is_set(count)")
    expression.link(names)
    names.count.set(1)
    assert expression.evaluate(robot) is False
    names.count.set(2)
    assert expression.evaluate(robot) is True
    assert expression.explain() == "count + 1 3 >= 3"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("1 + 2 / count > 3", "in '1 + 2 / count > 3': 'count' is 0"),
        ("1 / state.time > 3", "in '1 / state.time > 3': 'state.time' is 0"),
        ("1 / (count * 2)", "in '1 / (count * 2)': what is divided by is 0"),
    ],
)
def test_what_is_0_is_named_where_it_is_divided_by(names: Names, robot: Robot, text: str, why: str) -> None:
    names.count.set(0)
    with pytest.raises(ZeroDivisionError, match=re.escape(why)):
        evaluate(text, names, robot)


@pytest.mark.parametrize("value", ["false", "true", 0, 2])
@pytest.mark.parametrize("text", ["count", "not count", "ready and count", "count or ready"])
def test_only_true_and_false_are_truths(names: Names, robot: Robot, text: str, value: object) -> None:
    condition = Truth.parse(text)
    condition.link(names)
    names.count.set(value)
    with pytest.raises(TypeError, match=re.escape(f"in {text!r}: 'count' is {value!r}, not true or false")):
        condition.evaluate(robot)


@pytest.mark.parametrize("text", ["count * 2", "-count", "abs(count)", "1 / count", "count < 1", "1 m >= count"])
@pytest.mark.parametrize("value", ["2", True])
def test_only_numbers_are_computed_with(names: Names, robot: Robot, text: str, value: object) -> None:
    names.count.set(value)
    with pytest.raises(TypeError, match=re.escape(f"in {text!r}: 'count' is {value!r}, not a plain number")):
        evaluate(text, names, robot)


def test_and_and_or_do_not_look_further_than_they_must(names: Names, robot: Robot) -> None:
    assert evaluate("false and count > 1", names, robot) is False
    assert evaluate("true or count > 1", names, robot) is True


def test_what_was_never_seen_has_no_distance(names: Names, robot: Robot) -> None:
    with pytest.raises(Unseen, match="'ball' was never seen"):
        evaluate("not distance(ball) < 1", names, robot)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "a value is expected at the end"),
        ("1 +", "a value is expected at the end"),
        ("(1", "')' is expected at the end"),
        ("1 2", "'2' is not expected there"),
        ("a = 1", "write =="),
        ("x ** 2", "write x * x"),
        ("__import__('os')", "unknown function '__import__'"),
        ("side.__class__", "no '__class__'"),
        ("lambda: 1", "':' means nothing"),
        ("[1]", "'[' means nothing"),
        ("'open", '"\'" means nothing'),
        ("cup.", "a name is expected after 'cup.'"),
        ("1e999", "not finite"),
        ("(" * (MAX_DEPTH + 1) + "1", f"deeper than {MAX_DEPTH}"),
        ("1" + "+1" * MAX_LENGTH, f"more than {MAX_LENGTH} characters"),
        ("nearr", "unknown name 'nearr'"),
        ("cup", "unknown name 'cup'"),
        ("state.standng", "the state has no 'standng'"),
        ("state.mode == 'estop'", "state.mode is never 'estop'"),
        ("state.gait != 'walk'", "state.gait is never 'walk'"),
        ("cup.distanc", "a percept has no 'distanc'"),
        ("distance(1)", "distance() takes the name of one percept"),
        ("distance(cup, ball)", "distance() takes the name of one percept"),
        ("dist(cup)", "unknown function 'dist'"),
        ("is_set(near)", "the blackboard has no key 'near'"),
        ("min(1)", "min() takes two or more numbers"),
        ("abs(1, 2)", "abs() takes one number"),
        ("near < 2 s", "a number in m and a number in s cannot be compared"),
        ("near + 2 s", "a number in m and a number in s cannot be added"),
        ("near * near < 1 m", "a number in m^2 and a number in m cannot be compared"),
        ("max(1 m, 2 s)", "a number in m and a number in s cannot be compared"),
        ("side < 'x'", "have no order"),
        ("ready > false", "have no order"),
        ("side == 1", "text and a plain number cannot be compared"),
        ("side + 1", "'+' needs numbers, not text"),
        ("-side", "'-' needs numbers, not text"),
        ("near and ready", "'and' needs true or false, not a number in m"),
        ("not 1", "'not' needs true or false, not a plain number"),
        ("near < 1 hysteresis 5 deg", "the hysteresis of a number in m cannot be a number in rad"),
        ("near == 1 hysteresis 5 cm", "'==' has no hysteresis"),
        ("near < 1 hysteresis -5 cm", "a hysteresis cannot be negative"),
        ("near < 1 hysteresis 1 cm - 2 cm", "a hysteresis cannot be negative"),
        ("distance(cup) < 1 hysteresis -near", "a hysteresis cannot be negative"),
        ("distance(cup) < 1 hysteresis min(near, -5 cm)", "a hysteresis cannot be negative"),
    ],
)
def test_what_is_refused(text: str, message: str, names: Names) -> None:
    with pytest.raises(UserError) as raised:
        Expression.parse(text).link(names)
    assert message in str(raised.value)
    assert {problem.code for problem in raised.value.problems} == {"expression"}


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("nearr < 1", "near"),
        ("state.standng", "standing"),
        ("cup.distanc < 1", "distance"),
        ("dist(cup) < 1", "distance"),
    ],
)
def test_the_nearest_name_is_told(text: str, name: str, names: Names) -> None:
    with pytest.raises(UserError, match=f"did you mean '{name}'"):
        Expression.parse(text).link(names)


def test_a_condition_must_be_true_or_false(names: Names) -> None:
    with pytest.raises(UserError, match="it is a number in m, but must be true or false"):
        Truth.parse("near * 2").link(names)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("near / patience", number("m/s")),
        ("near / near", NUMBER),
        ("1 / patience", number("Hz")),
        ("2 * near", number("m")),
        ("3 + near", number("m")),
        ("count * near", ANYTHING),
        ("near < 1", TRUTH),
    ],
)
def test_types_of_results(text: str, kind: Type, names: Names) -> None:
    expression = Expression.parse(text)
    expression.link(names)
    assert expression.type == kind


def test_what_an_expression_reads_is_known(names: Names) -> None:
    expression = Expression.parse("distance(cup) < near and thing.confidence > 0.6 hysteresis 0.1 and count == 1")
    expression.link(names)
    assert expression.percepts == ["cup", "cup"]
    assert expression.keys == ["count"]
    assert [comparison.steady for comparison in expression.comparisons] == [False, True, True]


@pytest.mark.parametrize(
    ("width", "steady"),
    [("0 m", False), ("abs(0)", False), ("near - 50 cm", False), ("near", True), ("distance(cup)", True)],
)
def test_a_hysteresis_of_nothing_steadies_nothing(names: Names, width: str, steady: bool) -> None:
    expression = Expression.parse(f"distance(cup) < 1 m hysteresis {width}")
    expression.link(names)
    assert [comparison.steady for comparison in expression.comparisons] == [steady]


def test_hysteresis_holds_on_beyond_the_threshold_until_it_is_forgotten(names: Names, robot: Robot) -> None:
    expression = Expression.parse("distance(cup) < 0.5 m hysteresis 10 cm")
    expression.link(names)

    def at(distance: float) -> Any:
        see(robot, distance)
        return expression.evaluate(robot)

    assert [at(0.55), at(0.45), at(0.55), at(0.61), at(0.55), at(0.45)] == [False, True, True, False, False, True]
    expression.forget()
    assert at(0.55) is False


def test_what_is_explained_was_compared_this_time(names: Names, robot: Robot) -> None:
    expression = Expression.parse("count > 0 or near > 1 m")
    expression.link(names)
    for count, explained in ((0, "count 0 > 0, near 0.5 m > 1 m"), (5, "count 5 > 0")):
        names.count.set(count)
        expression.evaluate(robot)
        assert expression.explain() == explained


def test_hysteresis_of_a_lower_bound(names: Names, robot: Robot) -> None:
    expression = Expression.parse("distance(cup) > 0.5 m hysteresis 0.1")
    expression.link(names)
    answers = []
    for distance in (0.45, 0.55, 0.45, 0.39, 0.45):
        see(robot, distance)
        answers.append(expression.evaluate(robot))
    assert answers == [False, True, True, False, False]


@pytest.mark.parametrize(
    ("text", "text_at", "column"),
    [
        ("near < 1 and nera > 2", 0, 14),
        ("near < 1 and nera > 2", 1, 15),
        ("near < 1 and nera > 2", None, 1),
        ("near < 1 s", 0, 6),
        ("near < 1 and (2 +", 0, 18),
        ("side == 'left' and state.standng", 0, 26),
    ],
)
def test_mistakes_are_told_where_they_are(text: str, text_at: int | None, column: int, names: Names) -> None:
    with pytest.raises(UserError) as raised:
        Expression.parse(text, Place("t.yaml", 3, 1), text_at).link(names)
    assert raised.value.problems[0].place == Place("t.yaml", 3, column)
