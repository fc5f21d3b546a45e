"""What a run says of itself, as the gateway reads it from the run's channels."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from humanoid_bt.core.messages import State
from humanoid_bt.gateway.clock import EngineClock
from humanoid_bt.gateway.file import Frames
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.link.wire import SeenPicture, WireError, decode_picture, decode_state
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.live_tree import Moment, TreeWatch


@dataclass(frozen=True)
class Snapshot:
    """A run at one time.

    Attributes:
        state: what control knows.
        stamp: ROS time of the state [s].
        joints: names of the robot's joints.
        frames: what frames are called.
        tree: what the tree does, None before it tells.
        told: what decision tells besides, as ``humanoid-bt status`` prints it.
        timing: how punctual control is.
        picture: the last one of the head camera, None if there is none.
        picture_stamp: ROS time of it [s].
    """

    state: State
    stamp: float
    joints: Sequence[str]
    frames: Frames
    tree: Moment | None
    told: Mapping[str, Any]
    timing: Mapping[str, Any]
    picture: SeenPicture | None = None
    picture_stamp: float = 0.0


class RunView:
    """Reads the channels of a run.

    Args:
        folder: of the run.
        joints: names of the robot's joints.
        frames: what frames are called.
        clock: for stamps.
    """

    def __init__(self, folder: RunFolder, joints: Sequence[str], frames: Frames, clock: EngineClock) -> None:
        self._joints, self._frames, self._clock = joints, frames, clock
        self._rings = {name: channels.reader(folder, name) for name in ("state", "status", "timing")}
        self._tree = TreeWatch(folder)
        self._told = channels.reader(folder, "gateway_told")
        self._read = self._told.sequence  # what was told before a gateway came is over
        self._pictures = channels.reader(folder, "picture") if channels.has_pictures(folder) else None
        self._looked = 0
        self._picture: SeenPicture | None = None

    def state(self) -> State | None:
        """Return the latest state, None before the first."""
        latest = self._rings["state"].latest()
        with suppress(WireError):
            return decode_state(latest[1]) if latest else None
        return None

    def picture(self) -> SeenPicture | None:
        """Return the latest picture of the head camera, None if there is none since the last time."""
        latest = self._pictures.latest() if self._pictures is not None else None
        if latest is None or latest[0] == self._looked:
            return None
        self._looked, payload = latest
        with suppress(WireError):
            self._picture = decode_picture(payload)
            return self._picture
        return None

    def told(self) -> list[dict[str, Any]]:
        """Return what has happened since the last time: of nodes and events, each with its kind."""
        entries, _ = self._told.since(self._read)
        if entries:
            self._read = entries[-1][0]
        return [json.loads(payload) for _, payload in entries]

    def snapshot(self, state: State) -> Snapshot:
        """Return all that is known."""
        stamp = self._clock.ros(state.time)
        told, timing = self._json("status"), self._json("timing")
        seen = self._picture
        taken = 0.0 if seen is None else self._clock.ros(seen.time)
        return Snapshot(state, stamp, self._joints, self._frames, self._tree.latest(), told, timing, seen, taken)

    def _json(self, name: str) -> dict[str, Any]:
        latest = self._rings[name].latest()
        with suppress(ValueError):  # a text too long for its slot was cut
            found = json.loads(latest[1]) if latest else {}
            return found if isinstance(found, dict) else {}
        return {}
