"""One fault at one random moment, and many of them.

python -m tests.safety.trials --repetitions 100
"""

from __future__ import annotations

import argparse
import functools
import math
import multiprocessing
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from humanoid_bt.core.clock import cycles
from humanoid_bt.core.messages import Mode
from tests.safety.activities import ACTIVITIES, STANDING, WALKING
from tests.safety.machine import Machine, Scripted, seconds
from tests.safety.rows import FOOT_ROWS, POLICY_ROWS, ROWS, SETTLE, Row

AFTERWARD = cycles(0.3)
"""Servo cycles in which arms that were released get going before a stand counts."""

_ALL_ROWS = {**ROWS, **POLICY_ROWS, **FOOT_ROWS}
_UPRIGHT = 0.15  # rad of tilt, and...
_TALL = 0.9  # ...share of the base's height at the start: less is no stand


@dataclass(frozen=True)
class Outcome:
    """What happened.

    Attributes:
        row, activity, seed: of which trial.
        moment: engine time of the fault [s].
        modes: (time after the fault [s], mode) of every change of mode.
        standing: whether the robot stood at rest in the end.
        tilt: of the base, in the end [rad].
        height: of the base, in the end [m].
        drift: way of the base from the fault to the end [m].
        limp: whether the joints had no stiffness in the end.
        beyond: farthest that a joint was beyond its range at any time [rad].
        finite: whether the state was finite in the end.
    """

    row: str
    activity: str
    seed: int
    moment: float
    modes: tuple[tuple[float, Mode], ...]
    standing: bool
    tilt: float
    height: float
    drift: float
    limp: bool
    beyond: float
    finite: bool

    @property
    def mode_sequence(self) -> tuple[Mode, ...]:
        """The modes without their times."""
        return tuple(mode for _, mode in self.modes)

    @property
    def as_told(self) -> bool:
        """Whether the row's modes followed, and the robot stood, or lay limp, as the row says."""
        row, modes = _ALL_ROWS[self.row], self.mode_sequence
        if self.modes and self.modes[0][0] > row.within:
            return False
        stood, lies = self.standing and not self.limp, self.limp and not self.standing
        if row.may_fall and modes == (*row.modes, Mode.DAMP):
            return lies and self.finite
        return modes == row.modes and (stood if row.stands else lies) and self.finite


def shared_machine(robot: str = "humanoid") -> Machine:
    """Return the one robot of this name in this process."""
    return _machine(robot)


_machine = functools.cache(Machine)


def trial(row_name: str, activity: str, seed: int, robot: str = "humanoid") -> Outcome:
    """Let one fault happen at a random moment of an activity; the same arguments give the same outcome."""
    row, machine = _ALL_ROWS[row_name], shared_machine(robot)
    rng = np.random.default_rng([seed, list(ACTIVITIES).index(activity)])
    plan = ACTIVITIES[activity](rng)
    machine.reset()
    start_height = float(machine.state.base_position[2])
    if row.tree:
        machine.sees.see("target", plan.ball, plan.confidence)
        machine.follow_tree("fetch")
    else:
        machine.decision = Scripted(plan.targets)
    machine.run(int(rng.integers(cycles(plan.earliest), cycles(plan.latest))))
    begin, before = machine.cycle, machine.state
    start_height = float(machine.controller.supervisor._home_height)
    row.fault(machine, rng)
    machine.run(cycles(row.lasts))
    _come_to_rest(machine, row)
    state = machine.state
    _, x, y, _ = state.base_quaternion
    tilt = math.acos(min(1.0, max(-1.0, 1 - 2 * (x * x + y * y))))
    height = float(state.base_position[2])
    numbers = [state.joint_positions, state.joint_velocities, state.joint_torques, state.base_position]
    return Outcome(
        row=row_name,
        activity=activity,
        seed=seed,
        moment=seconds(begin),
        modes=tuple((seconds(cycle - begin), mode) for cycle, mode in machine.modes if cycle >= begin),
        standing=state.base_settled and tilt < _UPRIGHT and height > _TALL * start_height,
        tilt=tilt,
        height=height,
        drift=float(np.linalg.norm(state.base_position[:2] - before.base_position[:2])),
        limp=not machine.controller.servo.command.stiffness.any(),
        beyond=machine.beyond,
        finite=bool(np.isfinite(np.concatenate(numbers)).all()),
    )


def _come_to_rest(machine: Machine, row: Row) -> None:
    if not row.stands:
        return
    if row.releases:
        machine.release()
        machine.run(AFTERWARD)
    _stand(machine)
    if row.resets:
        machine.release()
        machine.supervisor.reset()
        machine.run(AFTERWARD)
        _stand(machine)


def _stand(machine: Machine) -> None:
    machine.run(SETTLE, until=lambda state: state.base_settled or state.mode is Mode.DAMP)


# ---- many -----------------------------------------------------------------------------------------------------------


def repetitions(row: Row, count: int, robot: str = "humanoid") -> Iterator[tuple[str, str, int, str]]:
    """Yield the arguments of ``count`` trials of a row: one half standing, one half walking."""
    for seed in range(count):
        activities = list(STANDING if seed % 2 else WALKING)
        yield row.name, activities[seed // 2 % len(activities)], seed, robot


def summary(row: Row, outcomes: list[Outcome]) -> str:
    """Return a row's line of the table."""
    cells = [row.name]
    for activities in (STANDING, WALKING):
        some = [outcome for outcome in outcomes if outcome.activity in activities]
        cell = f"{sum(outcome.as_told for outcome in some)} of {len(some)}"
        cells.append(f"{cell}, {sum(outcome.standing for outcome in some)} on their feet" if row.may_fall else cell)
    cells.append(f"{max(outcome.tilt for outcome in outcomes):.3f}" if row.stands and not row.may_fall else "-")
    cells.append(f"{max(outcome.drift for outcome in outcomes):.2f}")
    return "| " + " | ".join(cells) + " |"


def _run(arguments: tuple[str, str, int, str]) -> Outcome:
    return trial(*arguments)


def main(arguments: list[str] | None = None) -> int:
    """Run the repetitions and print the table; return 0 if everything promised was kept."""
    parser = argparse.ArgumentParser(prog="python -m tests.safety.trials", description="Faults at random moments.")
    parser.add_argument("--repetitions", type=int, default=100, help="trials per row (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default: %(default)s)")
    parser.add_argument("--row", action="append", choices=list(_ALL_ROWS), help="only this row; can be given again")
    parser.add_argument("--robot", default="humanoid", help="its name or robot.yaml (default: %(default)s)")
    options = parser.parse_args(arguments)
    write = sys.stdout.write
    write("| fault | standing | walking | largest tilt in the end [rad] | farthest way to the end [m] |\n")
    write("| --- | --- | --- | --- | --- |\n")
    broken: list[Outcome] = []
    farthest = 0.0
    with multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
        for name in options.row or ROWS:
            row = _ALL_ROWS[name]
            outcomes = pool.map(_run, repetitions(row, options.repetitions, options.robot), chunksize=2)
            write(summary(row, outcomes) + "\n")
            sys.stdout.flush()
            broken += [outcome for outcome in outcomes if row.promised and not outcome.as_told]
            farthest = max(farthest, *(outcome.beyond for outcome in outcomes))
    write(f"farthest beyond its range that a joint was: {farthest:.3f} rad\n")
    for outcome in broken:
        write(f"not as told: {outcome}\n")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
