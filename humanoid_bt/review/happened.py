"""What happened in a run, out of a recording, as rows of tables."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import Any

from humanoid_bt.record.reading import FlightLog, News
from humanoid_bt.review import setup

Row = dict[str, Any]


class Happened:
    """Everything that was told during a run.

    Args:
        log: the recording.
    """

    def __init__(self, log: FlightLog) -> None:
        self._log = log

    def known(self, path: str, time: float) -> setup.NodeInfo:
        """Return what a node was in the tree that ran at a time [s]."""
        return setup.ran_at(self._nodes, time).get(path, setup.NodeInfo(path))

    @cached_property
    def _nodes(self) -> list[tuple[float, dict[str, setup.NodeInfo]]]:
        """Since when each tree ran, with its nodes by path."""
        trees = [(-math.inf, self._log.setup["tree"]), *((news.time, news.value) for news in self._of("tree"))]
        return [(since, setup.nodes(tree)) for since, tree in trees]

    @cached_property
    def end(self) -> Row:
        """How the run ended, empty if nobody knows."""
        return next((news.value for news in self._of("end")), {})

    @cached_property
    def nodes(self) -> list[Row]:
        """Every change of a node's status."""
        return [self._node(news.time, *news.value) for news in self._of("node")]

    @cached_property
    def results(self) -> list[Row]:
        """Everything that skills reported."""
        return [_result(news.time, news.value[0], *result) for news in self._of("results") for result in news.value[1]]

    @cached_property
    def events(self) -> list[Row]:
        """Whatever else happened."""
        found = ((news.time, *news.value) for news in self._of("event"))
        return [{"time": time, "level": level, "text": text} for time, level, text in found]

    @cached_property
    def blackboard(self) -> list[Row]:
        """Every change of a key."""
        return [_key(news.time, *news.value) for news in self._of("key")]

    @cached_property
    def stops(self) -> list[Row]:
        """Every stop."""
        return [{key: news.value[key] for key in ("time", "mode", "reason", "source")} for news in self._of("stop")]

    @cached_property
    def inputs(self) -> list[Row]:
        """What came from outside."""
        found = (news.value for news in self._of("input"))
        return [{"time": time, "kind": kind, "value": json.dumps(value)} for time, kind, value in found]

    @cached_property
    def first(self) -> float:
        """The engine time [s] of the tree's first tick; in realtime mode control has run for a while by then."""
        return next((news.time for news in self._of("node")), 0.0)

    @cached_property
    def last(self) -> float:
        """The engine time [s] of the last that was told."""
        return max((news.time for news in self._log.news), default=0.0)

    def spans(self, until: float) -> list[Row]:
        """Return when nodes ran, in the order in which they began; a skill also when it ended in its first tick.

        Args:
            until: engine time [s] of the tree's end, for those that still ran then.
        """
        found, running = list[Row](), dict[str, Row]()
        for change in self.nodes:
            path, status = change["node"], change["status"]
            if status == "RUNNING":
                if path not in running:
                    running[path] = {**change, "ended": until}
                    found.append(running[path])
            elif path in running:
                span = running.pop(path)
                span |= {"ended": change["time"], "status": status, "text": change["text"]}
            elif change["kind"] == "skill" and (status != "INVALID" or change["text"]):  # not if it is only reset
                found.append({**change, "ended": change["time"]})
        for span in found:
            span["duration"] = max(span["ended"] - span["time"], 0.0)
        return found

    def _node(self, time: float, path: str, status: str, said: str) -> Row:
        known = self.known(path, time)
        name = path.rsplit("/", 1)[-1]
        return {
            "time": time,
            "node": path,
            "name": name,
            "type": known.type,
            "kind": known.kind,
            "status": status,
            "text": said,
        }

    def _of(self, kind: str) -> Iterator[News]:
        return (news for news in self._log.news if news.kind == kind)


class Running:
    """Follows which nodes run, as time goes on.

    Args:
        changes: of nodes, in the order of time.
    """

    def __init__(self, changes: Iterable[Row]) -> None:
        self._changes = iter(changes)
        self._next = next(self._changes, None)
        self._paths: dict[str, None] = {}
        self._text = ""

    def at(self, time: float) -> str:
        """Return the paths of the deepest running nodes at an engine time [s], none before the last one asked for."""
        changed = False
        while self._next is not None and self._next["time"] <= time + 1e-9:
            changed = True
            if self._next["status"] == "RUNNING":
                self._paths[self._next["node"]] = None
            else:
                self._paths.pop(self._next["node"], None)
            self._next = next(self._changes, None)
        if changed:
            above = {path[:end] for path in self._paths for end in range(len(path)) if path[end] == "/"}
            self._text = " | ".join(path for path in self._paths if path not in above)
        return self._text


def _result(time: float, path: str, name: str, value: Any, unit: str) -> Row:
    number = value if isinstance(value, (int, float)) and not isinstance(value, bool) else None
    return {
        "time": time,
        "node": path,
        "result": name,
        "value": None if number is None else float(number),
        "text": None if number is not None else value if isinstance(value, str) else json.dumps(value),
        "unit": unit,
    }


def _key(time: float, key: str, *value: Any) -> Row:
    return {"time": time, "key": key, "value": json.dumps(value[0]) if value else None}
