"""What happened when, as lanes of the state timeline: what the nodes did, and mode, gait and limits of the robot."""

from __future__ import annotations

import functools
import math
from collections.abc import Container, Mapping
from typing import Any

import rerun as rr

from humanoid_bt.core.messages import Gait, Mode, State
from humanoid_bt.record.columns import Color, send
from humanoid_bt.record.names import short_names
from humanoid_bt.tree.show.looks import STATUS_COLORS
from humanoid_bt.tree.show.outline import Outline

# The viewer names a lane by its entity, and sorts them by these names, numbers as numbers: what acts comes first, what
# decides last; and what began first, or stands above in the tree, is above.
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
        Mode.PAUSED.value: (129, 162, 255),
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
    """One lane, which comes into being with the first of certain states.

    Args:
        name: what it is called among those of its group.
        look: of its states.
        begins: the states with which it comes into being.

    Attributes:
        path: its entity; "" until it has one.
    """

    def __init__(self, name: str, look: _Look, begins: Container[str], path: str = "") -> None:
        self.name, self.path = name, path
        self._look, self._begins = look, begins
        self._written = False
        self._state = ""
        self._changes: list[tuple[float, str]] = []

    @property
    def began(self) -> float:
        """When it came into being, inf as long as it did not; until its changes are written."""
        return self._changes[0][0] if self._changes else math.inf

    def add(self, time: float, state: str) -> None:
        """Take a state."""
        if state != self._state and (self._state or state in self._begins):
            self._state = state
            self._changes.append((time, state))

    def flush(self, stream: Any) -> None:
        """Write the changes since the last flush."""
        if not self._changes:
            return
        if not self._written:
            self._written = True
            stream.log(self.path, _configuration(tuple(self._look.items())), static=True)
        columns = rr.StateChange.columns(state=[state for _, state in self._changes])
        send(stream, self.path, [time for time, _ in self._changes], columns, lasting=True)
        self._changes.clear()


class Lanes:
    """Writes what nodes and robot do, when it changes; a lane that nothing happens on is not there at all."""

    def __init__(self, outline: Outline) -> None:
        self._body = [_Lane(name, look, set(look) - {_FREE}, path=f"{BODY}/{name}") for name, look in _BODY.items()]
        self._groups: dict[str, list[_Lane]] = {group: [] for group in (ACTIONS, CONDITIONS, FLOW)}
        self._nodes: dict[str, _Lane] = {}  # by path of the node, of all trees so far
        self._take(outline)

    def _take(self, outline: Outline) -> None:
        names = short_names(outline)
        for index in outline.in_order():
            node = outline.nodes[index]
            if node.path not in self._nodes:
                group = _GROUP.get(node.kind, FLOW)
                lane = self._nodes[node.path] = _Lane(_in_entity(names[node.path]), _STATUS, _BEGINS[group])
                self._groups[group].append(lane)
        self._here = {node.path for node in outline.nodes}

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
        for lane, value in zip(self._body, values, strict=True):
            lane.add(state.time, value)

    def flush(self, stream: Any) -> None:
        """Write the changes since the last flush."""
        for group, lanes in self._groups.items():
            there = sum(bool(lane.path) for lane in lanes)
            new = (lane for lane in lanes if not lane.path and lane.began < math.inf)
            for number, lane in enumerate(sorted(new, key=lambda lane: lane.began), there + 1):
                lane.path = f"{group}/{number}-{lane.name}"
        for lane in (*self._body, *self._nodes.values()):
            lane.flush(stream)


def _in_entity(name: str) -> str:
    """Return a node's short name with what needs no escape in the name of an entity."""
    words = name.replace(" (", "-in-").replace(": ", "-").removesuffix(")")
    return "".join(c if c.isascii() and (c.isalnum() or c == "-") else "_" for c in words)


@functools.cache
def _configuration(look: tuple[tuple[str, Color], ...]) -> Any:
    states, colors = zip(*look, strict=True)
    return rr.StateConfiguration(
        values=states,
        labels=[state.lower().replace("_", " ") for state in states],
        colors=colors,
        visible=[color != _HIDDEN for color in colors],
    )
