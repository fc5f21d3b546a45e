"""The supervisor: what may go on. Below everything else, every servo cycle; no tree can switch it off."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import get_args

import numpy as np

from humanoid_bt.control.contact_rule import ContactRule
from humanoid_bt.core.clock import SERVO_PERIOD, cycles
from humanoid_bt.core.kept import Kept
from humanoid_bt.core.messages import (
    HEIGHT_OFFSET,
    MOST_PRESS,
    RESOURCES,
    SIDES,
    WORKSPACE,
    ArmTarget,
    Array,
    BaseTarget,
    Command,
    Estimate,
    GazeTarget,
    HandTarget,
    Mode,
    PalmAxis,
    Pause,
    Pointing,
    PostureTarget,
    Target,
)
from humanoid_bt.core.texts import one_line, shortened
from humanoid_bt.robot.arms import Arms, joints_fault, speed_fault
from humanoid_bt.robot.config import ContactConfig, FallConfig

DECISION_TIMEOUT = 0.100
"""Silence of decision [s] after which the robot goes to a protective stop."""

_SILENT = f"decision silent for more than {DECISION_TIMEOUT * 1000:.0f} ms"

NO_SOLUTION_TIMEOUT = 0.200
"""Time without a new valid setpoint [s] after which the robot goes to a protective stop."""

SENSOR_FAILED = "a sensor failed: "
"""What the reason of a stop begins with whose cause is a sensor."""

_MOST = 1000  # stops, and refusals, that are kept
_RUN, _DAMP = Mode.RUN, Mode.DAMP  # reading a member from its class costs more than comparing it
_COMMANDED = (_RUN, Mode.PAUSED)  # decision is heard, and nothing stops the robot
_BY_ITSELF = (*_COMMANDED, Mode.PROTECTIVE_STOP)  # what goes over into the other ones without a reset

_UNIT = 1e-3  # of a length from 1, of directions and quaternions

_TARGET_TYPES: dict[str, type | tuple[type, ...]] = {
    "base": BaseTarget,
    "left_hand": (HandTarget, ArmTarget),
    "right_hand": (HandTarget, ArmTarget),
    "gaze": GazeTarget,
    "posture": PostureTarget,
}


@dataclass(frozen=True)
class Stop:
    """A stop that the supervisor ordered.

    Attributes:
        time: engine time [s].
        mode: the kind of stop.
        reason: why.
        source: who asked or what caused it.
        resources: resource -> path of the node of the command in force then.
    """

    time: float
    mode: Mode
    reason: str
    source: str
    resources: Mapping[str, str]


class Supervisor:
    """Decides in every servo cycle whether targets are followed, held or let go.

    Args:
        fall: when the robot counts as falling.
        arms: joints that can be commanded by name.
        contact: what it does when something touches it.

    Attributes:
        mode: what is allowed now.
        reason, source: why and by whom, "" in mode RUN.
        command: the last accepted command.
        cycle: the servo cycle that runs; set it in one in which there is nothing new to look at.
        touch: what follows when something touches the robot.
        stops: the stops so far; of very many the first and the latest.
        rejected: what was refused so far, as text: commands, and setpoints that the body could not plan; as of stops.
    """

    def __init__(self, fall: FallConfig, arms: Arms | None = None, contact: ContactConfig | None = None) -> None:
        self._fall, self._arms = fall, arms or {}
        self.touch = ContactRule(contact or ContactConfig())
        self._least_upright = math.cos(fall.tilt)
        self._decision_timeout = cycles(DECISION_TIMEOUT)
        self._no_solution_timeout = cycles(NO_SOLUTION_TIMEOUT)
        self.reset_run(1.0)

    def reset_run(self, home_height: float) -> None:
        """Start a run; ``home_height`` is the height of the base when standing [m]."""
        self._home_height = home_height
        self.mode, self.reason, self.source = _RUN, "", ""
        self.command: Command | None = None
        self.stops: Kept[Stop] = Kept(_MOST)
        self.rejected: Kept[str] = Kept(_MOST)
        self._last_sequence: int | None = None
        self._heard_cycle: int | None = None  # when decision was last heard; None before its first command
        self._refused = ""  # why what it says since then is no command
        self._forgiven = False  # this silence, because control itself was held up
        self._faulty_cycles = 0
        self._falling = ""
        self._looked_at: Estimate | None = None
        self._estop: tuple[str, str] | None = None
        self._requested: tuple[str, str] | None = None
        self.cycle = 0
        self.touch.reset()

    # ---- requests -------------------------------------------------------------------------------------------------

    def raise_estop(self, source: str, reason: str) -> None:
        """Raise the emergency stop; it stays until :meth:`reset`. Its reason is told in one line."""
        if self._estop is None:
            self._estop = (one_line(shortened(source)), one_line(shortened(reason)))

    def request_stop(self, source: str, reason: str) -> None:
        """Ask for a protective stop until the end of the run: what commanded the robot has failed."""
        self._requested = self._requested or (shortened(source), shortened(reason))

    def forgive_silence(self) -> None:
        """Let decision's silence count from now on: control itself was held up, and could not hear.

        Once per silence, and not when the robot is stopped already: nothing starts it but a fresh command.
        """
        if self._heard_cycle is not None and not self._forgiven and self.mode in _COMMANDED:
            self._heard_cycle = self.cycle
            self._forgiven = True

    def reset(self) -> str:
        """Clear a latched stop. Return "" when done, else why it is refused.

        What was commanded before is forgotten: the robot stands until a fresh command comes. An emergency stop that
        no servo cycle has seen yet is not cleared.
        """
        if self._falling:
            return self._falling
        if self.mode in (Mode.EMERGENCY_STOP, _DAMP):
            self._estop = None
            self.touch.forgive()
            self.mode, self.reason, self.source = _RUN, "", ""
            self.command = None
        return ""

    def submit(self, command: Command) -> bool:
        """Take a command if it is intact; return whether it is now in force."""
        late = ""
        try:
            fault = late = self._lateness(command)
            fault = fault or self._fault(command)
        except (AttributeError, TypeError, ValueError) as error:  # whatever decision sends, the servo goes on
            fault = f"malformed: {error}"
        if fault:
            self.rejected.append(f"command {getattr(command, 'sequence', '?')}: {fault}")
            self._refused = self._refused if late else shortened(fault)
            return False
        self.command = command
        self._last_sequence = command.sequence
        self._heard_cycle, self._refused = self.cycle, ""
        self._forgiven = False
        return True

    def _lateness(self, command: Command) -> str:
        """Return why a command is not the next one, "" if it is."""
        if self._last_sequence is not None and command.sequence <= self._last_sequence:
            return f"out of order after {self._last_sequence}"
        now = self.cycle * SERVO_PERIOD
        if not math.isfinite(command.stamp) or abs(command.stamp - now) > DECISION_TIMEOUT:
            return f"stamped {command.stamp:.3f} s at {now:.3f} s"
        return ""

    def _fault(self, command: Command) -> str:
        if command.pause is not None and not isinstance(command.pause, Pause):
            return f"malformed: {command.pause!r} is no pause"
        for resource, target in command.targets.items():
            if resource not in RESOURCES or not isinstance(target, _TARGET_TYPES[resource]):
                return f"{resource!r} cannot take a {type(target).__name__}"
            if isinstance(target, ArmTarget):
                fault = self._joints_fault(resource, target)
            else:
                fault = _target_fault(target) or _manner_fault(resource, target, command)
            if fault:
                return f"the target of {resource!r} {fault} (from {command.sources.get(resource, 'unknown')!r})"
        return ""

    def _joints_fault(self, resource: str, target: ArmTarget) -> str:
        side = next(side for side in SIDES if resource == f"{side}_hand")
        return joints_fault(self._arms, side, target.joints) or speed_fault(target.speed)

    # ---- every servo cycle ----------------------------------------------------------------------------------------

    def feel(self, forces: Mapping[str, Array], estimate: Estimate) -> None:
        """Take what pushes arms and torso, group of links -> force, shape (3,) [N], when there is news of it."""
        self.touch.look(self.cycle, forces, self.command, estimate.qpos)
        if self.touch.blocked:
            self.raise_estop("supervisor", self.touch.blocked)

    def check(
        self,
        cycle: int,
        estimate: Estimate,
        setpoint_fault: str = "",
        sensor_fault: str = "",
        plant_fault: str = "",
    ) -> None:
        """Look at everything in the order of precedence and set the mode.

        Args:
            cycle: the servo cycle that begins.
            estimate: what is believed of the robot.
            setpoint_fault: why there is no new valid setpoint, else "".
            sensor_fault: which sensor has failed, else "".
            plant_fault: why the plant cannot be relied on, else "".
        """
        self.cycle = cycle
        if setpoint_fault and not self._faulty_cycles:
            self.rejected.append(f"setpoint at {cycle * SERVO_PERIOD:.3f} s: {setpoint_fault}")
        self._faulty_cycles = self._faulty_cycles + 1 if setpoint_fault else 0
        if estimate is not self._looked_at:  # a new one now and then
            self._looked_at, self._falling = estimate, self._why_falling(estimate)
        if self._falling:
            self._stop(_DAMP, self._falling, "supervisor")
        elif self._estop is not None:
            self._stop(Mode.EMERGENCY_STOP, self._estop[1], self._estop[0])
        elif self.mode in _BY_ITSELF:
            plant = (plant_fault, "supervisor") if plant_fault else None
            cause = plant or self._protective_cause(setpoint_fault, sensor_fault)
            if cause:
                self._stop(Mode.PROTECTIVE_STOP, *cause)
            elif self.command is not None and (pause := self.command.pause) is not None:
                self.mode, self.reason, self.source = Mode.PAUSED, pause.reason, pause.source
            elif self.mode is not _RUN:
                self.mode, self.reason, self.source = _RUN, "", ""

    def next_look(self, setpoint_fault: str) -> int:
        """Return the servo cycle in which to look again if nothing changes before of what :meth:`check` is told.

        Args:
            setpoint_fault: why there is no new valid setpoint since it looked, else "".
        """
        if setpoint_fault or self._faulty_cycles:
            return self.cycle + 1
        if self._heard_cycle is None or self._is_silent:
            return sys.maxsize
        return self._heard_cycle + self._decision_timeout + 1

    @property
    def _is_silent(self) -> bool:
        """Whether decision has been silent for too long."""
        return self._heard_cycle is not None and self.cycle - self._heard_cycle > self._decision_timeout

    def _protective_cause(self, setpoint_fault: str, sensor_fault: str) -> tuple[str, str] | None:
        """Return (reason, source) of what keeps the robot from being commanded, if anything does."""
        if sensor_fault:
            return f"{SENSOR_FAILED}{sensor_fault}", "supervisor"
        if self._requested is not None:
            source, reason = self._requested
            return reason, source
        if self._is_silent:
            return self._silence(), "supervisor"
        if self.touch.held:
            return self.touch.held, "supervisor"
        if self._faulty_cycles > self._no_solution_timeout:
            return f"{setpoint_fault} for more than {NO_SOLUTION_TIMEOUT * 1000:.0f} ms", "supervisor"
        return None

    def _silence(self) -> str:
        """Say that decision is silent, or that what it commands is refused, and why that was as the robot stopped."""
        if self.mode is Mode.PROTECTIVE_STOP and self.reason.startswith(_SILENT):
            return self.reason
        return _SILENT + (f": what it commands is refused: {self._refused}" if self._refused else "")

    def _stop(self, mode: Mode, reason: str, source: str) -> None:
        if self.mode is _DAMP or (mode, reason, source) == (self.mode, self.reason, self.source):
            return
        self.mode, self.reason, self.source = mode, reason, source
        resources = dict(self.command.sources) if self.command else {}
        self.stops.append(Stop(self.cycle * SERVO_PERIOD, mode, reason, source, resources))

    def _why_falling(self, estimate: Estimate) -> str:
        """Return why the robot cannot be kept on its feet, "" when it can."""
        qpos, qvel = estimate.qpos, estimate.qvel
        if not math.isfinite(qpos.dot(qpos) + qvel.dot(qvel)):
            return "the estimated state is not finite"
        height, x, y = qpos.item(2), qpos.item(4), qpos.item(5)
        if height < self._fall.height * self._home_height:
            return "the robot is falling: its base is low"
        upright = 1 - 2 * (x * x + y * y)  # cosine of the base's tilt
        return "the robot is falling: its base is tilted" if upright < self._least_upright else ""

    @property
    def targets(self) -> Mapping[str, Target]:
        """The targets in force: none unless the mode is RUN, and none of the hand of an arm that yields."""
        if self.mode is not _RUN or self.command is None:
            return {}
        targets, yielding = self.command.targets, self.touch.yielding
        if not yielding:
            return targets
        let_go = {f"{side}_hand" for side in yielding}
        return {resource: target for resource, target in targets.items() if resource not in let_go}

    @property
    def hold(self) -> bool:
        """Whether the body shall stop and stay."""
        return self.mode is not _RUN


def reset_text(source: str, refusal: str) -> str:
    """Return what came of a reset, for the event log."""
    return f"reset by {source}: " + (f"refused: {refusal}" if refusal else "done")


def _target_fault(target: BaseTarget | HandTarget | GazeTarget | PostureTarget) -> str:
    match target:
        case BaseTarget(position=position, heading=heading):
            values, shape, number, limit = position, (2,), heading, WORKSPACE
        case HandTarget(position=position, press=press):
            if not 0 <= press <= MOST_PRESS:
                return f"presses with {press:g} N"
            values, shape, number, limit = position, (3,), 0.0, WORKSPACE
        case GazeTarget(point=position):
            values, shape, number, limit = position, (3,), 0.0, WORKSPACE
        case PostureTarget(height=height):
            values, shape, number, limit = np.zeros(0), (0,), height, HEIGHT_OFFSET
    if not isinstance(values, np.ndarray) or values.shape != shape or values.dtype.kind not in "fi":
        return "is malformed"
    numbers = [*values.tolist(), number]
    for value in numbers:
        if not -limit <= value <= limit:
            return "is out of range" if all(map(math.isfinite, numbers)) else "is not finite"
    return ""


def _manner_fault(resource: str, target: Target, command: Command) -> str:
    """Return what is wrong with how a hand is to move, besides where to."""
    if not isinstance(target, HandTarget):
        return ""
    if target.orientation is not None and (fault := _orientation_fault(target.orientation)):
        return fault
    if target.relative:
        leader = "left_hand" if resource == "right_hand" else "right_hand"
        leads = command.targets.get(leader)
        if not isinstance(leads, HandTarget) or leads.relative:
            return f"is relative to {leader!r}, for which there is no position in the world"
    return speed_fault(target.speed)


def _orientation_fault(orientation: Array | Pointing) -> str:
    if isinstance(orientation, Pointing):
        values, size, what = orientation.direction, 3, "a direction"
        if orientation.axis not in get_args(PalmAxis):
            return f"points along {orientation.axis!r}, which is no axis of a palm"
    else:
        values, size, what = orientation, 4, "an orientation"
    if not isinstance(values, np.ndarray) or values.shape != (size,) or values.dtype.kind not in "fi":
        return f"has {what} that is malformed"
    length = math.sqrt(values @ values)
    if not math.isfinite(length):
        return f"has {what} that is not finite"
    return f"has {what} of length {length:.3g} and not 1" if abs(length - 1) > _UNIT else ""
