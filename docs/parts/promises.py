"""What the engine promises, from the numbers by which ``bench`` judges."""

from __future__ import annotations

from humanoid_bt.bench.body_rows import ROWS
from humanoid_bt.bench.gait import PROMISES_OF, ROW_OF
from humanoid_bt.bench.promises import PROMISES
from parts.markdown import table


def costs() -> str:
    """Return the table of what the engine may cost."""
    return _table("bench")


def reactions() -> str:
    """Return the table of how punctual and how quick realtime mode is."""
    return _table("bench --realtime")


def speeds() -> str:
    """Return the table of how fast a learned walker is to be simulated."""
    return _table("bench --speed")


def body_rows() -> str:
    """Return the table of what a robot's body is tried with."""
    ends = {True: "reaches the goal", False: "stays on its feet"}
    rows = [(f"`{row.name}`", row.what, ends[row.walks], f"at least {row.promise.bound:g} %") for row in ROWS]
    return table(("row", "the robot", "withstood if it", "promised"), rows)


def gait_figures() -> str:
    """Return the table of the figures that tell how briskly a robot walks."""
    words = {True: "at least", False: "at most"}
    rows = [
        (f"`{name}`", f"`{row}`", promise.what, f"{words[promise.at_least]} {promise.bound:g} {promise.unit}")
        for name, row in ROW_OF.items()
        for promise in [PROMISES_OF[name]]
    ]
    return table(("figure", "of the row", "what", "promised"), rows)


def _table(command: str) -> str:
    words = {True: "at least", False: "at most"}
    rows = [
        (promise.what, f"{words[promise.at_least]} {promise.bound:g}{'' if promise.unit == 'x' else ' '}{promise.unit}")
        for promise in PROMISES
        if promise.command == command
    ]
    return table(("what", "promised"), rows)
