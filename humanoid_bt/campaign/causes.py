"""Failures grouped by cause: the same outcome at the same node for the same reason, but for the numbers in it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from humanoid_bt.campaign.result import CRASHED, HUNG, Explained
from humanoid_bt.campaign.table import Row, Table

_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
ANY_NUMBER = "…"
"""What stands for the numbers in a reason that others of its cause may have other ones of."""


@dataclass(frozen=True)
class Cause:
    """Trials that failed for the same reason.

    Attributes:
        outcome: of all of them.
        node: path of the node that the reason is about, "" if it is about none.
        reason: why, with :data:`ANY_NUMBER` for its numbers where they differ.
        rows: the trials, in their order.
        explained: what recordings show, by the trial's number.
    """

    outcome: str
    node: str
    reason: str
    rows: tuple[Row, ...]
    explained: Mapping[int, Explained]

    @property
    def headlines(self) -> list[str]:
        """What the recordings show, a sentence each, none twice."""
        return list(dict.fromkeys(found.headline for found in self.explained.values()))

    @property
    def kinds(self) -> list[str]:
        """What sorts of cause the recordings show, none twice."""
        return list(dict.fromkeys(found.kind for found in self.explained.values()))

    @property
    def can_be_recorded(self) -> bool:
        """Whether a trial of it can be run again to record it: one that hangs or kills its process would again."""
        return self.outcome not in (HUNG, CRASHED)


def causes(table: Table, explained: Mapping[int, Explained] | None = None) -> list[Cause]:
    """Return why trials failed, the most frequent cause first.

    Args:
        table: what came of trials.
        explained: what recordings show, by the trial's number.
    """
    groups: dict[tuple[str, str, str], list[Row]] = {}
    for row in table.rows:
        result = row.result
        if not result.succeeded:
            groups.setdefault((result.outcome, result.node, pattern(result.reason)), []).append(row)
    found = [
        Cause(outcome, node, common([row.result.reason for row in rows]), tuple(rows), _of(rows, explained or {}))
        for (outcome, node, _), rows in groups.items()
    ]
    return sorted(found, key=lambda cause: (-len(cause.rows), cause.rows[0].trial.number))


def pattern(reason: str) -> str:
    """Return what is the same in a reason and in others of its cause: all of it but the numbers."""
    return _NUMBER.sub(ANY_NUMBER, reason)


def common(reasons: Sequence[str]) -> str:
    """Return the reason that reasons of one pattern have in common, word for word if it is the same."""
    return reasons[0] if len(set(reasons)) == 1 else pattern(reasons[0])


def _of(rows: Sequence[Row], explained: Mapping[int, Explained]) -> dict[int, Explained]:
    return {row.trial.number: explained[row.trial.number] for row in rows if row.trial.number in explained}
