"""How a run ends, and what is reported of it."""

from __future__ import annotations

import traceback
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, NamedTuple

from humanoid_bt.core.errors import HumanoidBtError, Place
from humanoid_bt.core.messages import Mode
from humanoid_bt.core.plain import plain
from humanoid_bt.core.texts import one_line, shortened, told
from humanoid_bt.files.class_files import class_file, place_in_file
from humanoid_bt.perception.track import Track
from humanoid_bt.record.parts import parts_of
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.options import RunOptions
from humanoid_bt.session.report import Report, events_of, results_of, stops_of, timeline_of, versions
from humanoid_bt.session.trace import Trace
from humanoid_bt.tree.ticking.executor import NodeError
from humanoid_bt.tree.tree import Tree

_LONGEST_TRACEBACK = 20_000  # characters


class End(NamedTuple):
    """How a run ended.

    Attributes:
        outcome: of :data:`~humanoid_bt.session.report.OUTCOMES`.
        reason: why, in words.
        failure: what went wrong in a few words, as the reason of a stop; "" if nothing did.
        traceback: of the exception that ended the run.
        node: path of the node that raised it, "" if none did.
        error: that exception in one line.
        line: the line of the skill's file that raised it, "" if it came from elsewhere.
    """

    outcome: str
    reason: str
    failure: str = ""
    traceback: str = ""
    node: str = ""
    error: str = ""
    line: str = ""


def failed(error: HumanoidBtError) -> End:
    """Return the end of a run whose tree raised an error."""
    if not isinstance(error, NodeError):
        return End("error", str(error), "two nodes command one resource")
    trace = "".join(traceback.format_exception(error.error))
    raised = {"node": error.path, "error": one_line(told(error.error)), "line": str(error.where or "")}
    return End("error", str(error), "a node raised an exception", trace, **raised)


def internal(error: Exception) -> End:
    """Return the end of a run in which something raised an exception that is no skill's."""
    reason = f"internal error: {type(error).__name__}: {error}"
    return End("error", reason, "internal error", "".join(traceback.format_exception(error)))


def where(error: BaseException, tree: Tree) -> str:
    """Return in which line of a tree's skill an exception came, as " in FILE:LINE:COLUMN"; "" if in none."""
    for node in tree.nodes:
        file = class_file(node.type.cls) if node.kind == "skill" else None
        place: Place | None = place_in_file(error, file) if file else None
        if place is not None:
            return f" in {place}, in the node {node.path!r}"
    return ""


def report_of(
    end: End,
    tree: Tree,
    engine: Engine,
    *,
    trace: Trace,
    tracks: Mapping[str, Track],
    options: RunOptions,
    sim_time: float,
    wall_time: float,
    slow_ticks: dict[str, Any],
    recording_missing: float,
    odometry: dict[str, float] | None,
) -> Report:
    """Return the report of a run that is over.

    Args:
        end: how it ended.
        tree: the tree that ran last.
        engine: what it ran on, closed.
        trace: what was collected.
        tracks: what was seen up to the end.
        options: what was asked for.
        sim_time: simulated time from the first tick until the run ended [s], with its tree or waiting for an edit.
        wall_time: time that took [s].
        slow_ticks: ticks that took longer than their period.
        recording_missing: time that the recording lacks [s].
        odometry: how far the base is from where it is believed to be.
    """
    file = options.sinks.file
    return Report(
        tree=tree.name,
        robot=engine.robot.config.name,
        scene=engine.scene.config.name,
        seed=options.seed,
        parameters=plain(tree.parameters),
        outcome=end.outcome,
        reason=shortened(end.reason),
        sim_time=round(sim_time, 3),
        wall_time=wall_time,
        trace_hash=trace.digest,
        timeline=timeline_of(trace.timeline),
        reloads=trace.reloads,
        results=results_of(trace.timeline),
        events=events_of(trace.events),
        blackboard={key.name: plain(key.value) for key in tree.keys if key.is_set},
        percepts={name: _seen(track) for name, track in tracks.items()},
        unseen=dict(engine.unseen),
        fell=any(stop.mode is Mode.DAMP for stop in engine.supervisor.stops),
        stops=stops_of(engine.supervisor.stops),
        external_force_max=engine.external_force_max,
        touches=[asdict(touch) for touch in engine.touches],
        odometry=odometry,
        timing=asdict(engine.timing) if engine.timing else None,
        recording=str(file) if file else None,
        versions=versions(),
        traceback=shortened(end.traceback, _LONGEST_TRACEBACK),
        slow_ticks=slow_ticks,
        recording_missing=round(recording_missing, 3),
        left_out={
            "timeline": trace.timeline.left_out,
            "events": trace.events.left_out,
            "stops": engine.supervisor.stops.left_out,
        },
        recording_parts=[str(part) for part in parts_of(file)] if file else [],
        staged=options.staged,
    )


def _seen(track: Track) -> dict[str, Any]:
    names = ("stamp", "age", "position_world", "distance", "bearing", "confidence")
    told = {"class": track.class_name or None, "deviation": track.deviation}
    return {name: plain(getattr(track, name)) for name in names} | {
        name: plain(value) for name, value in told.items() if value is not None
    }
