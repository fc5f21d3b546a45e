"""Goals for a tree, taken one at a time, without ROS 2."""

from __future__ import annotations

import json
import sys
from collections.abc import Coroutine, Generator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from humanoid_bt.gateway import action
from humanoid_bt.gateway.action import ActionServer
from humanoid_bt.gateway.file import TreeAction
from humanoid_bt.gateway.node import Ears
from humanoid_bt.link.ring import RingReader, RingWriter


class Future:
    """What a coroutine waits for."""

    result: Any = None

    def set_result(self, result: Any) -> None:
        self.result = result

    def __await__(self) -> Generator[None, None, Any]:
        while self.result is None:
            yield
        return self.result


class Client:
    """Sends goals with a text; what rclpy is to an action, too."""

    def __init__(self) -> None:
        replies = SimpleNamespace(ACCEPT="accept", REJECT="reject")
        self.action = SimpleNamespace(ActionServer=self._serve, GoalResponse=replies, CancelResponse=replies)

    def _serve(self, _node: Any, _type: Any, _name: str, execute: Any, *, goal_callback: Any, **_: Any) -> None:
        self._execute, self._accept = execute, goal_callback

    def accepted(self, text: str) -> bool:
        return bool(self._accept(SimpleNamespace(text=text)) == "accept")

    def starts(self, text: str) -> Coroutine[Any, Any, Any]:
        ends = {"is_cancel_requested": False, "succeed": lambda: None, "abort": lambda: None}
        goal_id, request = SimpleNamespace(uuid=range(16)), SimpleNamespace(text=text)
        goal: Coroutine[Any, Any, Any] = self._execute(SimpleNamespace(goal_id=goal_id, request=request, **ends))
        goal.send(None)
        return goal


@dataclass
class Desk:
    client: Client
    server: ActionServer
    orders: RingReader
    news: list[str]


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Desk:
    client, news = Client(), list[str]()
    monkeypatch.setitem(sys.modules, "rclpy", client)
    kind = SimpleNamespace(Result=lambda: SimpleNamespace(get_fields_and_field_types=dict))
    monkeypatch.setattr(action, "interface", lambda *_: kind)
    config = TreeAction(name="/say", type="some_msgs/action/Say", parameters={"say": "text"})
    ears = cast(Ears, SimpleNamespace(node=None, future=Future))
    ring = RingWriter.create(tmp_path / "orders", 256)
    server = ActionServer(ears, config, ring, lambda _level, text: news.append(text))
    return Desk(client, server, RingReader.open(tmp_path / "orders"), news)


def test_one_goal_is_at_work_at_a_time(desk: Desk) -> None:
    assert desk.client.accepted("short")
    goal = desk.client.starts("short")
    _, order = desk.orders.latest() or (0, b"{}")
    assert json.loads(order) == {"order": "start", "goal": bytes(range(16)).hex(), "parameters": {"say": "short"}}
    assert not desk.client.accepted("another")
    desk.server.told({"goal": json.loads(order)["goal"], "outcome": "success", "reason": ""})
    with pytest.raises(StopIteration):
        goal.send(None)
    assert desk.client.accepted("another")
    assert desk.news == ["a goal of /say is refused: another one is at work"]


def test_a_goal_that_is_too_long_is_refused_and_hinders_no_other(desk: Desk) -> None:
    assert not desk.client.accepted("y" * 250)
    why = "its parameters are too long: 339 bytes, and 256 have room"
    assert desk.news == [f"a goal of /say is refused: {why}"]
    assert desk.client.accepted("short")


def test_a_goal_that_is_lost_hinders_no_other(desk: Desk) -> None:
    assert desk.client.accepted("short")
    with pytest.raises(RuntimeError):
        desk.client.starts("short").throw(RuntimeError("the node is gone"))
    assert desk.client.accepted("another")
