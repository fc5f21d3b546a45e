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


def test_nothing_is_kept_of_calls_that_are_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    client = Client()
    monkeypatch.setattr(Caller, "_client", lambda *_: client)
    monkeypatch.setattr(calls, "interface", lambda *_: SimpleNamespace(Request=Message, Response=Message))
    orders, answers = (RingWriter.create(tmp_path / name, 512, 8) for name in ("orders", "answers"))
    ears: Any = Ears()
    caller = Caller(ears, RingReader.open(tmp_path / "orders"), answers, "run", lambda *_: None)
    heard = RingReader.open(tmp_path / "answers")
    for number in range(1, 4):
        orders.write(json.dumps({"order": "ask", "number": number, "call": dataclasses.asdict(CALL)}).encode())
    ears.turn()
    requests = [weakref.ref(asked) for asked in caller._asked.values()]
    for answer in (client.waiting.pop(0), client.waiting.pop(0)):
        answer(SimpleNamespace(cancelled=lambda: False, result=Message))
    ears.turn()
    told = [json.loads(payload) for _, payload in heard.since(0)[0]]
    assert [one["number"] for one in told if one["state"] == "success"] == [1, 2]
    del answer
    gc.collect()
    assert [request() is None for request in requests] == [True, True, False]
    assert not caller.idle
    caller.end()
    ears.turn()
    assert caller.idle
