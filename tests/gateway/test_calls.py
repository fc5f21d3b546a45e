"""What the gateway does with calls of a tree, with stand-ins for ROS 2."""

from __future__ import annotations

import dataclasses
import gc
import json
import weakref
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from humanoid_bt.decision.calls import Call
from humanoid_bt.gateway import calls
from humanoid_bt.gateway.calls import Caller
from humanoid_bt.link.ring import RingReader, RingWriter

CALL = Call("service", "/lamp", "std_srvs/Trigger")


class Message:
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        return {}


class Client:
    """Of a service that answers when it is told to."""

    def __init__(self) -> None:
        self.waiting: list[Callable[[Any], None]] = []

    def service_is_ready(self) -> bool:
        return True

    def call_async(self, _request: Any) -> Any:
        return SimpleNamespace(add_done_callback=self.waiting.append)

    def remove_pending_request(self, _future: Any) -> None: ...


class Ears:
    """Has the caller's turns taken by the test."""

    def __init__(self) -> None:
        self.node = SimpleNamespace()

    def every(self, _period: float, turn: Callable[[], None]) -> None:
        self.turn = turn


class Called:
    """A caller whose turns the test takes, with the far ends of its rings."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.client, ears = Client(), Ears()
        monkeypatch.setattr(Caller, "_client", lambda *_: self.client)
        monkeypatch.setattr(calls, "interface", lambda *_: SimpleNamespace(Request=Message, Response=Message))
        self.orders = RingWriter.create(folder / "orders", 512, 8)
        answers = RingWriter.create(folder / "answers", 512, 64)
        self.heard = RingReader.open(folder / "answers")
        asks: Any = ears
        self.caller = Caller(asks, RingReader.open(folder / "orders"), answers, "run", lambda *_: None)
        self.turn = ears.turn

    def ask(self, number: int) -> None:
        order = {"order": "ask", "number": number, "call": dataclasses.asdict(CALL)}
        self.orders.write(json.dumps(order).encode())

    @property
    def told(self) -> list[dict[str, Any]]:
        return [json.loads(payload) for _, payload in self.heard.since(0)[0]]


@pytest.fixture
def called(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Called:
    return Called(tmp_path, monkeypatch)


def test_nothing_is_kept_of_calls_that_are_over(called: Called) -> None:
    caller = called.caller
    for number in range(1, 4):
        called.ask(number)
    called.turn()
    requests = [weakref.ref(asked) for asked in caller._asked.values()]
    for answer in (called.client.waiting.pop(0), called.client.waiting.pop(0)):
        answer(SimpleNamespace(cancelled=lambda: False, result=Message))
    called.turn()
    assert [one["number"] for one in called.told if one["state"] == "success"] == [1, 2]
    del answer
    gc.collect()
    assert [request() is None for request in requests] == [True, True, False]
    assert not caller.idle
    caller.end()
    called.turn()
    assert caller.idle


def test_orders_that_are_lost_are_told_and_no_call_goes_on_that_may_have_been_dropped(called: Called) -> None:
    called.ask(1)
    called.turn()
    assert list(called.caller._asked) == [1]
    for number in range(2, 13):  # while the gateway is busy; there is room for eight
        called.ask(number)
    called.turn()
    (lost,) = [told["lost"] for told in called.told if "lost" in told]
    assert list(called.caller._asked) == list(range(2 + lost, 13))
    assert lost > 0
