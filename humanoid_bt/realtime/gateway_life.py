"""The gateway of a run as decision sees it: started, listened to, and started again when it is gone."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from humanoid_bt.core.messages import Level, Pause, Percept
from humanoid_bt.link.ring import RingReader
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.link.wire import decode_event, decode_percepts, percepts_room
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.children import Children
from humanoid_bt.realtime.companion import Companion
from humanoid_bt.realtime.gateway_calls import CheckCall, GatewayCalls

_NEWS = ("gateway_news", "gateway_estop_news")
_READ = ("gateway_percept", "gateway_order", "gateway_answer", "gateway_setting", *_NEWS)
_MODULES = {  # by name: they stand above this room
    "gateway": "humanoid_bt.gateway.process",
    "gateway_estop": "humanoid_bt.gateway.estop_process",
}


@dataclass(frozen=True)
class GatewayPlan:
    """What a run needs to know of its gateway.

    Attributes:
        file: the gateway file.
        percepts: the percepts that come through it.
        stops: whether an e-stop comes through it, which has a process of its own.
        orders: whether goals come through it, each of which lets the tree run.
        parameters: whether programs outside see the parameters of the tree.
        pictures: whether it wants what the head camera sees.
        check_call: refuses calls that nobody could answer.
    """

    file: Path
    percepts: tuple[str, ...] = ()
    stops: bool = False
    orders: bool = False
    parameters: bool = False
    pictures: bool = False
    check_call: CheckCall = lambda _call, _places: None


class GatewayLife:
    """Looks after the gateway, once per tick. While any of it is gone, control is to hold the robot.

    Args:
        plan: what it is.
        folder: of the run; the gateway's channels are made there.
        children: the processes of the run.
        calls: carries what the tree asks of other programs.

    Attributes:
        hold: what is gone and why, None while all of it is there.
        percepts: the latest of each name.
        unseen: percepts that were never published so far, and why.
    """

    def __init__(self, plan: GatewayPlan, folder: RunFolder, children: Children, calls: GatewayCalls) -> None:
        channels.create_gateway_channels(folder, percepts_room(plan.percepts))
        self.hold: Pause | None = None
        self.percepts: dict[str, Percept] = {}
        self.unseen: Mapping[str, str] = {}
        self._told = channels.writer(folder, "gateway_told")
        self._shown = channels.writer(folder, "gateway_parameters")
        self._readers = {name: channels.reader(folder, name) for name in _READ}
        self._read = dict.fromkeys(self._readers, 0)
        self._beat = channels.gateway_beat(folder)
        self._calls, self._starts, self._why = calls, 1, ""
        calls.connect(channels.writer(folder, "gateway_call"))
        self._news: list[tuple[Level, str]] = []
        ring: RingReader = self._readers["gateway_percept"]
        signs = {"gateway": lambda: ring.sequence, "gateway_estop": lambda: self._beat.count}
        self._companions = {
            role: Companion(folder, children, role=role, module=module, signs=signs[role])
            for role, module in _MODULES.items()
            if role == "gateway" or plan.stops
        }

    def start(self) -> None:
        """Start it, and wait until it is there; raises as :meth:`Companion.wait`."""
        for companion in self._companions.values():
            companion.begin()
        for companion in self._companions.values():
            companion.wait()

    def look(self) -> None:
        """Take what it says; start again what of it is gone."""
        for payload in self._new("gateway_percept"):
            seen, self.unseen = decode_percepts(payload)
            self.percepts |= {percept.name: percept for percept in seen}
        for companion in self._companions.values():
            companion.look()
        gone = [(role, companion.gone) for role, companion in self._companions.items() if companion.gone]
        if gone and self.hold is None:
            role, why = gone[0]
            self._news.append(("error", f"the {role} is gone, and control holds the robot until it is back: {why}"))
        elif not gone and self.hold is not None:
            self._news.append(("info", f"the {self.hold.source} is there again: the tree goes on"))
        self.hold = (self.hold or Pause(*gone[0])) if gone else None
        self._hear_answers(self._companions["gateway"])

    def _hear_answers(self, gateway: Companion) -> None:
        """Take answers to calls; those of a gateway that is gone for good, and those that are lost, never come."""
        payloads, lost = self._since("gateway_answer")
        for payload in payloads:
            self._calls.hear(json.loads(payload))
        if lost:
            self._calls.lose(f"{lost} of the things it told came while nobody listened, and are lost")
        self._why = gateway.gone or self._why
        if gateway.starts != self._starts and not gateway.gone:  # it hears what it is told from now on
            self._starts = gateway.starts
            self._calls.lose(f"the gateway was gone, {self._why}")

    def take_news(self) -> list[tuple[Level, str]]:
        """Return what happened since the last time."""
        news, self._news = self._news, []
        events = [decode_event(payload) for name in _NEWS for payload in self._new(name)]
        return news + [(event.level, event.text) for event in events]

    def take_orders(self) -> list[dict[str, Any]]:
        """Return which goals came, or were canceled, since the last time."""
        return [json.loads(payload) for payload in self._new("gateway_order")]

    def take_settings(self) -> list[dict[str, Any]]:
        """Return which parameters are to be set, since the last time."""
        return [json.loads(payload) for payload in self._new("gateway_setting")]

    def show_parameters(self, shown: Sequence[Mapping[str, Any]]) -> None:
        """Show the parameters of the tree to this gateway, and to every one that comes after it."""
        data = json.dumps(shown).encode()
        if len(data) > self._shown.slot_size:
            why = f"the parameters of the tree are too many to be shown: {len(data)} bytes"
            self._news.append(("warning", why))
            return
        self._shown.write(data)

    def tell(self, kind: str, values: Mapping[str, object]) -> None:
        """Tell it of something that happened; of what is too long nobody hears."""
        data = json.dumps({"kind": kind, **values}).encode()
        if len(data) <= self._told.slot_size:
            self._told.write(data)

    def close(self) -> None:
        """Let go of its channels."""
        self._told.close()
        self._shown.close()
        self._calls.close()
        self._beat.close()
        for reader in self._readers.values():
            reader.close()

    def _new(self, name: str) -> list[bytes]:
        return self._since(name)[0]

    def _since(self, name: str) -> tuple[list[bytes], int]:
        """Return what came through a channel since the last time, and how much of it is lost."""
        entries, lost = self._readers[name].since(self._read[name])
        if entries:
            self._read[name] = entries[-1][0]
        return [payload for _, payload in entries], lost
