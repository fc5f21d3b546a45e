"""What happened in a run, out of a recording, as rows of tables; what makes no sense is left out and counted."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from typing import Any

from humanoid_bt.record.reading import FlightLog, News
from humanoid_bt.review import setup

Row = dict[str, Any]

_LONGEST = 1e9  # s: a time beyond is none
_ODD = (TypeError, ValueError, KeyError, IndexError, AttributeError, OverflowError, RecursionError)


class Happened:
    """Everything that was told during a run.

    Args:
        log: the recording.

    Attributes:
        odd: how many entries could not be understood so far.
    """

    def __init__(self, log: FlightLog) -> None:
        self._log = log
        self.odd = 0

    @cached_property
    def known(self) -> dict[str, setup.NodeInfo]:
        """Every node of every tree that ran, by path."""
        trees = [setup.part(self._log.setup, "tree"), *(setup.part(news.value) for news in self._of("tree"))]
        return {path: node for tree in trees for path, node in setup.nodes(tree).items()}

    @cached_property
    def end(self) -> Row:
        """How the run ended, empty if nobody knows."""
        return next((setup.part(news.value) for news in self._of("end")), {})

    @cached_property
    def nodes(self) -> list[Row]:
        """Every change of a node's status."""
        return self._rows("node", self._node)

    @cached_property
    def results(self) -> list[Row]:
        """Everything that skills reported."""
        found = self._rows("results", lambda time, value: list(_results(time, *value)))
        return [row for rows in found for row in rows]

    @cached_property
    def events(self) -> list[Row]:
        """Whatever else happened."""
        return self._rows(
            "event", lambda time, value: {"time": time, "level": _text(value[0]), "text": _text(value[1])}
        )

    @cached_property
    def blackboard(self) -> list[Row]:
        """Every change of a key."""
        return self._rows(
            "key",
            lambda time, value: {
                "time": time,
                "key": _text(value[0]),
                "value": json.dumps(value[1]) if len(value) > 1 else None,
            },
        )

    @cached_property
    def stops(self) -> list[Row]:
        """Every stop."""
        return self._rows(
            "stop",
            lambda _, stop: {
                "time": _time(stop["time"]),
                **{key: _text(stop[key]) for key in ("mode", "reason", "source")},
            },
        )

    @cached_property
    def inputs(self) -> list[Row]:
        """What came from outside."""
        return self._rows(
            "input",
            lambda _, value: {"time": _time(value[0]), "kind": _text(value[1]), "value": json.dumps(value[2])},
        )

    @cached_property
    def last(self) -> float:
        """The engine time [s] of the last that was told."""
        return max((news.time for news in self._log.news if 0.0 <= news.time < _LONGEST), default=0.0)

    def spans(self, until: float) -> list[Row]:
        """Return when nodes ran, in the order in which they began.

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
        for span in found:
            span["duration"] = max(span["ended"] - span["time"], 0.0)
        return found

    def _node(self, time: float, value: Any) -> Row:
        path, status, said = map(_text, value)
        known = self.known.get(path, setup.NodeInfo(path))
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

    def _rows(self, kind: str, row: Callable[[float, Any], Any]) -> list[Any]:
        rows = []
        for news in self._of(kind):
            try:
                rows.append(row(_time(news.time), news.value))
            except _ODD:
                self.odd += 1
        return rows


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


def _results(time: float, path: Any, results: Any) -> Iterator[Row]:
    for name, value, unit in results:
        number = value if isinstance(value, (int, float)) and not isinstance(value, bool) else None
        yield {
            "time": time,
            "node": _text(path),
            "result": _text(name),
            "value": None if number is None else float(number),
            "text": None if number is not None else value if isinstance(value, str) else json.dumps(value),
            "unit": _text(unit),
        }


def _time(value: Any) -> float:
    """Return an engine time [s].

    Raises:
        ValueError: it is none.
    """
    time = float(value)
    if not (math.isfinite(time) and 0.0 <= time < _LONGEST):
        raise ValueError(f"{value} is no time")
    return time


def _text(value: Any) -> str:
    """Return a text.

    Raises:
        TypeError: it is none.
    """
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is no text")
    return value
