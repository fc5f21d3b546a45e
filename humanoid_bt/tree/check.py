"""Safety checks of a tree before it runs."""

from __future__ import annotations

from collections.abc import Iterator

from humanoid_bt.errors import Problem
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.guards import EmergencyStop, Watchdog
from humanoid_bt.tree.parallel import Parallel


def check_safety(root: Draft, alone: bool = False) -> list[Problem]:
    """Return what is unsafe in a tree.

    Args:
        root: the tree's root.
        alone: whether it is a sub-tree that is looked at alone: what stands above it is then not known.

    - a node that commands a resource outside an ``emergency_stop``;
    - a percept used outside a ``watchdog`` on it (its ``on_stale`` is outside: the percept is stale there);
    - children of a ``parallel`` that command the same resource.
    """
    return [problem for problem in _check(root, False, frozenset()) if not alone or problem.code == "resource-overlap"]


def _check(draft: Draft, stoppable: bool, watched: frozenset[str]) -> Iterator[Problem]:
    node_type = draft.type
    name = node_type.type_name
    if node_type.resources and not stoppable:
        resources = ", ".join(node_type.resources)
        message = f"{name!r} commands {resources} outside an emergency_stop"
        yield Problem(message, draft.place, "emergency_stop: {...}", code="outside-emergency-stop")
    reads = node_type.percepts(draft.values)
    if node_type.cls is not Watchdog:
        for parameter, percepts in reads.items():
            for percept in percepts:
                if percept not in watched:
                    place = draft.value_places.get(parameter, draft.place)
                    hint = f"watchdog: {{percept: {percept}, max_age: 0.5, ...}}"
                    message = f"{name!r} uses the percept {percept!r} outside a watchdog on it"
                    yield Problem(message, place, hint, code="outside-watchdog")
    if node_type.cls is Parallel:
        yield from _overlaps(draft)
    stoppable = stoppable or node_type.cls is EmergencyStop
    for key, child in draft.below():
        fresh = node_type.cls is Watchdog and not key
        yield from _check(child, stoppable, watched | set(reads.get("percept", ())) if fresh else watched)


def _overlaps(parallel: Draft) -> Iterator[Problem]:
    owners: dict[str, Draft] = {}
    for child in parallel.children:
        for resource in sorted(_resources(child)):
            if resource in owners:
                message = f"{owners[resource].name!r} and {child.name!r} run at once and both command {resource}"
                hint = f"the first is at {owners[resource].place}"
                yield Problem(message, child.place, hint, code="resource-overlap")
            else:
                owners[resource] = child


def _resources(draft: Draft) -> set[str]:
    return set(draft.type.resources).union(*(_resources(child) for _, child in draft.below()))
