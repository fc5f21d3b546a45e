"""Every servo cycle as numbers, for whoever reads along: control writes them into tables, and waits for nobody.

One table has a row for each servo cycle, another one a row for each plan of the whole body.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from humanoid_bt.core.arrays import numbers
from humanoid_bt.core.clock import DECISION_PERIOD, ESTIMATE_PERIOD, cycles
from humanoid_bt.core.messages import SIDES, Array, Command, Estimate, Gait, Mode, Reading
from humanoid_bt.link.table import LocalTable, TableWriter

if TYPE_CHECKING:  # who reads a recording needs no simulator
    from humanoid_bt.control.body.body import Body
    from humanoid_bt.control.servo import Servo
    from humanoid_bt.control.supervisor import Supervisor

Table = TableWriter | LocalTable
MODES, GAITS = tuple(Mode), tuple(Gait)
NONE = -1.0
"""Stands for the error of a hand that nothing commands, and for the command before the first."""

_CYCLE, _MODE, _COMMAND = range(3)  # of a row, the numbers of what was decided
_DECIDED, _POSE, _TWIST = 3, 3 + 4, 3 + 3  # so many; then of the base position and quaternion, velocity and rate
_HEAD = _DECIDED + _POSE + _TWIST + len(SIDES)  # of a row, what the plant does not measure into it
_LATE = 4.0  # s that a reader may be late before it misses something


@dataclass(frozen=True)
class Column:
    """Numbers that belong together.

    Attributes:
        name: what they are.
        unit: theirs, "" for none.
        resolution: as much of a number as is worth keeping, in that unit.
        labels: of each number.
    """

    name: str
    unit: str
    resolution: float
    labels: tuple[str, ...]


class Row:
    """Columns side by side, as float64.

    Attributes:
        columns: in their order.
        width: how many numbers a row has.
        resolution: of each, shape (width,).
    """

    def __init__(self, *columns: Column) -> None:
        self.columns = columns
        self.width = sum(len(column.labels) for column in columns)
        self.resolution: Array = np.concatenate([[c.resolution] * len(c.labels) for c in columns])

    def only(self, columns: Sequence[str] | None, labels: Sequence[str] | None = None) -> Row:
        """Return a row of some of the columns, and of these only the numbers with some labels; itself for all."""
        if columns is None and labels is None:
            return self
        chosen = [column for column in self.columns if columns is None or column.name in columns]
        if labels is None:
            return Row(*chosen)
        return Row(*(replace(of, labels=tuple(label for label in of.labels if label in labels)) for of in chosen))

    def places(self, part: Row) -> list[int]:
        """Return where the numbers of a part of it are."""
        wanted = {(column.name, label) for column in part.columns for label in column.labels}
        known = [(column.name, label) for column in self.columns for label in column.labels]
        return [place for place, number in enumerate(known) if number in wanted]

    def split(self, rows: Array) -> dict[str, Array]:
        """Return views of the columns of rows, shape (..., width), by name."""
        ends = np.cumsum([len(column.labels) for column in self.columns])[:-1]
        return dict(zip([column.name for column in self.columns], np.split(rows, ends, axis=-1), strict=True))


@dataclass(frozen=True)
class Layout:
    """What is written of a robot.

    Attributes:
        joints: the robot's joints.
        plan: once per plan of the whole body.
        cycle: once per servo cycle.
    """

    joints: tuple[str, ...]
    plan: Row
    cycle: Row

    @classmethod
    def of(cls, joints: tuple[str, ...]) -> Layout:
        """Return the layout for a robot with these joints."""
        xyz = ("x", "y", "z")
        plan = Row(
            Column("plan", "", 1.0, ("cycle", "gait", "solved", "stiff")),
            Column("hand_error", "m", 1e-5, SIDES),
            Column("com_error", "m", 1e-5, xyz),
            Column("setpoint", "rad", 1e-5, joints),
            Column("setpoint_velocity", "rad/s", 1e-4, joints),
            Column("feedforward", "Nm", 1e-3, joints),
            Column("limited", "", 1.0, joints),
        )
        cycle = Row(
            Column("servo", "", 1.0, ("cycle", "mode", "command")),
            Column("base_position", "m", 1e-5, xyz),
            Column("base_quaternion", "", 1e-5, ("w", *xyz)),
            Column("base_velocity", "m/s", 1e-4, xyz),
            Column("base_rate", "rad/s", 1e-3, xyz),
            Column("foot_force", "N", 1e-1, SIDES),
            Column("foot_sensor", "N", 1e-1, SIDES),
            Column("orientation", "", 2e-4, ("w", *xyz)),
            Column("position", "rad", 2e-5, joints),
            Column("accelerometer", "m/s^2", 2e-2, xyz),
            Column("gyro", "rad/s", 1e-3, xyz),
            Column("velocity", "rad/s", 5e-3, joints),
            Column("torque", "Nm", 1e-1, joints),
        )
        return cls(joints, plan, cycle)

    def create(self, plans: Path, servo_cycles: Path) -> None:
        """Make the tables as files, for a reader that may be 4 s late.

        Raises:
            LinkError: a file cannot be made.
        """
        TableWriter.create(plans, self.plan.width, cycles(_LATE) // cycles(ESTIMATE_PERIOD)).close()
        TableWriter.create(servo_cycles, self.cycle.width, cycles(_LATE)).close()

    def local(self) -> tuple[LocalTable, LocalTable]:
        """Return tables of plans and of servo cycles for a reader that takes its turn once a tick."""
        most = 2 * cycles(DECISION_PERIOD)
        return LocalTable(self.plan.width, most), LocalTable(self.cycle.width, most)


class CycleLog:
    """Control's end of the tables.

    It must cost a servo cycle next to nothing: what was decided is noted at once, while it is in the processor's cache;
    the plant measures right into the row; a plan is copied part by part in the cycles after it, for code that runs in
    one cycle of ten takes four times as long as in a loop; as bytes where arrays would take longer to begin than to
    copy.

    Args:
        plans, servo_cycles: the tables, as :class:`Layout` makes them.
        layout: of the robot.

    Attributes:
        measured: where the plant is to measure what comes of the cycle; it stays until the row's turn comes again.
    """

    def __init__(self, plans: Table, servo_cycles: Table, layout: Layout) -> None:
        self._plans, self._cycles = plans, servo_cycles
        joints = len(layout.joints)
        widths = 4 + len(SIDES), 3, 3 * joints
        parts = [np.split(row, np.cumsum(widths)) for row in plans.rows]
        self._plan_rows = [(numbers(plan), _bytes(com), _bytes(of), limited) for plan, com, of, limited in parts]
        self._rows = [(numbers(row[:_HEAD]), Reading(joints, row[_HEAD:])) for row in servo_cycles.rows]
        self._count = len(self._rows)
        self._head = numbers(np.zeros(_HEAD))  # of the row to come
        believed = self._head[_DECIDED:]
        self._pose, self._twist = believed[:_POSE], believed[_POSE : _POSE + _TWIST]
        self._force = believed[_POSE + _TWIST :]
        self._estimate: Estimate | None = None  # that these are of
        self._clamped = [bool(limited.any()) for *_, limited in parts]
        self._commands = -1  # of the servo, as far as they were seen; -1 before the first, which is no plan
        self._copying: Iterator[None] = iter(())  # of the last plan, what is left of it
        self._body: Body | None = None  # that made it
        self._com_error = _bytes(np.zeros(3))  # of that body
        self._mode = MODES[0]
        self._gait, self._gait_number = GAITS[0], 0
        self._command: Command | None = None
        self._head[_COMMAND] = NONE
        self._row_head, self.measured = self._rows[0]

    def begin(self, cycle: int, supervisor: Supervisor, servo: Servo, body: Body) -> None:
        """Take what was decided in a servo cycle, as soon as it is, before anything is planned or driven.

        Args:
            cycle: servo cycles so far, this one included.
            supervisor: as it is in it.
            servo, body: as the cycle before left them.
        """
        if servo.commands != self._commands:
            if self._commands >= 0:
                self._copying = self._copy(cycle - 1, self._mode, servo, body)
            self._commands = servo.commands
        else:
            next(self._copying, None)
        head = self._head
        head[_CYCLE] = cycle
        if supervisor.mode is not self._mode:
            self._mode = supervisor.mode
            head[_MODE] = MODES.index(self._mode)
        if supervisor.command is not self._command:
            self._command = supervisor.command
            head[_COMMAND] = NONE if self._command is None else self._command.sequence
        self._row_head, self.measured = self._rows[self._cycles.count % self._count]

    def end(self, estimate: Estimate) -> None:
        """Let readers see the cycle, with what is believed of base and feet after it."""
        if estimate is not self._estimate:  # a new one now and then, in the same arrays
            if self._estimate is None or estimate.qpos is not self._estimate.qpos:
                qpos, qvel = numbers(estimate.qpos), numbers(estimate.qvel)
                self._sources = qpos[:_POSE], qvel[:_TWIST], numbers(estimate.foot_force)
            self._estimate = estimate
            self._pose[:], self._twist[:], self._force[:] = self._sources
        self._row_head[:] = self._head
        self._cycles.publish()

    def end_plan(self) -> None:
        """Copy what is left of a plan, before there is another one."""
        for _ in self._copying:
            pass

    def _copy(self, cycle: int, mode: Mode, servo: Servo, body: Body) -> Iterator[None]:
        """Copy a plan into the next row, in parts that take about as long as each other.

        Args:
            cycle, mode: in which it was made.
            servo: it follows it.
            body: it has made it.
        """
        row = self._plans.count % len(self._plan_rows)
        plan, com_error, setpoint, limited = self._plan_rows[row]
        setpoint[:] = servo.setpoint.tobytes()
        plan[0], plan[3] = cycle, mode is not Mode.DAMP
        yield
        for place, side in enumerate(SIDES, 4):
            error = body.hand_error(side)
            plan[place] = NONE if error is None else error
            yield
        if body is not self._body:
            self._body, self._com_error = body, _bytes(body.com_error)
        com_error[:] = self._com_error
        if servo.clamped or self._clamped[row]:  # else they are zero, as they are to be
            limited[:] = servo.limited
            self._clamped[row] = servo.clamped
        gait = body.gait
        if gait is not self._gait:
            self._gait, self._gait_number = gait, GAITS.index(gait)
        plan[1], plan[2] = self._gait_number, not body.fault
        self._plans.publish()


def _bytes(array: Array) -> memoryview[int]:
    """Return the bytes of an array's own numbers."""
    return array.data.cast("B")
