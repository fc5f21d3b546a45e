"""Which node decided that a tree ended as it did: what the reason of a run is about."""

from __future__ import annotations

from collections.abc import Iterable

from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, RUNNING, SUCCESS

_DID = {SUCCESS: "succeeded", FAILURE: "failed", RUNNING: "runs"}


def deciding(changes: Iterable[NodeChange]) -> NodeChange | None:
    """Return the change of the node that decided what the root came to last, None if it was never ticked.

    From the root down that is the child which took its parent's status last: of a sequence the one that failed, of a
    selector that failed its last one. A node whose children came to something else decided itself, as a timeout and an
    inverter do; so did one that says why and whose children had come to the same before: a retry of a condition.

    Args:
        changes: of the tree's nodes, in order, children before parents. Those after the root's last status, with which
            the end of the run halts the tree, do not matter.
    """
    known = list(changes)
    while known and not (_is_root(known[-1].path) and known[-1].status is not INVALID):
        known.pop()
    if not known:
        return None
    latest: dict[str, NodeChange] = {}
    for change in known:
        latest.pop(change.path, None)
        latest[change.path] = change
    found = known[-1]
    while True:
        alike = (one for one in reversed(latest.values()) if one.status is found.status)
        below = next((one for one in alike if _parent(one.path) == found.path), None)
        if below is None or (below.time < found.time and found.feedback):
            return found
        found = below


def reason_of(changes: Iterable[NodeChange]) -> str:
    """Return why the root came to what it did last: what the node says that decided, with its name.

    Args:
        changes: as of :func:`deciding`.
    """
    decided = deciding(changes)
    if decided is None:
        return ""
    name = decided.path.rsplit("/", 1)[-1]
    return f"{name}: {decided.feedback}" if decided.feedback else f"{name} {_DID[decided.status]}"


def _parent(path: str) -> str:
    return path.rpartition("/")[0]


def _is_root(path: str) -> bool:
    """Return whether this is the path of a root: the tree's name, and its own."""
    return path.count("/") == 1
