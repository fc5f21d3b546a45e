"""Nodes that never get their turn, and nodes that can change nothing."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.common import Status

from humanoid_bt.core.errors import Problem
from humanoid_bt.tree.checks.facts import Facts
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.nodes.decorators import Repeat, Retry, Timeout
from humanoid_bt.tree.nodes.parallel import Parallel, number_of
from humanoid_bt.tree.results import Results

SUCCESS, FAILURE, RUNNING = Status.SUCCESS, Status.FAILURE, Status.RUNNING


def check_reachability(root: Draft, facts: Facts) -> Iterator[Problem]:
    """Return what never gets its turn, and what can change nothing.

    - children of a sequence or selector behind one that never lets them have their turn;
    - branches that a condition never chooses;
    - ``retry``, ``repeat`` and ``timeout`` around a child that never gives them anything to do;
    - a ``parallel`` of which some children can succeed, but fewer than it needs.
    """
    for draft in root.iterate():
        yield from _siblings(draft, facts)
        yield from _branches(draft, facts)
        if draft.sound:
            yield from _decorators(draft, facts)
            yield from _parallels(draft, facts)


def _siblings(draft: Draft, facts: Facts) -> Iterator[Problem]:
    passed: Status | None = getattr(draft.type.cls, "passed", None)
    if passed is None:
        return
    for index, child in enumerate(draft.children[:-1]):
        results = facts.results(child)
        if passed not in results:
            first, *others = draft.children[index + 1 :]
            behind = f", nor {len(others)} more behind it" if others else ""
            message = f"{first.name!r} is never ticked{behind}: {child.name!r} before it {_always(results, passed)}"
            yield Problem(message, first.place, f"{child.name!r} is at {child.place}", "unreachable", "warning")
            return


def _branches(draft: Draft, facts: Facts) -> Iterator[Problem]:
    needs: dict[str, Status] = getattr(draft.type.cls, "needs", {})
    below = dict(draft.below())
    condition = below.get("condition")
    for key, needed in needs.items() if condition else ():
        assert condition is not None
        results = facts.results(condition)
        if key in below and needed not in results:
            what = f"{key!r} of {draft.name!r}" if key else f"{below[key].name!r}"
            message = f"{what} is never ticked: its condition {_always(results, needed)}"
            hint = f"the condition is at {condition.place}"
            yield Problem(message, below[key].place, hint, "unreachable", "warning")


def _decorators(draft: Draft, facts: Facts) -> Iterator[Problem]:
    useful: dict[type, tuple[Status, str]] = {
        Retry: (FAILURE, "nothing is ever tried again"),
        Repeat: (SUCCESS, "nothing is ever repeated"),
        Timeout: (RUNNING, "no time passes in it"),
    }
    status, effect = useful.get(draft.type.cls, (None, ""))
    if status is None or status in facts.results(draft.children[0]):
        return
    child = draft.children[0]
    how = "answers at once" if status is RUNNING else _always(facts.results(child), status)
    message = f"{draft.name!r} has no effect: {child.name!r} {how}, so {effect}"
    yield Problem(message, draft.place, f"put {child.name!r} here without it", "no-effect", "warning")


def _parallels(draft: Draft, facts: Facts) -> Iterator[Problem]:
    if draft.type.cls is not Parallel:
        return
    count = len(draft.children)
    needed = number_of(draft.type.complete(draft.values)["success"], count)
    can = [child.name for child in draft.children if SUCCESS in facts.results(child)]
    if 0 < len(can) < needed <= count:
        message = f"{draft.name!r} never succeeds: it needs {needed} children that do, and only {len(can)} can"
        hint = f"success: {len(can)}; those that can: {', '.join(map(repr, can))}"
        place = draft.value_places.get("success", draft.place)
        yield Problem(message, place, hint, "never-succeeds", "warning")


def _always(results: Results, missing: Status) -> str:
    """Return in words what a node without a result does."""
    if results == {RUNNING}:
        return "never ends"
    if RUNNING not in results:
        return "always succeeds" if missing is FAILURE else "always fails"
    return "never fails" if missing is FAILURE else "never succeeds"
