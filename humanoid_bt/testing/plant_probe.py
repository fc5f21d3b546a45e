"""A driver of plants that says what it likes, and notes everything that it hears: for ``check_plant``."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from humanoid_bt.cable.address import Address
from humanoid_bt.cable.cables import Cable
from humanoid_bt.cable.frames import Frame, FrameKind, pack, unpack
from humanoid_bt.cable.payloads import (
    Description,
    Hello,
    Sensors,
    pack_command,
    pack_hello,
    unpack_refusal,
    unpack_sensors,
    unpack_welcome,
)
from humanoid_bt.core.clock import SERVO_PERIOD, cycles
from humanoid_bt.core.messages import Array, JointCommand, Reading
from humanoid_bt.link.wire import WireError
from humanoid_bt.robot.model import RobotModel


class Heard(NamedTuple):
    """Sensors that came.

    Attributes:
        at: when [s].
        sequence, stamp: of the frame.
        sensors: what it says.
    """

    at: float
    sequence: int
    stamp: float
    sensors: Sensors


class Probe:
    """A driver, one servo period at a time.

    Args:
        cable: its end of a cable.
        plant: where the plant is.
        robot: that it drives.
        hello: what it says first.
        key: with which frames are sealed.
        wait: lets a servo period pass, and returns the time [s].

    Attributes:
        heard: all sensors of its session.
        refusals: reasons of the plant.
        description: what the plant says it is, None before it is welcome.
        session: its session, 0 before.
        sequence: of its newest command.
    """

    def __init__(
        self,
        cable: Cable,
        plant: Address,
        robot: RobotModel,
        hello: Hello,
        *,
        key: bytes | None,
        wait: Callable[[], float],
    ) -> None:
        self._cable, self._plant, self._robot, self._hello = cable, plant, robot, hello
        self._key, self._wait = key, wait
        self._nonce = secrets.randbits(63) + 1
        self._posture: Array | None = None
        self.now = 0.0
        self.heard: list[Heard] = []
        self.refusals: list[str] = []
        self.description: Description | None = None
        self.session = self.sequence = 0

    @property
    def last(self) -> Heard:
        """The newest sensors."""
        return self.heard[-1]

    def say_hello(self, seconds: float = 3.0) -> bool:
        """Say hello until the plant answers and its sensors come, or time is up; return whether it is welcome."""
        for count in range(cycles(seconds)):
            if count % 50 == 0 and self.description is None:
                self.send(FrameKind.HELLO, self._nonce, pack_hello(self._hello))
            self.listen()
            if self.refusals or self.heard:
                break
        return bool(self.heard)

    def drive(self, seconds: float, *, changes: dict[str, Array] | None = None) -> None:
        """Command the robot to stay as it was found, or something else besides, for a time [s]."""
        for _ in range(cycles(seconds)):
            self.sequence += 1
            self.command(self.sequence, self.still(**changes or {}))
            self.listen()

    def rest(self, seconds: float) -> None:
        """Command nothing for a time [s]."""
        for _ in range(cycles(seconds)):
            self.listen()

    def still(self, **changes: Array) -> JointCommand:
        """Return the command to stay as it was found."""
        if self._posture is None:
            reading = Reading(len(self._hello.joints))
            reading.values[:] = self.last.sensors.values
            self._posture = reading.joint_position.copy()
        zeros = np.zeros_like(self._posture)
        rows = {"position": self._posture, "velocity": zeros, "torque": zeros}
        rows |= {"stiffness": self._robot.stiffness, "damping": self._robot.damping}
        return JointCommand(**(rows | changes))

    def command(self, sequence: int, command: JointCommand, stamp: float | None = None) -> None:
        """Send a command."""
        self.send(FrameKind.COMMAND, self.session, pack_command(command), sequence, stamp)

    def send(
        self, kind: FrameKind, session: int, payload: bytes = b"", sequence: int = 0, stamp: float | None = None
    ) -> None:
        """Send a frame."""
        when = sequence * SERVO_PERIOD if stamp is None else stamp
        self.send_bytes(pack(Frame(kind, session, sequence, when, payload), self._key))

    def send_bytes(self, data: bytes) -> None:
        """Send bytes, whatever they are."""
        self._cable.send(data, self._plant)

    def listen(self) -> None:
        """Let a servo period pass, and note what has come."""
        self.now = self._wait()
        for data, sender in self._cable.receive():
            if sender == self._plant:
                self._note(data)

    def leave(self) -> None:
        """Say bye."""
        self.send(FrameKind.BYE, self.session)

    def close(self) -> None:
        """Let go of the cable."""
        self._cable.close()

    def _note(self, data: bytes) -> None:
        try:
            frame = unpack(data, self._key)
            if frame.kind is FrameKind.REFUSED:
                number, reason = unpack_refusal(frame.payload)
                if number in (0, self._nonce, self.session):
                    self.refusals.append(reason)
            elif frame.kind is FrameKind.WELCOME:
                nonce, description = unpack_welcome(frame.payload)
                if nonce == self._nonce:
                    self.session, self.description = frame.session, description
            elif frame.kind is FrameKind.SENSORS and frame.session == self.session:
                sensors = unpack_sensors(frame.payload, len(self._hello.joints))
                self.heard.append(Heard(self.now, frame.sequence, frame.stamp, sensors))
        except WireError as error:
            self.refusals.append(f"a frame that is none: {error}")
