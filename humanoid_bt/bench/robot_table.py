"""A table of robots: what each is like, how often it withstands what it is tried with, and how fast it is simulated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from humanoid_bt.bench.body import Withstood
from humanoid_bt.bench.body_rows import Row
from humanoid_bt.bench.figure import Figure
from humanoid_bt.bench.speed import measure_solve, measure_walk
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.plant.portrait import height
from humanoid_bt.robot.config import Walk

_REPETITIONS = 3  # of each measurement of time


@dataclass(frozen=True)
class Likeness:
    """What a robot is like.

    Attributes:
        name: its name.
        mass: [kg].
        height: as it stands [m].
        joints: how many it has.
        picture: file of a picture, beside the table; "" if there is none.
    """

    name: str
    mass: float
    height: float
    joints: int
    picture: str = ""

    @classmethod
    def of(cls, robot: Path, picture: str = "") -> Likeness:
        """Return what a robot is like; raises UserError if it has mistakes."""
        model, standing = load_robot(robot)
        return cls(model.config.name, model.mass, height(model, standing), len(model.joint_names), picture)


@dataclass(frozen=True)
class Speed:
    """How fast a robot is simulated.

    Attributes:
        walk: simulated time beside CPU time, as it walks.
        physics: the same of ``mj_step`` alone, of the same motion.
        solve: a solve of inverse kinematics with both hands commanded; None without hands.
    """

    walk: Figure
    physics: Figure
    solve: Figure | None

    @classmethod
    def of(cls, robot: Path, body: Walk) -> Speed:
        """Measure it."""
        return cls(*measure_walk(robot, body, _REPETITIONS), measure_solve(robot, body, _REPETITIONS))


@dataclass(frozen=True)
class Entry:
    """A line of the table: a robot with one of its bodies.

    Attributes:
        likeness: what it is like.
        body: what walks and balances.
        withstood: what came of the rows that it was tried with.
        speed: how fast it is simulated.
    """

    likeness: Likeness
    body: Walk
    withstood: Sequence[Withstood]
    speed: Speed


def markdown(entries: Sequence[Entry], rows: Sequence[Row], command: str, seeds: Sequence[int]) -> str:
    """Return the table, as Markdown.

    Args:
        entries: its lines.
        rows: of ``bench --body``, its columns.
        command: what made it.
        seeds: of the trials.
    """
    head = ["", "robot", "body", *(row.name for row in rows), "walks at", "simulated", "IK, one solve"]
    lines = [head, ["---"] * len(head), *(list(_cells(entry, rows)) for entry in entries)]
    trials = (
        f"{len(seeds)} trials, seeds {seeds[0]} to {seeds[-1]}," if len(seeds) > 1 else f"one trial, seed {seeds[0]},"
    )
    return "\n".join(
        [
            "# Robots",
            "",
            *(f"| {' | '.join(line)} |" for line in lines),
            "",
            f"Made by `{command}`: {trials} of each row.",
            "Simulated: times faster than real time on one core, as it walks, without decision and recording;",
            "in brackets `mj_step` alone, of the same motion. IK: with both hands commanded.",
            "",
            *(f"- `{row.name}`: {row.what}" for row in rows),
            "",
        ]
    )


def _cells(entry: Entry, rows: Iterable[Row]) -> Iterator[str]:
    likeness, speed = entry.likeness, entry.speed
    yield f'<img src="{likeness.picture}" width="120" alt="{likeness.name}">' if likeness.picture else ""
    yield f"**{likeness.name}**, {likeness.mass:.1f} kg, {likeness.height:.2f} m, {likeness.joints} joints"
    yield entry.body
    found = {one.row.name: one for one in entry.withstood}
    for row in rows:
        yield f"{found[row.name].good.count} of {found[row.name].good.of}" if row.name in found else "-"
    paces = [figure.value for one in entry.withstood for figure in one.gait if figure.name == "speed"]
    yield f"{paces[0]:.2f} m/s" if paces else "-"
    yield f"{speed.walk.ratio:.1f}x ({speed.physics.ratio:.0f}x)"
    yield f"{speed.solve.ours:.0f} us" if speed.solve else "-"
