"""What a test did to a run, out of its recording: a person must not take it for something that befell the robot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from humanoid_bt.record.reading import AT
from humanoid_bt.review.cause import Cause, Row
from humanoid_bt.review.history import History
from humanoid_bt.review.words import cut, when

PREFIX = "staged: "
"""How events begin that tell what a test does."""

_LINES = 5  # that are told
_OVER, _NEVER = "over: ", "never happened: "


def told(setup: Mapping[str, Any]) -> list[str]:
    """Return what a test did to a run, in words; nothing if it did nothing.

    Args:
        setup: what was run, as the recording has it.
    """
    lines: list[str] = setup["staged"]["told"]
    return lines


def staged_rows(history: History) -> list[Row]:
    """Return what a test did to a run."""
    never = {event.text.removeprefix(PREFIX + _NEVER) for event in history.events if _NEVER in event.text}
    lines = [f"{line}, which never happened" if line in never else line for line in told(history.setup)]
    rows = [("staged", cut(line, 200)) for line in lines[:_LINES]]
    return [*rows, ("staged", f"and {len(lines) - _LINES} more")] if len(lines) > _LINES else rows


def staged_before(history: History, cause: Cause) -> str:
    """Return the last that a test did up to a cause, as the end of its headline; "" if nothing was staged."""
    if not told(history.setup):
        return ""
    until = cause.began if cause.kind == "fall" and cause.began is not None else cause.time  # later made no robot fall
    faults = [
        event
        for event in history.events
        if event.text.startswith(PREFIX)
        and AT < event.time <= until + AT
        and not event.text.removeprefix(PREFIX).startswith((_OVER, _NEVER))
    ]
    if cause.kind == "push" and any(abs(event.time - (cause.began or 0.0)) < AT for event in faults):
        return "; a test staged it"
    if faults:
        return f"; a test staged at {when(faults[-1].time)}: {cut(faults[-1].text.removeprefix(PREFIX))}"
    if history.setup["staged"]["dry"]:
        return "; a dry run, without physics"
    told_first = [event.text for event in history.events if event.text.startswith(PREFIX) and event.time <= AT]
    if changed := "; ".join(text.removeprefix(PREFIX) for text in told_first):
        return f"; changed by a test from the beginning: {cut(changed)}"
    return "; a test ran it, and had done nothing to it by then"
