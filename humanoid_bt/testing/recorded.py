"""What a node did in a recording, for a stand-in to do it again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from humanoid_bt.core.errors import UserError, nearest
from humanoid_bt.decision.result import Reported
from humanoid_bt.record.reading import read_flight
from humanoid_bt.review.happened import Happened, Row
from humanoid_bt.review.history import HALTED


def recorded(file: Path, path: str) -> list[dict[str, Any]]:
    """Return what a node did in a recording each time it was started, as the values of an answer.

    Raises:
        UserError: it is no recording, or the node never ran in it, or only raised an exception.
    """
    log = read_flight(file)
    happened = Happened(log)
    changes = [change for change in happened.nodes if change["node"] == path]
    if not changes:
        ran = {change["node"] for change in happened.nodes}
        raise UserError(f"{path!r} does not run in the recording {str(file)!r}", hint=nearest(path, ran))
    reported: dict[float, list[Reported]] = {}
    for told in log.news_of("results"):
        node, results = told.value
        if node == path:
            reported.setdefault(told.time, []).extend(Reported(*result) for result in results)
    answers = list(_answers(changes, reported))
    if not answers:
        raise UserError(f"{path!r} did nothing in the recording {str(file)!r} but raise an exception")
    return answers


def _answers(changes: Iterable[Row], reported: Mapping[float, Sequence[Reported]]) -> Iterator[dict[str, Any]]:
    began: float | None = None
    for change in changes:
        time, status = change["time"], change["status"]
        if status == "RUNNING":
            began = time
        elif status in ("SUCCESS", "FAILURE"):
            after = 0.0 if began is None else time - began
            results = reported.get(time, [])
            said = change["text"].removesuffix("; ".join(map(str, results))).removesuffix("; ")  # both are told as one
            answered = {result.name: result.value for result in results}
            yield {"status": status.lower(), "after": after, "feedback": said, "results": answered}
            began = None
        elif began is not None or change["text"].startswith(HALTED):
            yield {"status": "running", "feedback": "halted here when it was recorded"}
            began = None
    if began is not None:
        yield {"status": "running", "feedback": "ran on when it was recorded"}
