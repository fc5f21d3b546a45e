"""The report of a run."""

from __future__ import annotations

import functools
import importlib.metadata
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from enum import IntEnum
from html import escape
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from humanoid_bt.core.errors import UserError, nearest, relative
from humanoid_bt.core.texts import few, one_line, printable
from humanoid_bt.core.units import readable
from humanoid_bt.files.whole import write_whole

if TYPE_CHECKING:  # the command line reads the exit codes long before it needs the engine
    from humanoid_bt.control.supervisor import Stop
    from humanoid_bt.core.messages import Level
    from humanoid_bt.tree.ticking.executor import NodeChange

_MOST_RESULTS, _MOST_BUMPS = 6, 3  # in the summary
_PACKAGES = ("humanoid-bt", "mujoco", "mink", "py_trees", "numpy", "rerun-sdk")


class ExitCode(IntEnum):
    """Exit codes of the command line."""

    SUCCESS = 0
    FAILURE = 1
    USAGE = 2
    STOPPED = 3
    ERROR = 4
    UNFINISHED = 5
    INTERRUPTED = 130


OUTCOMES: dict[str, ExitCode] = {
    "success": ExitCode.SUCCESS,
    "failure": ExitCode.FAILURE,
    "unfinished": ExitCode.UNFINISHED,
    "stopped": ExitCode.STOPPED,
    "error": ExitCode.ERROR,
    "interrupted": ExitCode.INTERRUPTED,
}
"""Outcome of a run -> exit code."""


@dataclass(frozen=True)
class Reload:
    """What came of an edit of the tree's files during a run.

    Attributes:
        time: engine time [s].
        files: those that changed.
        outcome: reloaded, refused for its problems, or unchanged when an edit with mistakes was undone.
        problems: every mistake, as text.
    """

    time: float
    files: list[str]
    outcome: str
    problems: list[str]


