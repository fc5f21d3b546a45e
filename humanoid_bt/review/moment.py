"""``explain --at``: what was going on at a moment of a run."""

from __future__ import annotations

import math
from collections.abc import Iterator

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.review.before import before, chosen
from humanoid_bt.review.cause import Row
from humanoid_bt.review.explanation import Explanation
from humanoid_bt.review.history import History
from humanoid_bt.review.scene import (
    body_row,
    command_in_force,
    hand_row,
    joint_loads,
    joint_text,
    node_rows,
    sight_rows,
)
from humanoid_bt.review.words import cut, doing, when

_MOST = 12  # moments
_AROUND = 1.0  # s before and after a moment that are told


def moment_explained(history: History, time: float) -> Explanation:
    """Return what was going on at a time [s].

    Raises:
        UserError: the recording has nothing of that time.
    """
    begin, until = history.begin, history.until
    if not (isinstance(time, (int, float)) and math.isfinite(time) and begin - 1e-3 <= time <= until + 1e-3):
        raise UserError(f"the recording has nothing of {time} s", hint=f"valid: {begin:.3f} to {when(until)}")
    acting = history.acting(time)
    tick, modes = history.tick(time), history.modes(time - 0.05, time + 0.001)
    mode = modes[-1].mode if modes else tick.state.mode.value if tick else ""
    who = f"{doing(acting)} ran" if acting else "no node ran"
    if (silent := history.silent_since(time)) is not None:
        who = f"decision's last tick was at {when(silent)}, in which {who}"
    why = f" ({tick.state.stop_reason})" if tick and tick.state.stop_reason else ""
    return Explanation(
        recording=relative(history.log.path),
        kind="moment",
        headline=f"at {when(time)}: {who}, mode {mode.replace('_', ' ') or 'unknown'}{why}",
        time=time,
        node=acting[-1].path if acting else "",
        place=history.place(acting[-1].path, time) if acting else "",
        rows=list(_rows(history, time)),
        title="around it",
        moments=chosen(before(history, time - _AROUND, min(time + _AROUND, until)), _MOST),
        data={
            "mode": mode,
            "gait": tick.state.gait.value if tick else "",
            "running": list(history.running(time)),
            "command": tick.state.command_sequence if tick else -1,
            "commanded_by": dict(tick.state.command_sources) if tick else {},
            "percepts": [seen._asdict() for seen in history.sights(time)],
            "joints": joint_loads(history, time),
        },
    )


def _rows(history: History, time: float) -> Iterator[Row]:
    yield from node_rows(history, time)
    if told := command_in_force(history, time):
        yield "command", cut(told, 300)
    if hands := hand_row(history, time):
        yield hands
    yield from sight_rows(history, time, " ".join(change.said for change in history.acting(time)))
    for number, joint in enumerate(joint_loads(history, time)[:3]):
        yield "joints" if number == 0 else "", joint_text(joint)
    yield body_row(history, time)
    if (tick := history.tick(time)) and tick.took > 0:
        yield "tick", f"of {when(tick.state.time)}; the tree took {tick.took * 1000:.1f} ms"
