"""What a run leaves for its report: the timeline, events, results, and a hash of everything that happened."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

from humanoid_bt.core.kept import Kept
from humanoid_bt.core.messages import Command, Level, State
from humanoid_bt.link.wire.targets import pack_targets
from humanoid_bt.session.report import Reload
from humanoid_bt.tree.ticking.deciding import reason_of
from humanoid_bt.tree.ticking.executor import NodeChange


class Trace:
    """Collects states, commands, node changes and events of one run, in the order in which they happen.

    Attributes:
        timeline: changes of nodes' statuses, with the results of those that ended; of very many the first and latest.
        events: whatever else happened: time [s], level, text; as of the timeline.
        reloads: every edit of the tree's files.
    """

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        self._sources: tuple[Mapping[str, str], str] = ({}, "[]")  # of the last command's targets, and as text
        self.timeline: Kept[NodeChange] = Kept()
        self.events: Kept[tuple[float, Level, str]] = Kept()
        self.reloads: list[Reload] = []

    @property
    def digest(self) -> str:
        """SHA-256 over all that was collected, as hexadecimal text."""
        return self._hash.hexdigest()

    def node_changed(self, change: NodeChange) -> None:
        """Take a node's change of status."""
        self.timeline.append(change)
        self._hash.update(f"{change.time} {change.path} {change.status.name}".encode())

    def reloaded(self, reload: Reload, source: str) -> None:
        """Take what came of an edit, and the text of the tree that runs from now on, "" if it is the same."""
        self.reloads.append(reload)
        self._hash.update(f"{reload.time} {reload.outcome} {source}".encode())

    def why(self) -> str:
        """Return why the tree came to what it did last."""
        return reason_of(self.timeline)

    def tick(self, state: State, command: Command) -> None:
        """Take what one tick saw and commanded."""
        if command.sources != self._sources[0]:
            self._sources = command.sources, str(sorted(command.sources.items()))
        what = f"{state.cycle} {state.mode.value} {self._sources[1]}".encode()
        seen = (state.joint_positions, state.joint_velocities, state.setpoint_positions, state.base_position)
        self._hash.update(b"".join([*[values.tobytes() for values in seen], pack_targets(command.targets), what]))