@dataclass(frozen=True)
class Report:
    """What happened in a run.

    Attributes:
        tree, robot, scene, seed, parameters: what was run; the tree that ran last.
        outcome: of :data:`OUTCOMES`.
        reason: why, in words.
        sim_time: simulated time from the first tick until the run ended [s], with its tree or waiting for an edit.
        wall_time: time that took [s].
        real_time_factor: simulated over taken time.
        trace_hash: SHA-256 over all states, commands and node changes.
        timeline: every change of a node's status: time [s], path, status, feedback.
        reloads: every edit of the tree's files, if they were watched.
        results: what skills reported when they ended or were halted: time [s], path, status, name, value, unit.
        events: whatever else happened, such as the scene's script, stops, what nodes tell: time [s], level, text.
        blackboard: the tree's keys that have a value at the end, its outputs among them.
        percepts: what was seen, as it was known at the end: name -> stamp [s], age [s], position_world, distance [m],
            bearing [rad], confidence, and if they are told class and deviation [m].
        unseen: what was never seen, and why.
        fell: whether the robot fell.
        stops: every stop the supervisor ordered.
        external_force_max: largest external force or torque on any body [N, Nm].
        touches: which link of the robot touched which thing of the scene first when: time [s], thing, link, and meant,
            whether it was a hand that was sent there.
        odometry: how far the base was in the end from where it was believed to be, seen from above: off [m], and turned
            [rad]; None where nobody knows.
        timing: how punctual the servo was in realtime mode: cycles, missed, lateness [us]; None in lockstep.
        recording: path of the recording.
        recording_parts: the files it is in, in order: more than one if it became too large for one.
        left_out: how many entries the timeline, the events and the stops lack between their first and latest ones.
        staged: what a test did to the run: whether it was dry (without physics), what it did in words, and its
            conditions, replacements and script; None for a run to which nothing was done.
        recording_missing: time that the recording lacks [s], 0 if it has everything; the events say why.
        versions: of the packages that a run depends on.
        traceback: of the exception that ended the run, for its author.
        slow_ticks: ticks of the tree that took longer than their period on the wall clock: count, and the worst with
            time [s], node and duration [s]; None if there is none.
    """

    tree: str
    robot: str
    scene: str
    seed: int
    parameters: dict[str, Any]
    outcome: str
    reason: str
    sim_time: float
    wall_time: float
    trace_hash: str
    timeline: list[dict[str, Any]]
    reloads: list[Reload]
    results: list[dict[str, Any]]
    events: list[dict[str, Any]]
    blackboard: dict[str, Any]
    percepts: dict[str, dict[str, Any]]
    unseen: dict[str, str]
    fell: bool
    stops: list[dict[str, Any]]
    external_force_max: float
    odometry: dict[str, float] | None
    timing: dict[str, Any] | None
    recording: str | None
    versions: dict[str, str] = field(default_factory=dict)
    traceback: str = ""
    slow_ticks: dict[str, Any] = field(default_factory=dict)
    recording_missing: float = 0.0
    recording_parts: list[str] = field(default_factory=list)
    left_out: dict[str, int] = field(default_factory=dict)
    staged: dict[str, Any] | None = None
    touches: list[dict[str, Any]] = field(default_factory=list)

    @property
    def exit_code(self) -> ExitCode:
        """The exit code that tells this outcome."""
        return OUTCOMES[self.outcome]

    @property
    def bumps(self) -> list[str]:
        """What the robot bumped into, no hand having been sent there: ``left elbow touches table at 3.20 s``."""
        return [
            f"{touch['link'].replace('_', ' ')} touches {touch['thing']} at {touch['time']:.2f} s"
            for touch in self.touches
            if not touch["meant"]
        ]

    @property
    def real_time_factor(self) -> float:
        """Simulated over taken time."""
        return self.sim_time / self.wall_time if self.wall_time > 0 else 0.0

    @property
    def summary(self) -> list[tuple[str, str]]:
        """What matters most, for people: rows of a name and a text."""
        factor = f"{self.real_time_factor:.1f}x real time"
        rows = [("simulated", f"{self.sim_time:.2f} s in {self.wall_time:.2f} s ({factor})")]
        if self.staged is not None:
            rows += [("staged" if number == 0 else "", text) for number, text in enumerate(self.staged["told"])]
        rows += self._last_results
        stops = [f"{stop['time']:.2f} s {stop['mode'].replace('_', ' ')}: {stop['reason']}" for stop in self.stops]
        rows += [("stops" if number == 0 else "", text) for number, text in enumerate(stops or ["none"])]
        rows += [("bumped" if number == 0 else "", text) for number, text in enumerate(few(self.bumps, _MOST_BUMPS))]
        if self.odometry is not None:
            off, turned = self.odometry["off"], math.degrees(self.odometry["turned"])
            rows.append(("odometry", f"{off * 100:.1f} cm and {turned:.1f} deg off"))
        if self.reloads:
            refused = sum(reload.outcome == "refused" for reload in self.reloads)
            done = sum(reload.outcome == "reloaded" for reload in self.reloads)
            rows.append(("reloads", f"{done}" + (f", {refused} refused" if refused else "")))
        if left := [f"{count} of the {name}" for name, count in self.left_out.items() if count]:
            rows.append(("left out", f"{', '.join(left)} in the report: very many happened"))
        rows.append(("trace", self.trace_hash[:16]))
        if self.recording:
            lacks = f"  ({self.recording_missing:.1f} s are missing)" if self.recording_missing else ""
            parts = f", in {count} parts" if (count := len(self.recording_parts)) > 1 else ""
            rows.append(("recording", self.recording + parts + lacks))
        return rows

    def result(self, name: str, default: Any = ...) -> Any:
        """Return what a skill reported under this name when it ended, the last time that one did.

        Args:
            name: the result's, or the end of its node's path and that: "hand_error", "reach/hand_error".
            default: what to return if there is none; without it, that is an error.

        Raises:
            UserError: there is none, and no default was given.
        """
        for entry in reversed(self.results):
            if f"/{entry['path']}/{entry['name']}".endswith(f"/{name}"):
                return entry["value"]
        if default is ...:
            hint = nearest(name, [entry["name"] for entry in self.results]) or "no skill reported anything"
            raise UserError(f"nothing was reported as {name!r}", hint=hint)
        return default

    @property
    def _last_results(self) -> list[tuple[str, str]]:
        """Rows of what was reported in the tick with which the tree ended."""
        end = self.timeline[-1]["time"] if self.timeline else None
        last = [entry for entry in self.results if entry["time"] == end]
        rows = [
            (
                entry["name"].replace("_", " "),
                f"{readable(entry['value'], entry['unit'])}  {entry['path'].rsplit('/', 1)[-1]}",
            )
            for entry in last[:_MOST_RESULTS]
        ]
        left = len(last) - len(rows)
        return [*rows, ("", f"{left} more results in the report")] if left else rows

    @property
    def _title(self) -> str:
        dry = ", dry: without physics" if self.staged is not None and self.staged["dry"] else ""
        return f"{self.tree} on {self.robot} in {self.scene}, seed {self.seed}{dry}"

    def __repr__(self) -> str:
        return "\n".join([self._title, f"{self.outcome}: {printable(self.reason)}", *aligned(self.summary)])

    def _repr_html_(self) -> str:
        """Return a table, as notebooks show it."""
        rows = [(self.outcome, self.reason), *self.summary]
        cells = "".join(f"<tr><th>{name}</th><td>{escape(text)}</td></tr>" for name, text in rows)
        return f"<table><caption>{escape(self._title)}</caption>{cells}</table>"

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data for JSON."""
        values = asdict(self)
        values["exit_code"] = int(self.exit_code)
        values["real_time_factor"] = self.real_time_factor
        return values

    def write(self, path: str | PathLike[str]) -> None:
        """Write the report as JSON, whole or not at all.

        Raises:
            UserError: the file cannot be written.
        """
        try:
            text = json.dumps(self.to_dict(), indent=2, allow_nan=False)
            write_whole(Path(path), f"{text}\n".encode())
        except OSError as error:
            raise UserError(f"the report cannot be written to {relative(Path(path))!r}: {error.strerror}") from error


def aligned(rows: Sequence[tuple[str, str]]) -> list[str]:
    """Return the lines of a summary's rows."""
    width = max(10, *(len(name) for name, _ in rows)) + 1
    return [f"  {name:<{width}}{one_line(text)}" for name, text in rows]


