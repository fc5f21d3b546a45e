"""Scenarios that are interrupted, recorded and named twice."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.testing.scenario_check import checked_scenario
from humanoid_bt.testing.suite import MOST_RECORDED, Result, Suite
from humanoid_bt.testing.trial import Trial, Trials

TREE = "format: 1\nroot: {sequence: [{wait: 0.1 s}, {failure: {}}]}\n"
FAILS = "format: 1\ntree: ends\ndry: true\nseeds: 0-4\nduration: 1 s\nexpect: [outcome == success]\n"


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scenario that fails with each of its five seeds."""
    for place, text in {"trees/ends.yaml": TREE, "scenarios/fails.yaml": FAILS}.items():
        (tmp_path / place).parent.mkdir(parents=True)
        (tmp_path / place).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _until_interrupted(results: Iterator[Result]) -> list[Result]:
    found: list[Result] = []
    with pytest.raises(KeyboardInterrupt):
        for result in results:
            found.append(result)
    return found


def test_what_was_tried_before_an_interruption_is_told(workspace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = Trials.run

    def interrupted(self: Trials, scenario: Any, seed: int) -> Trial:
        if seed == 2:
            raise KeyboardInterrupt
        return run(self, scenario, seed)

    monkeypatch.setattr(Trials, "run", interrupted)
    (result,) = _until_interrupted(Suite().results(record=False))
    assert ([trial.seed for trial in result.trials], result.whole) == ([0, 1], False)


def test_an_interruption_while_failures_are_recorded_loses_none(
    workspace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> Trial:
        raise KeyboardInterrupt

    monkeypatch.setattr(Trials, "recorded", interrupted)
    (result,) = _until_interrupted(Suite().results())
    assert (len(result.failed), result.whole) == (5, True)


def test_only_the_first_failures_of_a_scenario_are_recorded(workspace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Trials, "recorded", lambda _self, _scenario, trial: replace(trial, recording="there"))
    (result,) = Suite().results()
    assert [bool(trial.recording) for trial in result.trials] == [True] * 3 + [False] * 2
    assert MOST_RECORDED == 3


def test_a_scenario_that_is_named_twice_is_tried_once(workspace: Path) -> None:
    assert Suite(["fails", "scenarios/fails.yaml", "scenarios"]).total == 5


def test_a_recording_of_another_course_is_marked(workspace: Path) -> None:
    scenario = checked_scenario(workspace / "scenarios/fails.yaml", Workspace(workspace))
    trials = Trials()
    trial = trials.run(scenario, 0)
    assert trials.recorded(scenario, trial).note == ""
    other = trials.recorded(scenario, replace(trial, trace="0" * 64))
    assert "went another way" in other.note
    assert other.recording
