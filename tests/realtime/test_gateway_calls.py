"""Calls on their way to a gateway that may come and go."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.decision.calls import Answer, Call
from humanoid_bt.link.ring import RingReader, RingWriter
from humanoid_bt.realtime.gateway_calls import GatewayCalls

SERVICE = Call("service", "/lamp", "std_srvs/SetBool", {"data": True}, ("message",))
ACTION = Call("action", "/lift", "some_interfaces/Lift")


@pytest.fixture
def ring(tmp_path: Path) -> Iterator[RingReader]:
    RingWriter.create(tmp_path / "calls", 512, 8).close()
    reader = RingReader.open(tmp_path / "calls")
    yield reader
    reader.close()


@pytest.fixture
def calls(tmp_path: Path, ring: RingReader) -> Iterator[GatewayCalls]:
    found = GatewayCalls(lambda _call, _places: None)
    found.connect(RingWriter.open(tmp_path / "calls"))
    yield found
    found.close()


def orders(ring: RingReader) -> list[dict[str, Any]]:
    return [json.loads(payload) for _, payload in ring.since(0)[0]]


def told(number: int, state: str, text: str = "", **values: Any) -> dict[str, Any]:
    return {"number": number, "state": state, "text": text, "values": values}


def test_a_call_is_pending_until_the_gateway_says_what_became_of_it(calls: GatewayCalls, ring: RingReader) -> None:
    number = calls.ask(SERVICE)
    assert calls.answer(number).state == "pending"
    (order,) = orders(ring)
    assert Call(**{**order["call"], "reads": ("message",)}) == SERVICE
    calls.hear(told(number, "running", "asked"))
    calls.hear(told(number, "success", "it is on", message="on"))
    assert calls.answer(number) == Answer("success", "it is on", {"message": "on"})
    assert [answer.state for _, answer in calls.take_news()] == ["running", "success"]
    calls.drop(number)
    assert len(orders(ring)) == 1  # it was over: nothing is to be canceled


def test_a_call_that_is_dropped_is_canceled_and_its_answer_heard_by_nobody(
    calls: GatewayCalls, ring: RingReader
) -> None:
    number = calls.ask(ACTION)
    calls.drop(number)
    assert orders(ring)[-1] == {"order": "drop", "number": number, "call": {"kind": "action", "name": "/lift"}}
    calls.hear(told(number, "success"))
    assert not list(calls.take_news())


def test_calls_of_a_gateway_that_is_gone_fail_and_the_next_one_is_to_cancel_them(
    calls: GatewayCalls, ring: RingReader
) -> None:
    lost, over = calls.ask(ACTION), calls.ask(SERVICE)
    calls.hear(told(over, "success"))
    calls.lose("the gateway was gone, its process ended (killed by signal 9)")
    assert calls.answer(over).state == "success"
    answer = calls.answer(lost)
    assert (answer.state, orders(ring)[-1]["order"]) == ("failure", "drop")
    why = "nobody heard what became of /lift: the gateway was gone, its process ended (killed by signal 9)"
    assert answer.text == why
    calls.drop(lost)
    assert len(orders(ring)) == 3


def test_what_is_too_long_fails_at_once(calls: GatewayCalls) -> None:
    number = calls.ask(Call("service", "/say", "x/Say", {"text": "x" * 600}))
    answer = calls.answer(number)
    assert answer.state == "failure"
    assert "/say cannot be asked" in answer.text
    assert "512 bytes" in answer.text


def test_calls_of_which_the_gateway_may_never_have_heard_fail(calls: GatewayCalls, ring: RingReader) -> None:
    begun, over = calls.ask(ACTION), calls.ask(SERVICE)
    calls.hear(told(over, "success"))
    calls.hear({"lost": 3})
    why = "nobody heard what became of /lift: the gateway was busy, and 3 of the things it was told are lost"
    assert calls.answer(begun) == Answer("failure", why)
    assert calls.answer(over).state == "success"
    assert [order["order"] for order in orders(ring)] == ["ask", "ask", "drop"]
