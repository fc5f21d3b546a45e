"""Goals from outside: the tree runs for each, with parameters of its own, and the run goes on."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import humanoid_bt as hbt
from humanoid_bt.core.errors import UserError
from humanoid_bt.session.goals import GoalTrees
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.watch import Watch

REST = """
format: 1
name: rest
parameters: {duration: 5 s}
root: {emergency_stop: {wait: $duration}}
"""


class Desk:
    """Gives orders to a run in lockstep, and keeps how their goals ended."""

    def __init__(self) -> None:
        self.orders: deque[dict[str, Any]] = deque()
        self.ended: list[tuple[str, str]] = []
        self.why = ""

    def start(self, goal: str, duration: float) -> None:
        self.orders.append({"order": "start", "goal": goal, "parameters": {"duration": duration}})

    def cancel(self, goal: str) -> None:
        self.orders.append({"order": "cancel", "goal": goal})


@pytest.fixture
def desk(monkeypatch: pytest.MonkeyPatch) -> Desk:
    desk = Desk()

    def taken(_engine: Lockstep) -> list[dict[str, Any]]:
        return [desk.orders.popleft() for _ in range(len(desk.orders))]

    def announce(_engine: Lockstep, kind: str, values: Mapping[str, Any]) -> None:
        if kind == "goal":
            desk.ended.append((values["goal"], values["outcome"]))
            desk.why = values["reason"]

    monkeypatch.setattr(Lockstep, "takes_orders", True)
    monkeypatch.setattr(Lockstep, "take_orders", taken)
    monkeypatch.setattr(Lockstep, "announce", announce)
    found = GoalTrees.poll
    monkeypatch.setattr(Watch, "poll", lambda watch: found(watch._edits))  # here and now, without its thread
    monkeypatch.setattr(Watch, "__enter__", lambda watch: watch)
    monkeypatch.setattr(Watch, "__exit__", lambda *_: None)
    return desk


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    path = tmp_path / "rest.yaml"
    path.write_text(REST)
    return path


def test_the_tree_runs_once_for_every_goal(desk: Desk, tree: Path) -> None:
    with hbt.Session(tree) as session:
        session.run_until(1.0)
        assert session.node("wait").status.name == "INVALID"  # nothing starts by itself
        for number, duration in enumerate((0.5, 1.5)):
            began = session.time
            desk.start(f"{number}", duration)
            session.run_until(lambda _, goal=f"{number}": (goal, "success") in desk.ended, timeout=10)
            assert session.time - began == pytest.approx(duration, abs=0.2)
    assert desk.ended == [("0", "success"), ("1", "success")]


def test_a_goal_that_is_canceled_ends_and_another_can_come(desk: Desk, tree: Path) -> None:
    with hbt.Session(tree) as session:
        desk.start("long", 1000)
        session.run_until(1.0)
        desk.cancel("long")
        session.run_until(1.5)
        assert desk.ended == [("long", "interrupted")]
        desk.start("late", 1000)
        desk.cancel("late")  # before its tree is there
        session.run_until(2.0)
        assert session.node("wait").status.name == "INVALID"  # which does not start then
        desk.start("next", 0.2)
        session.run_until(3.0)
    assert desk.ended[1:] == [("late", "interrupted"), ("next", "success")]


def test_a_goal_with_a_parameter_that_cannot_be_is_an_error_and_told(desk: Desk, tree: Path) -> None:
    tree.write_text(REST.replace("{wait: $duration}", "{sequence: [{wait: $duration}, idle]}"))
    with hbt.Session(tree) as session:
        desk.start("wrong", -1)
        session.run_until(0.5)
        assert session.outcome == ""
    assert desk.ended == [("wrong", "error")]
    assert desk.why == "'duration' must be >= 0, not -1.0"  # and not of what the tree's warnings say
    assert f"a goal has come that cannot be: {desk.why}" in [event["text"] for event in session.report.events]


@pytest.mark.usefixtures("desk")
def test_goals_and_edits_do_not_go_together(tree: Path) -> None:
    with pytest.raises(UserError, match="'watch' does not go with the action of a gateway"):
        hbt.Session(tree, watch=True)
    with pytest.raises(UserError, match="a tree that is loaded already does not go"):
        hbt.Session(hbt.load(tree))
