"""The plant's end of the cable: it serves one driver at a time, and looks after the robot when that one is gone.

Time is the plant's: :meth:`PlantServer.run_cycle` is one servo period, on a wall clock or in lockstep.
"""

from __future__ import annotations

import secrets
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from humanoid_bt.cable.address import Address
from humanoid_bt.cable.cables import Cable
from humanoid_bt.cable.frames import Frame, FrameKind, SealError, pack, unpack
from humanoid_bt.cable.order import Order
from humanoid_bt.cable.payloads import (
    Description,
    Hello,
    PlantState,
    Sensors,
    Simulated,
    pack_refusal,
    pack_sensors,
    pack_simulated,
    pack_welcome,
    unpack_command,
    unpack_hello,
)
from humanoid_bt.cable.watchdog import PlantWatchdog
from humanoid_bt.core.clock import DECISION_PERIOD, SERVO_PERIOD, cycles
from humanoid_bt.core.messages import Level, Reading, Target
from humanoid_bt.link.wire import Event, WireError, decode_command, encode_event
from humanoid_bt.plant.interface import Plant

_START_TIMEOUT = 10.0  # s that a driver gets from its welcome to its first command
_TELL_AGAIN = 1.0  # s after which the same complaint is told again, with how often it was due
_TRUTH_PHASE = cycles(DECISION_PERIOD)
_LEFT = "left"  # what a driver did that said bye


class Served(Plant, Protocol):
    """A plant that can be served: what a driver needs besides what every plant offers."""

    @property
    def description(self) -> Description:
        """What it is."""

    def begin(self, hello: Hello) -> str:
        """Get ready for a driver; return why it cannot have the plant, "" if it can.

        A simulation begins anew. A real robot stays as it is, and refuses while it is not safe to be driven.
        """

    def surround(self, targets: Mapping[str, Target]) -> None:
        """Let what surrounds the robot move, once in 20 ms; nothing for a real robot.

        Args:
            targets: in force, which tell a simulation what the robot is sent to touch.
        """

    def truth(self) -> Simulated | None:
        """Return what only a simulation knows; None of a real robot."""

    def take_news(self) -> Sequence[tuple[Level, str]]:
        """Return what happened since the last time, for people."""


@dataclass
class _Driver:
    """Who drives the plant: where it is, its session, the number of its hello, the order of its commands, targets."""

    peer: Address
    session: int
    nonce: int
    order: Order
    since: int
    heard: int = 0  # sequence of its newest command
    targets: Mapping[str, Target] = field(default_factory=dict)
    targets_of: int = -1  # sequence of the newest of them


