"""What happened when, as lanes of the state timeline: what the nodes did, and mode, gait and limits of the robot."""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import Any

import rerun as rr

from humanoid_bt.core.messages import Gait, Mode, State
from humanoid_bt.record.columns import Color, send
from humanoid_bt.record.names import short_names
from humanoid_bt.tree.show.looks import STATUS_COLORS
from humanoid_bt.tree.show.outline import Outline

# The viewer names a lane by its entity, and sorts them by these names: what acts comes first, what decides last.
ACTIONS, BODY, CONDITIONS, FLOW = "actions", "body", "conditions", "flow"
GROUPS = (ACTIONS, BODY, CONDITIONS, FLOW)
"""Parents of all lanes."""

_GROUP = {"skill": ACTIONS, "action": ACTIONS, "condition": CONDITIONS}
_ACTIVE = {"RUNNING", "SUCCESS", "FAILURE"}
_BEGINS = {ACTIONS: {"RUNNING", "FAILURE"}, CONDITIONS: _ACTIVE, FLOW: _ACTIVE}
"""With what a lane begins: an action that succeeds at once, such as setting a key, is only an event."""

_HIDDEN: Color = (0, 0, 0)
_FREE, _LIMITED = "free", "limited"
_Look = Mapping[str, Color]
_BODY: Mapping[str, _Look] = {
    "mode": {
        Mode.RUN.value: STATUS_COLORS["SUCCESS"].dark,
        Mode.PROTECTIVE_STOP.value: (255, 183, 77),
        Mode.EMERGENCY_STOP.value: STATUS_COLORS["FAILURE"].dark,
        Mode.DAMP.value: (224, 156, 255),
    },
    "gait": {
        Gait.STAND.value: STATUS_COLORS["INVALID"].dark,
        Gait.STEP.value: STATUS_COLORS["RUNNING"].dark,
        Gait.SETTLE.value: (102, 204, 222),
    },
    "limits": {_FREE: _HIDDEN, _LIMITED: (255, 183, 77)},
}
_STATUS = {name: shades.dark if name != "INVALID" else _HIDDEN for name, shades in STATUS_COLORS.items()}
MODE_COLORS = _BODY["mode"]
"""Colours of the supervisor's modes, by their names."""


class _Lane:
    """One lane, which comes into being with the first of certain states."""

    def __init__(self, path: str, look: _Look, begins: Container[str]) -> None:
        self._path, self._look, self._begins = path, look, begins
        self._begun = self._written = False
        self._state = ""
        self._changes: list[tuple[float, str]] = []

    def add(self, time: float, state: str) -> None:
        """Take a state."""
        self._begun = self._begun or state in self._begins
        if self._begun and state != self._state:
            self._state = state
            self._changes.append((time, state))

    def flush(self, stream: Any) -> None:
        """Write the changes since the last flush."""
        if not self._changes:
            return
        if not self._written:
            self._written = True
            stream.log(self._path, _configuration(self._look), static=True)
        columns = rr.StateChange.columns(state=[state for _, state in self._changes])
        send(stream, self._path, [time for time, _ in self._changes], columns)
        self._changes.clear()


class Lanes:
    """Writes what nodes and robot do, when it changes; a lane that nothing happens on is not there at all."""

    def __init__(self, outline: Outline) -> None:
        self._body = {name: _Lane(f"{BODY}/{name}", look, set(look) - {_FREE}) for name, look in _BODY.items()}
        self._nodes: dict[str, _Lane] = {}  # by path of the node, of all trees so far
        self._taken: set[str] = set()
        self._take(outline)

    def _take(self, outline: Outline) -> None:
        names = short_names(outline)
        for node in outline.nodes:
            if node.path not in self._nodes:
                group = _GROUP.get(node.kind, FLOW)
                path = self._free_path(group, names[node.path])
                self._nodes[node.path] = _Lane(path, _STATUS, _BEGINS[group])
        self._here = {node.path for node in outline.nodes}

    def _free_path(self, group: str, name: str) -> str:
        words = name.replace(" (", "-in-").replace(": ", "-").removesuffix(")")
        words = "".join(c if c.isascii() and (c.isalnum() or c == "-") else "_" for c in words)
        path = wanted = f"{group}/{words}"
        number = 1
        while path in self._taken:
            number += 1
            path = f"{wanted}_{number}"
        self._taken.add(path)
        return path

    def show(self, time: float, outline: Outline) -> None:
        """Take another tree, from a time on [s]; nodes of the same path keep their lanes."""
        for path in self._here:
            self._nodes[path].add(time, "INVALID")
        self._take(outline)

    def change(self, time: float, path: str, status: str) -> None:
        """Take a node's change of status."""
        self._nodes[path].add(time, status)

    def add(self, state: State) -> None:
        """Take one state of the robot."""
        values = (state.mode.value, state.gait.value, _LIMITED if state.limit_flags else _FREE)
        for lane, value in zip(self._body.values(), values, strict=True):
            lane.add(state.time, value)

    def flush(self, stream: Any) -> None:
        """Write the changes since the last flush."""
        for lane in (*self._body.values(), *self._nodes.values()):
            lane.flush(stream)


def _configuration(look: _Look) -> Any:
    return rr.StateConfiguration(
        values=list(look),
        labels=[state.lower().replace("_", " ") for state in look],
        colors=list(look.values()),
        visible=[color != _HIDDEN for color in look.values()],
    )
