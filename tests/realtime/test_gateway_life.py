"""The gateway as decision sees it, without its processes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from humanoid_bt.decision.calls import Answer, Call
from humanoid_bt.link.run_folder import RunFolder, RunInfo
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.gateway_calls import GatewayCalls
from humanoid_bt.realtime.gateway_life import GatewayLife, GatewayPlan

ACTION = Call("action", "/lift", "some_interfaces/Lift")


class Processes:
    """The processes of a run, of which there are none."""

    def start(self, _role: str, _module: str) -> None:
        pass

    def how_ended(self, _role: str) -> str:
        return ""


def test_no_call_waits_for_ever_whose_answer_is_lost(tmp_path: Path) -> None:
    processes: Any = Processes()
    with RunFolder.create(RunInfo("tree", "robot"), tmp_path / "runs") as folder:
        calls = GatewayCalls(lambda _call, _places: None)
        life = GatewayLife(GatewayPlan(tmp_path / "gateway.yaml"), folder, processes, calls)
        answers = channels.writer(folder, "gateway_answer")
        lost, chatty = calls.ask(ACTION), calls.ask(ACTION)
        answers.write(json.dumps({"number": lost, "state": "success", "text": "done", "values": {}}).encode())
        for count in range(80):  # while decision hangs
            told = {"number": chatty, "state": "running", "text": f"{count} %", "values": {}}
            answers.write(json.dumps(told).encode())
        life.look()
        why = "17 of the things it told came while nobody listened, and are lost"
        for number in (lost, chatty):
            assert calls.answer(number) == Answer("failure", f"nobody heard what became of /lift: {why}")
        orders = [json.loads(payload) for _, payload in channels.reader(folder, "gateway_call").since(0)[0]]
        assert [order["order"] for order in orders] == ["ask", "ask", "drop", "drop"]  # neither goes on unheard
        answers.close()
        life.close()
