"""Both hands of the standing robot at random places, crossing included: what of the robot touches the robot?

python -m tests.control.body.hands_trials --motions 500
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from humanoid_bt.control.body.planar import ahead
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.messages import SIDES, Array, Gait, HandTarget, Mode, Side
from tests.control.body.own_links import OwnLinks, Pair
from tests.control.control_rig import ControlRig

ROBOT = Path(__file__).resolve().parents[3] / "sim" / "humanoid" / "robot.yaml"
_SIGN = {"left": 1.0, "right": -1.0}


@dataclass(frozen=True)
class Room:
    """Where targets are drawn: boxes of the built-in robot's size, as seen from the stance; y is to the hand's side.

    Attributes:
        low, high: corners, shape (3,) [m].
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]

    def draw(self, numbers: np.random.Generator, side: Side) -> Array:
        """Return a place for a hand, shape (3,), as seen from the stance [m]."""
        place = numbers.uniform(self.low, self.high)
        return np.array([place[0], _SIGN[side] * place[1], place[2]])


ROOMS = {
    "ahead": Room((0.2, 0.05, 0.55), (0.45, 0.4, 1.2)),
    "crossing": Room((0.1, -0.35, 0.55), (0.4, -0.05, 1.2)),
    "trunk": Room((-0.1, -0.12, 0.65), (0.12, 0.12, 1.1)),
    "legs": Room((-0.05, -0.12, 0.2), (0.2, 0.15, 0.65)),
    "head": Room((-0.1, -0.1, 1.1), (0.15, 0.1, 1.35)),
    "behind": Room((-0.3, -0.2, 0.6), (-0.1, 0.3, 1.1)),
}
TOGETHER = "together"
"""Both hands at one place ahead."""

KINDS = (*ROOMS, TOGETHER)


@dataclass(frozen=True)
class Motion:
    """Where both hands go.

    Attributes:
        kind: of :data:`KINDS`.
        places: of the palms, as seen from the stance, shape (3,) [m].
    """

    kind: str
    places: dict[Side, Array]


def motion(seed: int, number: int) -> Motion:
    """Return a random motion; the same numbers give the same one."""
    numbers = np.random.default_rng((seed, number))
    kind = KINDS[number % len(KINDS)]
    if kind == TOGETHER:
        place = ROOMS["ahead"].draw(numbers, "left") * [1, numbers.uniform(-1, 1), 1]
        return Motion(kind, dict.fromkeys(SIDES, place))
    return Motion(kind, {side: ROOMS[kind].draw(numbers, side) for side in SIDES})


@dataclass
class Seen:
    """What was seen of some motions.

    Attributes:
        motions: how many.
        touched: links that touched each other -> in which motions.
        touching: motions in which any did.
        nearest: links -> least distance [m].
        missed: kind -> how far the palms were from their places in the end [m].
        torque: largest share of its limit that a joint's torque had, by joint.
        strained: joint -> ticks in which its drive gave all it has.
        stepped: in which motions the robot stepped to keep its balance.
        falls, stops: how many.
        ticks: how long it all took.
    """

    motions: int = 0
    touched: dict[Pair, list[int]] = field(default_factory=dict)
    touching: int = 0
    nearest: dict[Pair, float] = field(default_factory=dict)
    missed: dict[str, list[float]] = field(default_factory=dict)
    torque: dict[str, float] = field(default_factory=dict)
    strained: Counter[str] = field(default_factory=Counter)
    stepped: list[int] = field(default_factory=list)
    falls: int = 0
    stops: int = 0
    ticks: int = 0


