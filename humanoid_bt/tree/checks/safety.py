"""What is refused because it would not be safe."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace

from humanoid_bt.core.errors import Problem
from humanoid_bt.tree.checks.facts import Facts
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.nodes.guards import EmergencyStop, Watchdog
from humanoid_bt.tree.nodes.parallel import Parallel


@dataclass(frozen=True)
class _Above:
    """What stands above a node."""

    stoppable: bool = False
    watched: frozenset[str] = field(default_factory=frozenset)
    all_watched: bool = False  # by a watchdog whose percept is not known: that mistake is told already
    used_at: str = ""  # where the sub-tree stands that the node is in


def check_guards(root: Draft, facts: Facts) -> Iterator[Problem]:
    """Return what is used without a guard above it.

    - a node that commands a resource outside an ``emergency_stop``;
    - a percept used outside a ``watchdog`` on it (its ``on_stale`` is outside: the percept is stale there).
    """
    yield from _guards(root, facts, _Above())


def _guards(draft: Draft, facts: Facts, above: _Above) -> Iterator[Problem]:
    node_type, commands = draft.type, facts.commands(draft)
    name = node_type.type_name
    if commands and not above.stoppable:
        message = f"{name!r} commands {', '.join(commands)} outside an emergency_stop"
        yield Problem(message, draft.place, f"emergency_stop: {{...}}{above.used_at}", "outside-emergency-stop")
    reads = node_type.percepts(draft.values)
    is_watchdog = node_type.cls is Watchdog
    for parameter, percepts in reads.items() if not is_watchdog and not above.all_watched else ():
        for percept in percepts:
            if percept not in above.watched and parameter not in getattr(node_type.cls, "remembered", ()):
                place = draft.value_places.get(parameter, draft.place)
                message = f"{name!r} uses the percept {percept!r} outside a watchdog on it"
                near = difflib.get_close_matches(percept, above.watched, n=1)
                meant = f"did you mean {near[0]!r}? else " if near else ""
                hint = f"{meant}watchdog: {{percept: {percept}, max_age: 0.5 s, ...}}{above.used_at}"
                yield Problem(message, place, hint, "outside-watchdog")
    above = replace(above, stoppable=above.stoppable or node_type.cls is EmergencyStop)
    fresh = above
    if is_watchdog:
        watched = reads.get("percept", [])
        if meant := _misspelt(draft, watched, above.watched):
            message = f"this watchdog watches {watched[0]!r}, and what is below it uses {meant!r}"
            place = draft.value_places.get("percept", draft.place)
            yield Problem(message, place, f"did you mean {meant!r}?", "outside-watchdog")
            watched = [*watched, meant]
        fresh = replace(above, watched=above.watched.union(watched), all_watched=above.all_watched or not watched)
    for key, child in draft.below():
        inside = above if key else fresh
        if node_type.kind == "subtree" and child.place.file != draft.place.file:
            inside = replace(inside, used_at=f" here, or around the sub-tree at {draft.place}")
        yield from _guards(child, facts, inside)


def _misspelt(watchdog: Draft, watched: Sequence[str], above: Collection[str]) -> str:
    """Return the percept that a watchdog's misspelt one stands for: one of a like name, used below more than once."""
    used = Counter(
        percept
        for child in watchdog.children
        for draft in child.iterate()
        for percepts in draft.type.percepts(draft.values).values()
        for percept in percepts
    )
    if not watched or watched[0] in used:
        return ""
    several = [percept for percept, count in used.items() if count > 1 and percept not in above]
    near = difflib.get_close_matches(watched[0], several, n=1)
    return near[0] if near else ""


def check_overlaps(root: Draft, facts: Facts) -> Iterator[Problem]:
    """Return the children of a ``parallel`` that command the same resource."""
    for draft in root.iterate():
        if draft.type.cls is not Parallel:
            continue
        owners: dict[str, Draft] = {}
        for child in draft.children:
            shared: dict[int, list[str]] = {}
            for resource in sorted(facts.commanded(child)):
                owner = owners.setdefault(resource, child)
                if owner is not child:
                    shared.setdefault(id(owner), []).append(resource)
            for owner in draft.children:
                if id(owner) in shared:
                    what = " and ".join(shared[id(owner)])
                    message = f"{draft.called(owner)} and {draft.called(child)} run at once and both command {what}"
                    hint = f"the first is at {owner.place}"
                    for resource in shared[id(owner)]:
                        off = facts.switch_off(child, resource) or facts.switch_off(owner, resource)
                        hint += f"; {off} leaves {resource} alone" if off else ""
                    yield Problem(message, child.place, hint, "resource-overlap")