class PlantServer:
    """Serves a plant.

    Args:
        plant: it.
        cable: on which drivers come.
        watchdog: looks after the robot when they go.
        key: with which frames are sealed; None for a checksum.
        tell: is told what happens.

    Attributes:
        cycle: servo cycles so far.
        state: what the plant does.
        driver: where its driver is, None while it has none.
    """

    def __init__(
        self,
        plant: Served,
        cable: Cable,
        watchdog: PlantWatchdog,
        key: bytes | None = None,
        tell: Callable[[Level, str], None] = lambda _level, _text: None,
    ) -> None:
        self._plant, self._cable, self._watchdog, self._key, self._tell = plant, cable, watchdog, key, tell
        self._reading = Reading(len(plant.description.joints))
        self._driver: _Driver | None = None
        self._left = 0  # session that ended as it should
        self._told: dict[str, int] = {}
        self._untold: Counter[str] = Counter()
        self.cycle = 0

    @property
    def state(self) -> PlantState:
        """What the plant does."""
        return self._watchdog.state

    @property
    def driver(self) -> Address | None:
        """Where its driver is."""
        return self._driver.peer if self._driver else None

    def run_cycle(self) -> None:
        """Run one servo period: hear, drive, tell what the sensors say."""
        before = self.state
        for data, sender in self._cable.receive():
            self._hear(data, sender)
        command = self._watchdog.command()
        self._look_after(before)
        if self.cycle % _TRUTH_PHASE == 0:
            self._plant.surround(self._driver.targets if self._driver else {})
        if command is not None:
            self._plant.step(command)
        self.cycle += 1
        self._publish()

    def close(self) -> None:
        """Let go of the cable, and give the drives the safe state, which they are left with. Who drives is told."""
        if self._driver is not None:
            self._refuse(self._driver.peer, self._driver.session, "the plant ends")
        self._cable.close()
        self._watchdog.be_safe()
        if (command := self._watchdog.command()) is not None:
            self._plant.step(command)

    # ---- in ---------------------------------------------------------------------------------------------------------

    def _hear(self, data: bytes, sender: Address) -> None:
        try:
            frame = unpack(data, self._key)
            if frame.kind is FrameKind.HELLO:
                self._greet(frame, unpack_hello(frame.payload), sender)
            elif (driver := self._driver) is None or frame.session != driver.session or sender != driver.peer:
                self._refuse_stranger(frame, sender)
            elif frame.kind is FrameKind.COMMAND:
                self._take(driver, frame)
            elif frame.kind is FrameKind.TARGETS:
                if frame.sequence > driver.targets_of:
                    driver.targets, driver.targets_of = decode_command(frame.payload).targets, frame.sequence
            elif frame.kind is FrameKind.BYE:
                self._let_go(_LEFT)
        except SealError as error:
            if self._complain("seal", f"a frame from {sender} is refused: {error}"):
                wanted = "sealed with its key (--key FILE)" if self._key else "without a key"
                self._cable.send(pack(self._refusal(0, f"it takes only frames {wanted}")), sender)
        except WireError as error:
            self._complain("frame", f"a frame from {sender} is thrown away: {error}")

    def _greet(self, frame: Frame, hello: Hello, sender: Address) -> None:
        driver, nonce = self._driver, frame.session
        if driver is not None and (driver.nonce, driver.peer) != (nonce, sender):
            since = (self.cycle - driver.since) * SERVO_PERIOD
            self._complain("second", f"{sender} is refused: {driver.peer} drives the plant")
            self._refuse(sender, nonce, f"{driver.peer} drives this plant since {since:.0f} s")
            return
        if driver is None:
            why = self._plant.description.mismatch(hello) or self._plant.begin(hello)
            if why:
                self._complain("hello", f"{sender} is refused: {why}")
                self._refuse(sender, nonce, why)
                return
            driver = self._driver = _Driver(sender, secrets.randbits(63) + 1, nonce, Order(), self.cycle)
            if self._plant.description.simulated:
                self._watchdog.reset()
            self._tell("info", f"{sender} drives")
        self._send(FrameKind.WELCOME, pack_welcome(nonce, self._plant.description))

    def _take(self, driver: _Driver, frame: Frame) -> None:
        command = unpack_command(frame.payload, len(self._plant.description.joints))
        if fault := driver.order.fault(frame.sequence, frame.stamp):
            if not fault.startswith("out of order"):  # which cables do
                self._complain("order", f"a command is refused: {fault}")
            return
        if driver.heard and self.state is not PlantState.FOLLOWS:
            self._note("warning", "commands come again: the plant follows")
        driver.heard = frame.sequence
        self._watchdog.follow(command)

    def _refuse_stranger(self, frame: Frame, sender: Address) -> None:
        """Tell who does not drive the plant, or not any more, that nothing of it is heard."""
        if frame.session == self._left:
            return  # still under way when it left
        if frame.kind is FrameKind.COMMAND and self._complain(
            "stranger", f"commands from {sender} are not heard: it has no session"
        ):
            self._refuse(sender, frame.session, "the plant has let go of this driver: say hello again")

    # ---- the robot --------------------------------------------------------------------------------------------------

    def _look_after(self, before: PlantState) -> None:
        """Tell of the watchdog, and let go of a driver that is gone."""
        state, watchdog, driver = self.state, self._watchdog, self._driver
        if driver is None:
            return
        if not driver.heard:
            if self.cycle - driver.since > cycles(_START_TIMEOUT):
                self._let_go(f"sent no command within {_START_TIMEOUT:g} s")
            return
        if before is PlantState.FOLLOWS is not state:
            self._note("error", f"no command for {watchdog.silent - 1} ms: the plant {_DOES[state]}")
        if watchdog.lost:
            self._let_go(f"was silent for {watchdog.silent - 1} ms")

    def _let_go(self, why: str) -> None:
        """End the session: commands of this driver count no more, another may come."""
        driver, self._driver = self._driver, None
        self._watchdog.be_safe()
        if driver is not None:
            self._left = driver.session if why == _LEFT else 0
            self._tell("warning" if "silent" in why else "info", f"{driver.peer} {why}: the plant {_DOES[self.state]}")
            if why != _LEFT:
                self._refuse(driver.peer, driver.session, f"the plant has let go: this driver {why}")

    # ---- out --------------------------------------------------------------------------------------------------------

    def _publish(self) -> None:
        driver = self._driver
        news = self._plant.take_news()
        for level, text in news:
            self._note(level, text)
        if driver is None:
            return
        reading = self._plant.measure(self._reading)
        ago = max(0, self._watchdog.silent - 1) * SERVO_PERIOD  # in this cycle: 0
        self._send(FrameKind.SENSORS, pack_sensors(Sensors(driver.heard, ago, self.state, reading.values)))
        if self.cycle % _TRUTH_PHASE == 1 and (known := self._plant.truth()) is not None:
            self._send(FrameKind.TRUTH, pack_simulated(known))

    def _note(self, level: Level, text: str) -> None:
        """Tell something on both sides."""
        self._tell(level, text)
        if self._driver is not None:
            self._send(FrameKind.NOTE, encode_event(Event(self.cycle * SERVO_PERIOD, level, text)))

    def _send(self, kind: FrameKind, payload: bytes) -> None:
        if self._driver is not None:
            stamp = self.cycle * SERVO_PERIOD
            frame = Frame(kind, self._driver.session, self.cycle, stamp, payload)
            self._cable.send(pack(frame, self._key), self._driver.peer)

    def _refuse(self, peer: Address, nonce: int, reason: str) -> None:
        self._cable.send(pack(self._refusal(nonce, reason), self._key), peer)

    def _refusal(self, nonce: int, reason: str) -> Frame:
        return Frame(FrameKind.REFUSED, nonce, self.cycle, self.cycle * SERVO_PERIOD, pack_refusal(nonce, reason))

    def _complain(self, what: str, text: str) -> bool:
        """Tell of something that somebody may do very often; return whether it was told, and not too soon."""
        last = self._told.get(what)
        if last is not None and self.cycle - last < cycles(_TELL_AGAIN):
            self._untold[what] += 1
            return False
        more = f" (and {count} more)" if (count := self._untold.pop(what, 0)) else ""
        self._told[what] = self.cycle
        self._tell("warning", text + more)
        return True


_DOES = {
    PlantState.WAITS: "waits",
    PlantState.FOLLOWS: "follows",
    PlantState.HOLDS: "holds its last position",
    PlantState.DAMPS: "lets go, and only brakes",
}