def timeline_of(changes: Iterable[NodeChange]) -> list[dict[str, Any]]:
    """Return node changes as plain data."""
    return [
        {"time": round(change.time, 3), "path": change.path, "status": change.status.name, "feedback": change.feedback}
        for change in changes
    ]


def results_of(changes: Iterable[NodeChange]) -> list[dict[str, Any]]:
    """Return the results of nodes that ended or were halted as plain data."""
    return [
        {"time": round(change.time, 3), "path": change.path, "status": change.status.name, **reported._asdict()}
        for change in changes
        for reported in change.results
    ]


def events_of(events: Iterable[tuple[float, Level, str]]) -> list[dict[str, Any]]:
    """Return events as plain data."""
    return [{"time": round(time, 3), "level": level, "text": text} for time, level, text in events]


def stops_of(stops: Iterable[Stop]) -> list[dict[str, Any]]:
    """Return stops as plain data."""
    return [
        {
            "time": stop.time,
            "mode": stop.mode.value,
            "reason": stop.reason,
            "source": stop.source,
            "commanded_by": dict(stop.resources),
        }
        for stop in stops
    ]


@functools.cache
def versions() -> dict[str, str]:
    """Return the versions of the packages that a run depends on."""
    found: dict[str, str] = {}
    for package in _PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "unknown"
    return found