class Trials:
    """One robot that makes one motion after another.

    Args:
        rig: the robot with its controller.
        seconds: how long a motion takes.
    """

    def __init__(self, rig: ControlRig, seconds: float) -> None:
        self._rig, self._seconds = rig, seconds
        self._links = OwnLinks(rig.plant)

    def run(self, number: int, motion: Motion, seen: Seen) -> None:
        """Let the robot make a motion, the given one of all, from where the last one has left it."""
        rig = self._rig
        stance = rig.state.stance
        places = {side: np.array([*ahead(stance, *place[:2])[:2], place[2]]) for side, place in motion.places.items()}
        targets = {f"{side}_hand": HandTarget(place) for side, place in places.items()}
        touched: set[Pair] = set()
        stepped = False
        for _ in range(round(self._seconds / DECISION_PERIOD)):
            rig.run(DECISION_PERIOD, targets, cycle=lambda: touched.update(self._links.touching()))
            self._look(seen)
            stepped |= rig.controller.body.walker.gait is not Gait.STAND
            if rig.controller.supervisor.mode is not Mode.RUN:
                break
        seen.motions += 1
        for pair in touched:
            seen.touched.setdefault(pair, []).append(number)
        seen.stepped += [number] * stepped
        seen.touching += bool(touched)
        seen.stops += rig.controller.supervisor.mode is not Mode.RUN
        if rig.controller.supervisor.mode is Mode.DAMP:
            seen.falls += 1
            rig.reset()
            return
        missed = [float(np.linalg.norm(rig.state.hands[side] - place)) for side, place in places.items()]
        seen.missed.setdefault(motion.kind, []).extend(missed)

    def _look(self, seen: Seen) -> None:
        rig, names = self._rig, self._rig.robot.joint_names
        seen.ticks += 1
        for pair, distance in self._links.distances().items():
            seen.nearest[pair] = min(distance, seen.nearest.get(pair, distance))
        shares = np.abs(rig.plant.measure().joint_torque) / rig.robot.torque_limit
        for name, share in zip(names, shares.tolist(), strict=True):
            seen.torque[name] = max(share, seen.torque.get(name, 0.0))
            seen.strained[name] += share >= 1.0


def report(seen: Seen, write: Callable[[str], object]) -> None:
    """Say what was seen."""
    write(f"{seen.motions} motions, {seen.ticks * DECISION_PERIOD:.0f} s: own links touched in {seen.touching}\n")
    write(f"falls {seen.falls}, stops {seen.stops}, stepped in {_numbers(seen.stepped)}\n")
    for pair, motions in sorted(seen.touched.items(), key=lambda item: -len(item[1]))[:12]:
        write(f"  touched in {len(motions):4d}: {' and '.join(pair)}, {_numbers(motions)}\n")
    for pair, distance in sorted(seen.nearest.items(), key=lambda item: item[1])[:12]:
        write(f"  nearest {distance * 100:6.2f} cm: {' and '.join(pair)}\n")
    for kind, missed in seen.missed.items():
        within = np.mean(np.array(missed) < 0.02) * 100
        write(f"  {kind}: within 2 cm {within:.0f} %, median {np.median(missed) * 100:.1f} cm\n")
    for name, ticks in seen.strained.most_common(6):
        if ticks:
            write(f"  {name}: all its torque in {ticks} ticks\n")


def _numbers(motions: list[int]) -> str:
    shown = ", ".join(map(str, motions[:5]))
    return f"motions {shown}{', ...' if len(motions) > 5 else ''}" if motions else "none"


def main(arguments: list[str] | None = None) -> int:
    """Make the motions; return 0 if nothing touched and the robot did not fall."""
    parser = argparse.ArgumentParser(prog="python -m tests.control.body.hands_trials", description=__doc__)
    parser.add_argument("--motions", type=int, default=500, help="how many (default: %(default)s)")
    parser.add_argument("--first", type=int, default=0, help="the first (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the places (default: %(default)s)")
    parser.add_argument("--seconds", type=float, default=2.5, help="how long each takes (default: %(default)s)")
    parser.add_argument("--robot", type=Path, default=ROBOT, help="a robot.yaml of about the same size")
    options = parser.parse_args(arguments)
    trials, seen = Trials(ControlRig(*load_robot(options.robot)), options.seconds), Seen()
    for number in range(options.first, options.first + options.motions):
        trials.run(number, motion(options.seed, number), seen)
    report(seen, sys.stdout.write)
    return 1 if seen.touching or seen.falls else 0


if __name__ == "__main__":
    raise SystemExit(main())
