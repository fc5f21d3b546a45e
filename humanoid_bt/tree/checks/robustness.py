"""What makes a robot flap between two behaviours, or wait for ever."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from py_trees.common import Status

from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.decision.skill import Skill
from humanoid_bt.tree.checks.facts import Facts, waits_for_ever
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.expressions.grammar import Comparison
from humanoid_bt.tree.expressions.linking import Watched
from humanoid_bt.tree.nodes.parallel import Parallel, number_of

_WIDTHS = {"m": "5 cm", "rad": "5 deg", "s": "100 ms", "m/s": "5 cm/s", "rad/s": "5 deg/s", "": "0.1"}
"""Unit -> a hysteresis as an example."""


def check_hysteresis(root: Draft, facts: Facts) -> Iterator[Problem]:
    """Return the thresholds on percepts without hysteresis that are checked again and again while something runs.

    A condition that is asked once (a child of a ``sequence``, while another child runs) needs none, nor does
    ``wait_until``, which is over when it holds.
    """
    yield from _flapping(root, facts, False)


def _flapping(draft: Draft, facts: Facts, again: bool) -> Iterator[Problem]:
    """Return what flaps; ``again`` is whether what stands above checks the node again while something else runs."""
    values = draft.type.complete(draft.values)
    if draft.type.kind == "condition":
        if again:
            yield from _unsteady_values(draft, values)
            yield from _unsteady_expressions(draft, values)
        return
    runs = [facts.may_run(child) for _, child in draft.below()]
    once = getattr(draft.type.cls, "one_way", False)
    if any(runs) and not once and draft.type.kind in ("composite", "decorator"):
        yield from _unsteady_expressions(draft, values)
    for index, (key, child) in enumerate(draft.below()):
        below = again
        if key and (slot := draft.type.branches.get(key)) and slot.condition:
            below = _below(again, once, any(runs[:index] + runs[index + 1 :]))
        elif draft.type.cls is Parallel:
            below = _below(again, True, any(runs[:index] + runs[index + 1 :]))
        elif draft.type.takes == "many" and not key:
            below = _below(again, once, any(runs[index + 1 :]))
        yield from _flapping(child, facts, below)


def _below(again: bool, once: bool, others_run: bool) -> bool:
    """Return whether a child is checked again while something runs.

    Args:
        again: whether its parent is.
        once: whether the parent checks it once, and then lets others run.
        others_run: whether there are others.
    """
    return not once if others_run else again


def _unsteady_values(draft: Draft, values: dict[str, Any]) -> Iterator[Problem]:
    for name, value in values.items():
        measured = name.removesuffix("hysteresis").removesuffix("_")  # "bearing_hysteresis" is that of "bearing"
        if name == measured or value != 0 or (measured and values.get(measured) is None):
            continue
        default = draft.type.params[name].default
        message = f"{draft.type.type_name!r} has no hysteresis: it may flap while its percept jitters"
        hint = f"{name}: {default:g} {draft.type.params[name].unit}".rstrip()
        yield _no_hysteresis(message, draft.value_places.get(name, draft.place), hint)


def _unsteady_expressions(draft: Draft, values: dict[str, Any]) -> Iterator[Problem]:
    for name, value in values.items():
        for comparison in value.comparisons if isinstance(value, Expression) else ():
            if not comparison.steady:
                message = f"in {value.text!r}: {comparison.source!r} may flap: it is compared without hysteresis"
                place = draft.value_places.get(name, value.place)
                yield _no_hysteresis(message, place, _with_hysteresis(value, comparison))


def _with_hysteresis(expression: Expression, comparison: Watched) -> str:
    whole = isinstance(expression.syntax, Comparison) and expression.syntax.hysteresis is None
    written = expression.text.strip() if whole else f"{comparison.source} {comparison.operator} ..."
    return f"{written} hysteresis {_WIDTHS.get(comparison.type.unit, '...')}"


def _no_hysteresis(message: str, place: Place, hint: str) -> Problem:
    return Problem(message, place, hint, "no-hysteresis", "warning")


def check_time_limits(root: Draft, facts: Facts) -> Iterator[Problem]:
    """Return the leaves that may run for ever, although the tree waits for their end, with no time limit above them.

    A limit is a ``timeout``, or a ``parallel`` that ends when others of its children do. A watchdog is none: a fresh
    percept never ends it. What is made to run until it is halted needs no limit.
    """
    yield from _unlimited(root, facts)


def _unlimited(draft: Draft, facts: Facts) -> Iterator[Problem]:
    cls, name = draft.type.cls, draft.type.type_name
    if getattr(cls, "limits_time", False):
        return
    if draft.type.kind in ("action", "skill") and waits_for_ever(draft, facts):
        hint = f"timeout: {{duration: 60 s, {name}: ...}}"
        if issubclass(cls, Skill) and not _says_bounded(cls):
            hint += "; or, in its class, bounded = True if it ends by itself, ends = False if it never does"
        message = f"{name!r} may run for ever, and no timeout stands above it"
        yield Problem(message, draft.place, hint, "no-time-limit", "warning")
    for _, child in draft.below():
        if draft.type.cls is not Parallel or not _ends_without(draft, child, facts):
            yield from _unlimited(child, facts)


def _ends_without(parallel: Draft, child: Draft, facts: Facts) -> bool:
    """Return whether a parallel ends in bounded time whatever one of its children does."""
    others = [other for other in parallel.children if other is not child and facts.bounded(other)]
    values, count = parallel.type.complete(parallel.values), len(parallel.children)
    for what, excluded in (("success", Status.FAILURE), ("failure", Status.SUCCESS)):
        enough = number_of(values[what], count)
        if sum(excluded not in facts.results(other) for other in others) >= enough:
            return True
    return False


def _says_bounded(cls: type[Skill]) -> bool:
    return any("bounded" in vars(base) for base in cls.__mro__ if base is not Skill)
