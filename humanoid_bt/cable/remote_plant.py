"""Control's end of the cable: a plant like any other, whose sensors and drives are elsewhere."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from humanoid_bt.cable.address import Address
from humanoid_bt.cable.cables import Cable
from humanoid_bt.cable.frames import Frame, FrameKind, SealError, pack, unpack
from humanoid_bt.cable.order import Order
from humanoid_bt.cable.payloads import (
    Description,
    Hello,
    PlantState,
    Sensors,
    pack_command,
    pack_hello,
    unpack_refusal,
    unpack_sensors,
    unpack_simulated,
    unpack_welcome,
)
from humanoid_bt.cable.safe_state import LET_GO
from humanoid_bt.core.clock import SERVO_PERIOD, cycles
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Command, JointCommand, Level, Reading, Target, Truth
from humanoid_bt.link.wire import WireError, decode_event, encode_command
from humanoid_bt.plant.interface import SILENT_AFTER
from humanoid_bt.plant.touches import Touch

_HELLOS = 200  # that are sent before nobody is taken to be there
_GIVEN_UP = cycles(LET_GO) + cycles(SILENT_AFTER)  # servo cycles without anything that is believed
_SMOOTH = 0.02  # share of a new round trip in the mean that is kept
_SENT = 1024  # commands of which it is known when they were sent
_NANO = 1e-9
_MOST_NEWS = 100  # that wait to be taken


@dataclass(frozen=True)
class CableFigures:
    """What the cable was like so far.

    Attributes:
        round_trip: from a command to the first sensors that show it was heard, on average lately [s]; 0 before.
        longest: the longest of them [s].
        silence: longest time without sensors [s].
        came: frames with sensors that came.
        lost: that did not.
        late: that came after a newer one, or twice, and were not used.
    """

    round_trip: float
    longest: float
    silence: float
    came: int
    lost: int
    late: int

    def __str__(self) -> str:
        sent = max(1, self.came + self.lost + self.late)
        return (
            f"round trip {self.round_trip * 1e3:.1f} ms, at most {self.longest * 1e3:.0f} ms; "
            f"{self.lost / sent:.1%} of {sent} frames lost, {self.late / sent:.1%} too late; "
            f"longest silence {self.silence * 1e3:.0f} ms"
        )


class RemotePlant:
    """A plant at the other end of a cable.

    Args:
        cable: the cable.
        address: where the plant is.
        hello: who drives it.
        key: with which frames are sealed; None for a checksum.
        now: the time [ns].

    Attributes:
        fault: why the plant cannot be relied on now, "" while it can.
        lost: whether that is for good: it let go of this driver, or nothing it says was believed for too long.
        silent: servo cycles since its sensors were last heard.
        session: the plant's number for it, 0 before :meth:`connect`.
        description: what it says it is, after :meth:`connect`.
        external_force_max: largest external force on it so far, if it is simulated [N, Nm].
        touches: what of the scene it has touched so far, likewise.
    """

    def __init__(self, cable: Cable, address: Address, hello: Hello, key: bytes | None, now: Callable[[], int]) -> None:
        self._cable, self._address, self._hello, self._key, self._now = cable, address, hello, key, now
        self._nonce = secrets.randbits(63) + 1
        self.session = 0
        self._order = Order()
        self._sensors: Sensors | None = None
        self._heard = self._measured = 0  # sequence of the newest sensors; of those that were measured last
        self._sent = [0] * _SENT  # ns, by sequence
        self._sequence = 0
        self._commands = 0
        self._refused = ""
        self._unsealed = ""
        self._trip = self._longest = 0.0
        self._came = self._longest_silence = 0
        self._truth: Truth | None = None
        self._truth_of = -1  # sequence of the newest
        self._news: list[tuple[Level, str]] = []
        self.external_force_max = 0.0
        self.touches: list[Touch] = []
        self.description: Description | None = None
        self.silent = self._late = 0  # servo cycles
        self.lost = False
        self.fault = ""

    @property
    def time(self) -> float:
        """Engine time [s]."""
        return self._sequence * SERVO_PERIOD

    def connect(self, wait: Callable[[], None]) -> None:
        """Say hello until the plant answers, and its sensors are heard.

        Args:
            wait: lets some time pass, such as 10 ms.

        Raises:
            UserError: nobody answers, or the plant refuses.
        """
        for _ in range(_HELLOS):
            if self.description is None:
                self._send(FrameKind.HELLO, self._nonce, pack_hello(self._hello))
            wait()
            self._listen()
            if self._refused:
                raise UserError(f"the plant at {self._address} refuses: {self._refused}")
            if self.description is not None and (why := self.description.mismatch(self._hello)):
                raise UserError(f"the plant at {self._address} does not fit: {why}")
            if self._sensors is not None:
                self.silent = 0
                return
        if self._unsealed:
            raise UserError(f"the plant at {self._address} is not for this driver: {self._unsealed}")
        hint = "start the robot's driver, or a simulated robot: humanoid-bt plant ROBOT --scene SCENE"
        raise UserError(f"no plant answers at {self._address}", hint=hint)

    def measure(self, into: Reading | None = None) -> Reading:
        """Return the newest that the sensors are known to have said; how long ago is its age."""
        self._listen()
        sensors = self._sensors
        assert sensors is not None, "connect first"
        reading = Reading(len(self._hello.joints)) if into is None else into
        reading.values[:] = sensors.values
        reading.time = self.time
        reading.age = self._trip / 2 + self.silent * SERVO_PERIOD
        reading.passed, self._measured = self._heard - self._measured, self._heard
        self.fault = self._why_unreliable(sensors)
        return reading

    def step(self, command: JointCommand) -> None:
        """Send a command; the plant drives by it when it comes."""
        self._sequence += 1
        self._sent[self._sequence % _SENT] = self._now()
        self._send(FrameKind.COMMAND, self.session, pack_command(command))
        self.silent += 1
        self._late = self._late + 1 if self._far else 0
        if max(self.silent, self._late) > _GIVEN_UP and not self.lost:
            self.lost = True
            how = f"silent for {self.silent} ms" if self.silent > _GIVEN_UP else f"{self._trip * 500:.0f} ms away"
            self._refused = f"the plant at {self._address} is {how}"
        self._longest_silence = max(self._longest_silence, self.silent)

    def surround(self, targets: Mapping[str, Target]) -> None:
        """Tell a simulated plant the targets in force: what the robot is sent to touch."""
        if self.description is not None and self.description.simulated:
            told = Command(self._sequence, self.time, targets, {})
            self._send(FrameKind.TARGETS, self.session, encode_command(told))

    def take_truth(self) -> Truth | None:
        """Return where the robot really is, if the plant is simulated and has said so since the last time."""
        truth, self._truth = self._truth, None
        return truth

    def take_news(self) -> Sequence[tuple[Level, str]]:
        """Return what the plant told since the last time."""
        news, self._news = self._news, []
        return news

    @property
    def figures(self) -> CableFigures:
        """What the cable was like so far."""
        order, silence = self._order, self._longest_silence * SERVO_PERIOD
        return CableFigures(self._trip, self._longest, silence, self._came, order.lost, order.late)

    def close(self) -> None:
        """Leave: the plant goes to its safe state."""
        if self.session:
            for _ in range(_BYES):
                self._send(FrameKind.BYE, self.session, b"")
        self._cable.close()

    # ---- in ---------------------------------------------------------------------------------------------------------

    def _listen(self) -> None:
        for data, sender in self._cable.receive():
            if sender != self._address:
                continue
            try:
                self._hear(unpack(data, self._key))
            except SealError as error:
                self._hear_unsealed(data, error)
            except WireError as error:
                self._tell("warning", f"a frame of the plant is thrown away: {error}")

    def _hear(self, frame: Frame) -> None:
        if frame.kind is FrameKind.REFUSED:
            number, reason = unpack_refusal(frame.payload)
            if self.session and number == self.session and not self.lost:
                self.lost = True
                self.fault = self._refused = reason
            elif not self.session and number == self._nonce:
                self._refused = reason
            elif number == 0:
                self._unsealed = reason
        elif frame.kind is FrameKind.WELCOME:
            nonce, description = unpack_welcome(frame.payload)
            if nonce == self._nonce and not self.session:
                self.session, self.description = frame.session, description
        elif frame.session == self.session != 0:
            self._hear_plant(frame)

    def _hear_plant(self, frame: Frame) -> None:
        if frame.kind is FrameKind.SENSORS:
            sensors = unpack_sensors(frame.payload, len(self._hello.joints))
            if fault := self._order.fault(frame.sequence, frame.stamp):
                if not fault.startswith("out of order"):
                    self._tell("warning", f"sensors of the plant are not used: {fault}")
                return
            self._came += 1
            self.silent = 0
            self._time_trip(sensors)
            before, self._sensors, self._heard = self._sensors, sensors, frame.sequence
            if sensors.state is PlantState.WAITS and before and np.array_equal(sensors.values, before.values):
                self._measured = self._heard  # nothing is measured before a simulation's time begins
        elif frame.kind is FrameKind.TRUTH:
            if frame.sequence <= self._truth_of:
                return  # a newer one has come
            self._truth_of = frame.sequence
            known = unpack_simulated(frame.payload)
            time = max(0.0, self.time - self._trip / 2)  # in the engine's time
            self._truth, self.external_force_max = replace(known.truth, time=time), known.force
            behind = time - known.truth.time
            new = known.touches[len(self.touches) :]
            self.touches += [replace(touch, time=touch.time + behind) for touch in new]
        elif frame.kind is FrameKind.NOTE:
            event = decode_event(frame.payload)
            self._tell(event.level, f"plant: {event.text}")

    def _hear_unsealed(self, data: bytes, error: SealError) -> None:
        """Keep what somebody says who has not our key: it is told if nobody else answers, and not believed."""
        self._unsealed = str(error)
        try:
            frame = unpack(data)
            if frame.kind is FrameKind.REFUSED:
                self._unsealed = unpack_refusal(frame.payload)[1]
        except WireError:
            pass

    def _time_trip(self, sensors: Sensors) -> None:
        """Learn from which command it was that the plant has heard how long the way there and back is."""
        before = self._sensors
        if before is not None and sensors.heard == before.heard:
            return
        if 0 < sensors.heard <= self._sequence < sensors.heard + _SENT:
            trip = (self._now() - self._sent[sensors.heard % _SENT]) * _NANO - sensors.ago
            trip = max(0.0, trip)
            self._trip += (trip - self._trip) * (_SMOOTH if self._trip else 1.0)
            self._longest = max(self._longest, trip)

    @property
    def _far(self) -> bool:
        """Whether what the sensors say is too old already as it comes."""
        return self._trip / 2 > SILENT_AFTER

    def _why_unreliable(self, sensors: Sensors) -> str:
        if self.lost:
            return self._refused
        if self.silent > cycles(SILENT_AFTER):
            return f"the plant is silent for more than {SILENT_AFTER * 1000:.0f} ms"
        if self._far:
            return f"what the plant says is more than {SILENT_AFTER * 1000:.0f} ms old"
        if sensors.state is PlantState.FOLLOWS or (not sensors.heard and self._sequence < cycles(LET_GO)):
            return ""  # at first it is as the last driver has left it
        return f"the plant hears no commands, and {_MEANWHILE[sensors.state]}"

    # ---- out --------------------------------------------------------------------------------------------------------

    def _send(self, kind: FrameKind, session: int, payload: bytes) -> None:
        frame = Frame(kind, session, self._sequence, self.time, payload)
        self._cable.send(pack(frame, self._key), self._address)

    def _tell(self, level: Level, text: str) -> None:
        if len(self._news) < _MOST_NEWS and (level, text) not in self._news:
            self._news.append((level, text))


_MEANWHILE = {
    PlantState.WAITS: "waits",
    PlantState.HOLDS: "holds its last position",
    PlantState.DAMPS: "lets go",
}
_BYES = 3  # one of them comes through
