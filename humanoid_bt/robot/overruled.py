"""Patterns that count for no joint: of several that match one, the first that is written counts."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence

from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.core.patterns import matching


def overruled(
    patterns: Iterable[tuple[str, Hashable, Place | None]], joints: Sequence[str], source: str = ""
) -> Iterator[Problem]:
    """Yield the patterns all of whose joints have their entry from an earlier one, as what is wrong.

    Args:
        patterns: each with the entry that it is for, and where it is written; in their order.
        joints: that they can match.
        source: what else to say of where they are.
    """
    entries: dict[str, Hashable] = {}
    for pattern, entry, place in patterns:
        given = [entries.setdefault(joint, entry) for joint in matching(joints, pattern)]
        if given and entry not in given:
            message = f"{pattern!r} counts for no joint: earlier ones match all that it matches{source}"
            hint = "the first that matches a joint counts: write it further up"
            yield Problem(message, place, hint, code="misplaced-key")
