"""What a run leaves for its report: the timeline, a hash of everything that happened, where the hand ended."""

from __future__ import annotations

import hashlib

import numpy as np
from py_trees.common import Status

from humanoid_bt.core.messages import SIDES, Command, HandTarget, Side, State
from humanoid_bt.plant.scene import Scene
from humanoid_bt.session.report import Reload
from humanoid_bt.tree.ticking.executor import NodeChange


class Trace:
    """Collects states, commands and node changes of one run, in the order in which they happen.

    Args:
        scene: where hands go for objects.

    Attributes:
        timeline: every change of a node's status.
        reloads: every edit of the tree's files.
        hand_error: distance of the hand that was commanded last to the object it went for [m], once measured.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._hash = hashlib.sha256()
        self._last_hand: tuple[Side, str] | None = None
        self.timeline: list[NodeChange] = []
        self.reloads: list[Reload] = []
        self.hand_error: float | None = None

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

    def why(self, status: Status, now: float) -> str:
        """Return what the first node says that took a status in the tick at ``now`` [s]: it decided for the others."""
        for change in self.timeline:
            if change.time >= now and change.status is status and change.feedback:
                return f"{change.path.rsplit('/', 1)[-1]}: {change.feedback}"
        return ""

    def tick(self, state: State, command: Command) -> None:
        """Take what one tick saw and commanded."""
        for values in (state.joint_positions, state.joint_velocities, state.setpoint_positions, state.base_position):
            self._hash.update(values.tobytes())
        self._hash.update(f"{state.cycle} {state.mode.value} {sorted(command.sources.items())}".encode())
        self._follow_hand(command)

    def measure_hand(self, state: State) -> None:
        """Measure how far the hand is from what it went for."""
        if self._last_hand is not None:
            side, thing = self._last_hand
            offset = state.hands[side] - self._scene.object_position(thing, state.time)
            self.hand_error = float(np.linalg.norm(offset))

    def _follow_hand(self, command: Command) -> None:
        """Remember which hand goes for which object: the one nearest to the hand's target."""
        for side in SIDES:
            target = command.targets.get(f"{side}_hand")
            if isinstance(target, HandTarget) and self._scene.config.objects:
                aim = target.position
                distances = {
                    name: float(np.linalg.norm(self._scene.object_position(name, command.stamp) - aim))
                    for name in self._scene.config.objects
                }
                self._last_hand = (side, min(distances, key=distances.__getitem__))
