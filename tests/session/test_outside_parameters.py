"""Parameters of the tree as others see and set them, asked for between two ticks of a run in lockstep."""

from __future__ import annotations

import json
import time
from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

import humanoid_bt as hbt
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.outcome import End

TREE = """
format: 1
parameters:
  patience: {default: 60 s, doc: How long.}
  level: 2
  pace: 0.5
root:
  sequence:
    - condition: level > 1
    - timeout: {duration: $patience, wait_until: state.time > 1000 s}
    - subtree: {tree: slow, pace: $pace}
"""
SLOW = "format: 1\nsubtree: true\nparameters: {pace: 1}\nroot: {condition: pace > 0}\n"


class Counter:
    """Where others look and ask."""

    def __init__(self) -> None:
        self.asked: deque[dict[str, Any]] = deque()
        self.shown: list[dict[str, dict[str, Any]]] = []
        self.answers: list[tuple[int, str]] = []

    def ask(self, name: str, value: Any, ago: float = 0.0) -> None:
        at = time.monotonic() - ago
        number = len(self.answers) + len(self.asked)
        self.asked.append({"number": number, "name": name, "value": value, "source": "ROS 2", "at": at})


@pytest.fixture
def counter(monkeypatch: pytest.MonkeyPatch) -> Counter:
    counter = Counter()

    def show(_engine: Lockstep, shown: Sequence[Mapping[str, Any]]) -> None:
        counter.shown.append({one["name"]: dict(one) for one in shown})

    def answer(_engine: Lockstep, kind: str, values: Mapping[str, Any]) -> None:
        if kind == "setting":
            counter.answers.append((values["number"], values["why"]))

    def take(_engine: Lockstep) -> list[dict[str, Any]]:
        return [counter.asked.popleft() for _ in range(len(counter.asked))]

    monkeypatch.setattr(Lockstep, "shows_parameters", True)
    monkeypatch.setattr(Lockstep, "show_parameters", show)
    monkeypatch.setattr(Lockstep, "take_settings", take)
    monkeypatch.setattr(Lockstep, "announce", answer)
    return counter


@pytest.fixture
def session(tmp_path: Path) -> hbt.Session:
    (tmp_path / "trees").mkdir()
    (tmp_path / "trees/slow.yaml").write_text(SLOW)
    (tmp_path / "trees/patient.yaml").write_text(TREE)
    return hbt.Session("patient", workspace=tmp_path)


def test_they_are_shown_with_what_nodes_take_and_why_some_are_fixed(counter: Counter, session: hbt.Session) -> None:
    with session:
        session.step()
        session.step()
    (shown,) = counter.shown  # nothing has changed since
    assert shown["patience"] == {
        "name": "patience",
        "value": 60.0,
        "unit": "s",
        "doc": "How long.",
        "fixed": "",
        "least": 0,
        "most": None,
    }
    assert "must be known before the run: 'patient/sequence/condition'" in shown["level"]["fixed"]
    assert "must be known before the run" in shown["pace"]["fixed"]
    assert (shown["level"]["value"], shown["pace"]["value"]) == (2, 0.5)


def test_what_is_set_counts_from_then_on_and_is_told(counter: Counter, session: hbt.Session) -> None:
    with session:
        session.step()
        counter.ask("patience", 0.5)
        assert session.run_until(lambda now: now.outcome, timeout=5)
        assert session.time < 1
    assert counter.answers == [(0, "")]
    assert [shown["patience"]["value"] for shown in counter.shown] == [60.0, 0.5]
    assert "set patience = 0.5 s by ROS 2" in [event["text"] for event in session.report.events]


def test_what_cannot_be_is_refused_with_the_reason_and_what_comes_late_is_left(
    counter: Counter, session: hbt.Session
) -> None:
    with session:
        session.step()
        for name, value in (("patience", -1), ("patience", "soon"), ("level", 3)):
            counter.ask(name, value)
        counter.ask("patience", 0.1, ago=1.0)  # who asked has been told that nobody answers
        session.step()
        session.step()
        assert not session.outcome
    below, no_number, fixed = (why for _, why in counter.answers)
    assert "must be > 0" in below
    assert "must be a number" in no_number
    assert "must be known before the run" in fixed
    assert len(counter.shown) == 1


def test_the_reason_has_room_whatever_was_asked(counter: Counter, session: hbt.Session) -> None:
    with session:
        session.step()
        counter.ask("patience", "🤖" * 1000)
        session.step()
    ((_, why),) = counter.answers
    assert "'duration' must be" in why
    assert len(json.dumps(why)) < 4000


SKILLS = '''
from humanoid_bt import Skill, Status, param


class Low(Skill):
    """Take little."""

    amount: float = param(2.0, minimum=0.0, maximum=5.0, doc="How much.")

    def update(self) -> Status:
        return self.running("at it")


class High(Low):
    """Take more."""

    amount: float = param(2.0, minimum=1.0, maximum=9.0, doc="How much.")
'''
LOW, HIGH = ("{" + name + ": {amount: $amount}}" for name in ("low", "high"))
BOTH, SWAPPED = (
    f"format: 1\nparameters: {{amount: 2}}\nroot: {{parallel: [{one}, {other}]}}\n"
    for one, other in ((LOW, HIGH), (HIGH, LOW))
)


def test_the_limits_are_those_that_every_node_takes(counter: Counter, tmp_path: Path) -> None:
    (tmp_path / "trees").mkdir()
    (tmp_path / "skills").mkdir()
    (tmp_path / "skills/amounts.py").write_text(SKILLS)
    for name, text in {"both": BOTH, "swapped": SWAPPED}.items():
        (tmp_path / "trees" / f"{name}.yaml").write_text(text)
        with hbt.Session(name, workspace=tmp_path) as run:
            run.step()
        told = counter.shown[-1]["amount"]
        assert (told["least"], told["most"], told["fixed"]) == (1.0, 5.0, "")


def test_nothing_is_set_while_no_tree_runs(counter: Counter, session: hbt.Session) -> None:
    with session:
        session.step()
        session._drive.runner.rest(End("success", "it is done"))
        counter.ask("patience", 3.0)
        session.step()
        assert counter.answers == [(0, "no tree runs now: the next one starts with its own")]
        assert session.node("timeout").values["duration"] == 60.0
