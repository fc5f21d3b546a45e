"""What a running robot looks like from outside: read from the run's channels, without any of its processes' help."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from humanoid_bt.link.run_folder import RunFolder, RunInfo, in_lockstep
from humanoid_bt.link.segment import LinkError
from humanoid_bt.link.wire import WireError, decode_state
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.timing import Timing

_SILENCE = 1.0  # s without a word of decision that are told
_TICKS = 30  # ticks without one, for runs at a slow pace
_ROLES = {"owner": "decision"}  # who made the run's folder is who ticks the tree


@dataclass(frozen=True)
class RunStatus:
    """A running robot.

    Attributes:
        run_id, tree, robot, scene: of the run.
        file: of the tree, "" for none.
        recording: where it is recorded to, "" for nowhere.
        uptime: since its start, by the wall clock [s].
        time: engine time of the latest state [s]; None before the first.
        mode: what the supervisor allows, or ``starting``.
        stop_reason, stop_source: why the mode is not ``run``, else "".
        estop: who raised the e-stop and why, None if it is clear.
        node, feedback: the deepest running node and what it says.
        tick_rate: ticks of the tree per second [Hz]; None before the first, and while there is none.
        silent: how long decision has told nothing, by the wall clock [s]; None while it ticks.
        timing: how punctual the servo loop is; None in lockstep.
        leases: resource -> path of the node that commands it.
        percepts: name -> age [s].
        unseen: name -> why it was never seen.
        processes: role -> id and whether it lives.
    """

    run_id: str
    tree: str
    robot: str
    scene: str
    file: str
    recording: str
    uptime: float
    time: float | None
    mode: str
    stop_reason: str
    stop_source: str
    estop: Mapping[str, str] | None
    node: str
    feedback: str
    tick_rate: float | None
    silent: float | None
    timing: Mapping[str, Any] | None
    leases: Mapping[str, str]
    percepts: Mapping[str, float]
    unseen: Mapping[str, str]
    processes: Mapping[str, Mapping[str, Any]]

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data for JSON."""
        return asdict(self)


def status_of(folder: RunFolder, info: RunInfo) -> RunStatus:
    """Return how a run is doing; what it has not told yet is empty."""
    raw = _latest(folder, "state")
    try:
        state = decode_state(raw) if raw else None
    except WireError:
        state = None
    told = _json(_latest(folder, "status"))
    since_told = state.time - told.get("time", state.time) if state else 0.0  # decision may tell nothing any more
    silent = _silent(told)
    rate = round(told["tick_rate"], 1) if "tick_rate" in told and silent is None else None
    return RunStatus(
        run_id=info.run_id,
        tree=info.tree,
        robot=info.robot,
        scene=info.scene,
        file=info.file,
        recording=info.recording,
        uptime=round(time.time() - info.started, 1),
        time=round(state.time, 3) if state else None,
        mode=state.mode.value if state else "starting",
        stop_reason=state.stop_reason if state else "",
        stop_source=state.stop_source if state else "",
        estop=_estop(folder),
        node=told.get("node", ""),
        feedback=told.get("feedback", ""),
        tick_rate=rate,
        silent=silent,
        timing=None if in_lockstep(folder) else _json(_latest(folder, "timing")) or asdict(Timing()),
        leases=dict(state.command_sources) if state else {},
        percepts={name: round(age + since_told, 3) for name, age in told.get("percepts", {}).items()},
        unseen=told.get("unseen", {}),
        processes={
            _ROLES.get(role, role): {"pid": pid, "alive": role in info.living}
            for role, pid in sorted(info.processes.items())
        },
    )


def _silent(told: Mapping[str, Any]) -> float | None:
    """Return for how long decision has told nothing [s], None if no longer than it takes: it tells every few ticks."""
    if "told_at" not in told:
        return None
    silent = time.monotonic() - float(told["told_at"])
    return round(silent, 1) if silent > max(_SILENCE, _TICKS / max(float(told["tick_rate"]), 1e-3)) else None


def _estop(folder: RunFolder) -> dict[str, str] | None:
    try:
        estop = channels.estop(folder)
    except LinkError:
        return None
    try:
        while estop.poll():
            pass
        return {"source": estop.raised.source, "reason": estop.raised.reason} if estop.raised else None
    finally:
        estop.close()


def _latest(folder: RunFolder, name: str) -> bytes:
    try:
        ring = channels.reader(folder, name)
    except LinkError:
        return b""  # it is just starting, or just over
    try:
        latest = ring.latest()
        return latest[1] if latest else b""
    finally:
        ring.close()


def _json(data: bytes) -> dict[str, Any]:
    try:
        found = json.loads(data) if data else {}
    except ValueError:  # a text too long for its slot was cut
        return {}
    return found if isinstance(found, dict) else {}
