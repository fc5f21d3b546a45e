"""What starts again where a tree asks again in every tick, so that it and what follows take turns for ever."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.common import Status

from humanoid_bt.core.errors import Problem
from humanoid_bt.decision.skill import Skill
from humanoid_bt.tree.checks.facts import Facts
from humanoid_bt.tree.draft import Draft

_ENDED = {Status.SUCCESS: "succeeded", Status.FAILURE: "failed"}


def check_restarts(root: Draft, facts: Facts) -> Iterator[Problem]:
    """Return what runs, ends, and starts again while what got its turn by that end runs.

    - children of a reactive sequence or selector before others that run;
    - conditions of a ``reactive_if`` or a ``guard`` that are nodes which run.

    What can give the same answer at once, without starting anything that runs, is left alone: a ``selector`` of a
    condition and what makes it hold is made to be asked again.
    """
    for draft in root.iterate():
        if _goes_on(draft):
            yield from _children(draft, facts)
            yield from _condition(draft, facts)


def _children(draft: Draft, facts: Facts) -> Iterator[Problem]:
    passed: Status | None = getattr(draft.type.cls, "passed", None)
    if passed is None:
        return
    for index, child in enumerate(draft.children):
        if passed not in facts.results(child):
            return  # what is behind it never gets its turn, which is told already
        halted = next((later for later in draft.children[index + 1 :] if facts.may_run(later)), None)
        if halted is not None and _starts_again(child, passed, facts):
            name = draft.called(child)
            effect = f"{name} starts again when it has {_ENDED[passed]}, and halts {draft.called(halted)} behind it"
            repair = f"put {name} and what is behind it into a {_goes_on(draft)!r}" if index else _instead(draft)
            yield _problem(child, name, effect, repair, facts)


def _condition(draft: Draft, facts: Facts) -> Iterator[Problem]:
    needs: dict[str, Status] = getattr(draft.type.cls, "needs", {})
    below = dict(draft.below())
    condition = below.get("condition")
    for key, needed in needs.items() if condition else ():
        assert condition is not None
        if key in below and facts.may_run(below[key]) and _starts_again(condition, needed, facts):
            effect = f"{condition.name!r} starts again when it has {_ENDED[needed]}, and halts {below[key].name!r}"
            yield _problem(condition, repr(condition.name), effect, _instead(draft), facts)
            return


def _starts_again(node: Draft, status: Status, facts: Facts) -> bool:
    """Return whether a node can end with a status, and only by running: what never runs answers at once."""
    return status in facts.results(node) and status not in facts.at_once(node)


def _goes_on(draft: Draft) -> str:
    """Return the type that goes on with what runs, of a node that asks again; "" of any other."""
    found: str = getattr(draft.type.cls, "goes_on", "")
    return found


def _instead(draft: Draft) -> str:
    return f"use {_goes_on(draft)!r} instead of {draft.type.type_name!r}"


def _problem(node: Draft, name: str, message: str, repair: str, facts: Facts) -> Problem:
    hint = f"{repair}: it goes on with what runs; or put {name} below 'once' if it is to run only once"
    if issubclass(node.type.cls, Skill) and not facts.commands(node):
        hint += "; or, in its class, runs = False if it always answers at once"
    return Problem(message, node.place, hint, "starts-again", "warning")
