"""What becomes of a run whose listener, or recorder, raises."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.record.reading import read_flight
from humanoid_bt.session.session import Session
from tests.review.direct import DirectRecorder, recorded_directly
from tests.session.helpers import Told


def broken(told: Told, method: str, after: int) -> list[str]:
    """Let a listener raise whenever it is told something from a number of times on; return what it raised."""
    calls, raised = 0, list[str]()

    def fail(*_what: Any) -> None:
        nonlocal calls
        calls += 1
        if calls > after:
            raised.append(f"after {after}")
            raise ZeroDivisionError(raised[-1])

    setattr(told, method, fail)
    return raised


@pytest.mark.parametrize(("method", "after"), [("node_changed", 1), ("event", 0), ("progress", 3)])
def test_a_listener_that_raises_ends_the_run_and_is_told_no_more(
    project: Path, tmp_path: Path, method: str, after: int
) -> None:
    told, file = Told(), tmp_path / "run.rrd"
    raised = broken(told, method, after)
    with recorded_directly():
        session = Session("walk", workspace=project, duration=0.2, record=file, camera=False, listener=told)
        report = session.run()
    assert len(raised) == 1
    assert (report.outcome, report.reason) == ("error", f"internal error: ZeroDivisionError: {raised[0]}")
    assert "in fail" in report.traceback
    assert session.engine.sense()[0].base_settled
    (end,) = (news.value for news in read_flight(file).news if news.kind == "end")
    assert (end["outcome"], end["reason"]) == (report.outcome, report.reason)


def test_a_recorder_that_raises_does_not_keep_the_robot_from_a_stand(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def broken_sample(*_what: Any) -> None:
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr(DirectRecorder, "sample", broken_sample)
    with recorded_directly():
        session = Session("walk", workspace=project, duration=0.2, record=tmp_path / "run.rrd", camera=False)
        report = session.run()
    assert (report.outcome, report.reason) == ("error", "internal error: ZeroDivisionError: a bug")
    assert session.engine.sense()[0].base_settled
    assert not caplog.records


def test_the_recording_has_the_end_of_a_run_that_an_error_of_our_own_ended(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "run.rrd"
    with recorded_directly():
        session = Session("walk", workspace=project, record=file, camera=False)
        sense = session.engine.sense

        def broken_once() -> Any:
            monkeypatch.setattr(session.engine, "sense", sense)
            raise ZeroDivisionError("a bug")

        monkeypatch.setattr(session.engine, "sense", broken_once)
        report = session.run()
    assert report.outcome == "error"
    assert [news.value["reason"] for news in read_flight(file).news if news.kind == "end"] == [report.reason]
