"""How two recorded runs differ: in what was run, and in what happened."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import UserError
from humanoid_bt.review import setup
from humanoid_bt.review.compare_run import NodeShift, Parting, first_parting, node_shifts, result_changes
from humanoid_bt.review.compare_setup import Change, setup_changes
from humanoid_bt.review.happened import Row
from humanoid_bt.review.recording import Recording

_GAP = 5 * DECISION_PERIOD  # s without a tick that are damage


@dataclass(frozen=True)
class Difference:
    """How two recorded runs differ.

    Attributes:
        changes: settings, parameters, files, nodes of the tree, versions, machine; results and outcome.
        parting: the first moment in which they are not the same, None if there is none.
        nodes: the first change of each node that is not the same, in the order of time.
    """

    changes: list[Change] = field(default_factory=list)
    parting: Parting | None = None
    nodes: list[NodeShift] = field(default_factory=list)

    @property
    def is_none(self) -> bool:
        """Whether the runs are the same."""
        return not (self.changes or self.nodes or self.parting)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data for JSON."""
        return {
            "same": self.is_none,
            "changes": [asdict(change) for change in self.changes],
            "parting": None if self.parting is None else self.parting._asdict(),
            "nodes": [shift._asdict() for shift in self.nodes],
        }


def difference(one: Recording, other: Recording, tolerance: float = 0.0, within: float | None = None) -> Difference:
    """Return how two runs differ.

    In realtime mode no two runs see and command the same in each tick: ticks are not compared there, and times of nodes
    count from the first tick.

    Args:
        one, other: their recordings.
        tolerance: numbers of states, percepts, commands and results that differ by no more are the same.
        within: times of nodes that differ by no more [s] are the same; None for a tick in realtime mode, else 0.

    Raises:
        UserError: a tolerance is negative.
    """
    realtime = any(map(_is_realtime, (one, other)))
    if within is None:
        within = DECISION_PERIOD if realtime else 0.0
    if not (tolerance >= 0 and within >= 0):
        raise UserError(f"a tolerance must be a number, 0 or more, not {min(tolerance, within)}")
    joints = [row["joint"] for row in setup.joints(one.setup)]
    changes = list(setup_changes(one.setup, other.setup))
    until = min(_whole_until(one), _whole_until(other))
    changes += result_changes(_up_to(until, one.happened.results), _up_to(until, other.happened.results), tolerance)
    nodes = [_from_first_tick(run, _up_to(until, run.happened.nodes)) for run in (one, other)]
    shifts = node_shifts(nodes[0], nodes[1], within)
    ticks = [iter(()) if realtime else run.every_tick() for run in (one, other)]
    for name, before, after in (("outcome", one.outcome, other.outcome), ("reason", one.reason, other.reason)):
        if before != after:
            changes.append(Change("outcome", name, before or None, after or None))
    return Difference(changes, first_parting(ticks[0], ticks[1], shifts, joints, tolerance, until < math.inf), shifts)


def _is_realtime(recording: Recording) -> bool:
    return bool(recording.setup["mode"] == "realtime")


def _from_first_tick(recording: Recording, rows: list[Row]) -> list[Row]:
    """Return what happened with times from the first tick on: in realtime mode control has run for a while by then."""
    if not _is_realtime(recording):
        return rows
    began = next((tick.state.time for tick in recording.every_tick()), 0.0)
    return [{**row, "time": row["time"] - began} for row in rows]


def _up_to(until: float, rows: list[Row]) -> list[Row]:
    return [row for row in rows if row["time"] <= until]


def _whole_until(recording: Recording) -> float:
    """Return the engine time from which on something is missing that was damaged or cut off [s], infinity for none.

    What happened is kept with the ticks of its time: where these are missing, it is too.
    """
    if recording.outcome and not recording.damage:
        return math.inf
    last = None
    for tick in recording.every_tick():
        if last is not None and tick.state.time - last > _GAP:
            return last
        last = tick.state.time
    return math.inf if last is None or recording.outcome else last
