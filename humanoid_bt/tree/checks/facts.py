"""What the checks know of each node of a tree: what it can answer, and what it commands."""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Mapping
from dataclasses import replace

from py_trees.common import Status

from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.results import AT_ONCE, NEVER_ENDS, NOTHING, Below, Results


class Facts:
    """Facts on every node of a tree.

    Args:
        root: the tree's root.

    Attributes:
        problems: skills that could not tell what they command.
    """

    def __init__(self, root: Draft) -> None:
        self.problems: list[Problem] = []
        self._results: dict[int, Results] = {}
        self._at_once: dict[int, Results] = {}
        self._commands: dict[int, tuple[str, ...]] = {}
        self._commanded: dict[int, frozenset[str]] = {}
        self._bounded: dict[int, bool] = {}
        self._learn(root)

    def results(self, draft: Draft) -> Results:
        """Return what a node can answer; anything where a mistake leaves that open."""
        return self._results[id(draft)]

    def at_once(self, draft: Draft) -> Results:
        """Return what a node can answer without starting anything that runs; success and failure if it has mistakes."""
        return self._at_once[id(draft)]

    def may_run(self, draft: Draft) -> bool:
        """Return whether a node can be RUNNING."""
        return Status.RUNNING in self._results[id(draft)]

    def commands(self, draft: Draft) -> tuple[str, ...]:
        """Return the resources that a node itself may command."""
        return self._commands[id(draft)]

    def commanded(self, draft: Draft) -> frozenset[str]:
        """Return the resources that a node and those below it may command."""
        return self._commanded[id(draft)]

    def switch_off(self, draft: Draft, resource: str) -> str:
        """Return how a node, or one below it, would leave a resource alone: "look: false in 'reach'"; "" if none does.

        Asked are parameters that are true or false.
        """
        for leaf in draft.iterate():
            if resource in self._commands[id(leaf)] and leaf.sound:
                values = leaf.type.complete(leaf.values)
                for name, spec in leaf.type.params.items():
                    other = not values.get(name)
                    with contextlib.suppress(UserError):
                        if spec.type is bool and resource not in leaf.type.commands({**values, name: other}):
                            return f"{name}: {str(other).lower()} in {leaf.name!r}"
        return ""

    def bounded(self, draft: Draft) -> bool:
        """Return whether a node ends by itself in bounded time, as far as its skills promise."""
        return self._bounded[id(draft)]

    def _learn(self, draft: Draft) -> None:
        below = [child for _, child in draft.below()]
        for child in below:
            self._learn(child)
        key = id(draft)
        self._results[key] = self._results_of(draft)
        self._at_once[key] = self._at_once_of(draft)
        self._commands[key] = self._commands_of(draft)
        self._commanded[key] = frozenset(self._commands[key]).union(*(self._commanded[id(child)] for child in below))
        self._bounded[key] = self._bounded_of(draft, below)

    def _results_of(self, draft: Draft) -> Results:
        values = draft.values if draft.sound else None
        return draft.type.possible_results(values, _below(draft, self._results))

    def _at_once_of(self, draft: Draft) -> Results:
        cls, results = draft.type.cls, self._results[id(draft)]
        if Status.RUNNING not in results or not draft.sound:
            return results & AT_ONCE
        below = _below(draft, self._at_once)
        declared = getattr(cls, "results_at_once", None)
        if declared is None and (below.children or below.branches):
            declared = getattr(cls, "possible_results", None)
        if not inspect.ismethod(declared):
            return NOTHING
        found: Results = declared(draft.type.complete(draft.values), below)
        return found & results & AT_ONCE

    def _commands_of(self, draft: Draft) -> tuple[str, ...]:
        if not draft.sound:
            return draft.type.resources
        try:
            return draft.type.commands(draft.values)
        except UserError as error:
            self.problems += [replace(problem, place=draft.place) for problem in error.problems]
            return draft.type.resources

    def _bounded_of(self, draft: Draft, below: list[Draft]) -> bool:
        cls, results = draft.type.cls, self._results[id(draft)]
        if Status.RUNNING not in results or getattr(cls, "limits_time", False):
            return True
        if results == NEVER_ENDS:
            return False
        if below:
            for_ever = -1 in (draft.type.complete(draft.values).get(count) for count in ("attempts", "times"))
            return not for_ever and getattr(cls, "bounded", True) and all(self._bounded[id(child)] for child in below)
        return not waits_for_ever(draft, self)


def _below(draft: Draft, results: Mapping[int, Results]) -> Below:
    """Return what comes from below a node, if these are the results of the drafts there, by their ids."""
    branches = {key: results[id(child)] for key, child in draft.below() if key}
    return Below(tuple(results[id(child)] for child in draft.children), branches)


def waits_for_ever(leaf: Draft, facts: Facts) -> bool:
    """Return whether a leaf that can end may also run for ever.

    So may an action that says so, and a skill that commands the robot and does not say that it is bounded.
    """
    results, silent = facts.results(leaf), leaf.type.kind == "skill" and not facts.commands(leaf)
    may = Status.RUNNING in results and results != NEVER_ENDS
    return may and not silent and not getattr(leaf.type.cls, "bounded", True)
