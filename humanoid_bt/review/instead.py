"""What ran because a percept was lost or doubtful: a selector turned from a node that failed for want of it."""

from __future__ import annotations

from humanoid_bt.review.history import Change, History

_SELECTORS = ("selector", "reactive_selector")
_FAILED = "FAILURE"


def failed_for_a_percept(history: History) -> Change | None:
    """Return the failure for want of a percept because of which something else ran to the end, None if there is none.

    Args:
        history: of a run that ended without a result.
    """
    failures = [change for path, change in history.at_last.items() if _turned_from(history, path)]
    found = {str(history.kind(change.path).get("type", "")): change for change in failures}
    watchdog, confident = found.get("watchdog"), found.get("confident")
    if watchdog is not None and not watchdog.said and confident is None:
        return _gone_later(history, watchdog)
    return watchdog if watchdog is not None and watchdog.said else confident


def _gone_later(history: History, watchdog: Change) -> Change | None:
    """Return the failure of a watchdog that had failed with its child before its percept was lost, if it was."""
    below = [change for path, change in history.at_last.items() if path.startswith(watchdog.path + "/")]
    halted = max((change.time for change in below if change.status == "INVALID"), default=watchdog.time)
    if halted <= watchdog.time:
        return None
    name = history.value(history.kind(watchdog.path)["values"].get("percept"))
    return watchdog._replace(time=halted, said=f"{name!r} was too old")


def _turned_from(history: History, path: str) -> bool:
    """Return whether a node failed, and with all above it up to a selector that went on with something else."""
    last, nodes = history.at_last, list(history.nodes().values())
    while (change := last.get(path)) is not None and change.status == _FAILED:
        number = history.kind(path).get("parent", -1)
        if number < 0:
            return False
        above = nodes[number]
        now = last.get(path := above["path"])
        if above["type"] in _SELECTORS and now is not None and now.status == "RUNNING":
            return True
    return False
