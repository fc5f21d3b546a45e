"""``check_plant``: a plant behind a cable tried against what control asks of it, in one call."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from humanoid_bt.cable.address import Address, read_address, read_key
from humanoid_bt.cable.cables import Cable, UdpCable
from humanoid_bt.cable.frames import FrameKind
from humanoid_bt.cable.payloads import Description, Hello, PlantState, pack_command
from humanoid_bt.cable.safe_state import LET_GO
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.clock import SERVO_PERIOD, cycles
from humanoid_bt.core.messages import Array, Reading
from humanoid_bt.realtime.schedule import Schedule
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.testing.conformance import Conformance, RuleOutcome
from humanoid_bt.testing.plant_probe import Probe

_DRIVE = 1.0  # s for which frames are counted
_FEW = 0.9  # share of the frames that must come
_GAP = 0.005  # s between two of them, of 99 in 100
_LATE = 0.025  # s beside its time that the watchdog may take, cable and a busy machine included
_EARLY = 0.003  # s
_TORQUE = 2.0  # times what a weak drive gives, that is asked of it
_SLACK, _NOISE = 1.05, 1.0  # times that, and Nm besides, that its sensor may say
_PULL = 0.03  # s for which it is asked


def check_plant(address: str, robot: Path, key: Path | None = None) -> Conformance:
    """Try a plant that is served: whom it takes for its driver, order, timing, limits, watchdog, restart.

    The robot is told to stay where it is found, for a few seconds, and is let go several times: let it hang, or hold
    it. For 30 ms a weak drive is asked for twice the torque that it has.

    Args:
        address: where it is: ``udp://HOST:PORT``.
        robot: the ``robot.yaml``.
        key: file with the key that the plant has too.

    Raises:
        UserError: the robot has mistakes, or address and key do not go together.
    """
    where = read_address(address)
    secret = read_key(where, key)
    schedule = Schedule(SERVO_PERIOD, spin=False)

    def wait() -> float:
        schedule.wait()
        return time.monotonic()

    return check_cabled_plant(robot, where, lambda: UdpCable(peer=where), wait, secret)


def check_cabled_plant(
    robot: Path,
    address: Address,
    cable: Callable[[], Cable],
    wait: Callable[[], float],
    key: bytes | None = None,
) -> Conformance:
    """Try a plant on any cable and any clock, as on a simulated one.

    Args:
        robot: the ``robot.yaml``.
        address: where the plant is.
        cable: makes a driver's end of a cable to it.
        wait: lets a servo period pass, and returns the time [s].
        key: with which frames are sealed.
    """
    model, _ = load_robot(robot)
    trial = _Trial(model, address, cable, wait, key)
    try:
        return Conformance(f"the plant at {address}", tuple(trial.rules()))
    finally:
        trial.close()


class _Trial:
    def __init__(
        self,
        robot: RobotModel,
        address: Address,
        cable: Callable[[], Cable],
        wait: Callable[[], float],
        key: bytes | None,
    ) -> None:
        self._robot, self._address, self._cable, self._wait, self._key = robot, address, cable, wait, key
        self._hello = Hello(robot.config.name, tuple(robot.joint_names))
        self._probes: list[Probe] = []

    def close(self) -> None:
        for probe in self._probes:
            if probe.session:
                probe.leave()
            probe.close()

    def _probe(self, hello: Hello) -> Probe:
        probe = Probe(self._cable(), self._address, self._robot, hello, key=self._key, wait=self._wait)
        self._probes.append(probe)
        return probe

    def rules(self) -> Iterator[RuleOutcome]:
        """Yield what came of every rule; none but the first two of a plant that welcomes nobody."""
        yield self._refuses()
        probe = self._probe(self._hello)
        welcome = probe.say_hello()
        about = probe.description
        yield RuleOutcome("welcomes", welcome, _described(about) if welcome else _answer(probe))
        if not welcome or about is None:
            return
        yield self._follows(probe)
        yield self._timing(probe)
        yield self._malformed(probe)
        yield self._limits(probe)
        yield self._one_driver(probe)
        yield self._watchdog(probe, about)
        yield self._order(probe)
        yield self._lets_go(probe)
        yield self._restart(about)

    def _refuses(self) -> RuleOutcome:
        answers, heard = [], False
        for hello in (
            replace(self._hello, robot=f"{self._hello.robot}?"),
            replace(self._hello, joints=self._hello.joints[1:]),
            replace(self._hello, joints=(*self._hello.joints[:-1], "tail")),
        ):
            probe = self._probe(hello)
            probe.say_hello(1.0)
            answers.append(not probe.session and bool(probe.refusals))
            heard = heard or bool(probe.session or probe.refusals)
        if not heard:
            return RuleOutcome("refuses", False, f"nobody answers at {self._address}: is the driver running there?")
        names = "another robot", "a joint less", "a joint of another name"
        taken = [name for name, refused in zip(names, answers, strict=True) if not refused]
        shown = f"does not refuse {' and '.join(taken)}" if taken else f"{', '.join(names)}, with a reason"
        return RuleOutcome("refuses", not taken, shown)

    def _follows(self, probe: Probe) -> RuleOutcome:
        probe.drive(0.3)
        last = probe.last.sensors
        behind = probe.sequence - last.heard
        good = last.state is PlantState.FOLLOWS and behind < 100
        return RuleOutcome(
            "follows", good, f"{last.state.name.lower()}; heard command {last.heard} of {probe.sequence}"
        )

    def _timing(self, probe: Probe) -> RuleOutcome:
        begin = len(probe.heard)
        probe.drive(_DRIVE)
        heard = probe.heard[begin:]
        sent = cycles(_DRIVE)
        gap = float(np.quantile(np.diff([one.at for one in heard]), 0.99)) if len(heard) > 1 else _DRIVE
        counted = heard[-1].sequence - heard[0].sequence if heard else 0
        drift = abs(heard[-1].stamp - heard[0].stamp - counted * SERVO_PERIOD) if heard else _DRIVE
        good = len(heard) >= _FEW * sent and gap <= _GAP and drift < SERVO_PERIOD * 10
        shown = f"{len(heard)} frames in {_DRIVE:g} s, 99 of 100 within {gap * 1e3:.1f} ms of the one before"
        return RuleOutcome("timing", good, shown)

    def _malformed(self, probe: Probe) -> RuleOutcome:
        still, joints = probe.still(), len(self._hello.joints)
        payload = pack_command(still)
        bad = [
            payload[:-8],
            payload + bytes(40),
            pack_command(replace(still, position=np.full(joints, np.nan))),
            pack_command(replace(still, stiffness=-still.stiffness)),
        ]
        wrong: set[int] = set()
        rng = np.random.default_rng(0)
        begin = len(probe.heard)
        for index in range(100):
            probe.send_bytes(rng.bytes(int(rng.integers(1, 1500))))
            probe.sequence += 1
            wrong.add(probe.sequence)
            probe.send(FrameKind.COMMAND, probe.session, bad[index % len(bad)], probe.sequence)
            probe.listen()
            probe.drive(SERVO_PERIOD)
        heard = [one.sensors for one in probe.heard[begin:]]
        taken = wrong & {one.heard for one in heard}
        good = bool(heard) and not taken and heard[-1].state is PlantState.FOLLOWS
        shown = f"{len(taken)} of {len(wrong)} malformed commands were followed"
        return RuleOutcome("malformed", good, f"{shown}; {heard[-1].state.name.lower() if heard else 'silent'} then")

    def _limits(self, probe: Probe) -> RuleOutcome:
        limits = self._robot.torque_limit
        weak = weak_drive(limits)
        torque = np.zeros_like(limits)
        torque[weak] = _TORQUE * limits[weak]
        begin = len(probe.heard)
        probe.drive(_PULL, changes={"torque": torque})
        probe.drive(0.1)
        largest = max((abs(self._torques(one.sensors.values)[weak]) for one in probe.heard[begin:]), default=0.0)
        good = largest <= limits[weak] * _SLACK + _NOISE
        name = self._hello.joints[weak]
        shown = f"{name} gives {largest:.1f} Nm of {limits[weak]:g} when {torque[weak]:g} are asked for"
        return RuleOutcome("limits", bool(good), shown)

    def _torques(self, values: Array) -> Array:
        return Reading(len(self._hello.joints), values).joint_torque

    def _one_driver(self, probe: Probe) -> RuleOutcome:
        other = self._probe(self._hello)
        for _ in range(200):
            probe.drive(SERVO_PERIOD)
            if not other.refusals:
                other.say_hello(SERVO_PERIOD)
        good = bool(other.refusals) and not other.session and probe.last.sensors.state is PlantState.FOLLOWS
        return RuleOutcome("one driver", good, f"a second one hears: {_answer(other)}")

    def _watchdog(self, probe: Probe, about: Description) -> RuleOutcome:
        probe.drive(0.1)
        begin, first = probe.now, len(probe.heard)
        probe.rest(about.watchdog + _LATE)
        safe = PlantState.HOLDS if about.safe == "hold" else PlantState.DAMPS
        took = next((one.at - begin for one in probe.heard[first:] if one.sensors.state is safe), None)
        probe.drive(0.05)  # less than 100 ms after the last command: it is followed again
        again = probe.last.sensors.state is PlantState.FOLLOWS
        good = took is not None and about.watchdog - _EARLY <= took <= about.watchdog + _LATE and again
        shown = "never in its safe state" if took is None else f"{safe.name.lower()} after {took * 1e3:.0f} ms"
        return RuleOutcome(
            "watchdog", good, f"{shown} without a command, {'follows' if again else 'does not follow'} then"
        )

    def _order(self, probe: Probe) -> RuleOutcome:
        """Send nothing but what was sent already: it does not count, not even for the watchdog."""
        probe.drive(0.1)
        begin, newest = len(probe.heard), probe.sequence
        for back in range(60):
            probe.command(newest - back, probe.still())
            probe.listen()
        heard = [one.sensors for one in probe.heard[begin:]]
        good = bool(heard) and heard[-1].heard == newest and heard[-1].state is not PlantState.FOLLOWS
        state = heard[-1].state.name.lower() if heard else "silent"
        probe.drive(0.05)
        return RuleOutcome("order", good, f"{state} after 60 ms of commands that it had heard before")

    def _lets_go(self, probe: Probe) -> RuleOutcome:
        probe.drive(0.1)
        probe.rest(LET_GO + 0.1)
        probe.refusals.clear()
        begin = len(probe.heard)
        probe.drive(0.1)
        follows = any(one.sensors.state is PlantState.FOLLOWS for one in probe.heard[begin:])
        good = not follows and bool(probe.refusals)
        return RuleOutcome(
            "lets go", good, f"a driver that was silent for {LET_GO * 1e3:.0f} ms hears: {_answer(probe)}"
        )

    def _restart(self, about: Description) -> RuleOutcome:
        again = self._probe(self._hello)
        if not again.say_hello():
            return RuleOutcome("restart", False, _answer(again))
        again.drive(0.2)
        followed = again.last.sensors.state is PlantState.FOLLOWS
        same = again.description == about
        again.leave()
        again.session = 0
        return RuleOutcome(
            "restart", followed and same, "a new driver is welcome, and followed" if followed else "stays"
        )


def weak_drive(limits: Array) -> int:
    """Return the weakest drive of which the noise of its sensor does not hide that it gives twice its torque.

    Args:
        limits: torques of all drives, shape (nj,) [Nm].
    """
    telling = (_TORQUE - _SLACK) * limits > 2 * _NOISE
    return int(np.argmin(np.where(telling, limits, np.inf)) if telling.any() else np.argmax(limits))


def _answer(probe: Probe) -> str:
    if probe.refusals:
        return probe.refusals[-1]
    return "welcome, but no sensors" if probe.session else "nothing"


def _described(about: Description | None) -> str:
    if about is None:
        return "nothing"
    kind = "simulated" if about.simulated else "real"
    return f"{about.robot}, {kind}, {len(about.joints)} joints; {about.safe} after {about.watchdog * 1e3:.0f} ms"
