"""What chaos does to each run, drawn from its seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.safety.background import LOADS
from tests.safety.strikes import ENDINGS, FAULTS, Ending, Fault

TREES = {"fetch": (), "stand": (), "tour": ("--set", "rounds=-1")}
"""Built-in trees -> their options."""

_MOST_FAULTS = 5  # that a run goes on after
_LATEST = 3.0  # s between two of them, at most
_LOADS = [0.5, 0.25, 0.1, 0.15]  # how likely each is
_CAMERA = 0.3  # how likely there are pictures


@dataclass(frozen=True)
class Plan:
    """What is done to one run: all of it follows from the seed and the number.

    Attributes:
        seed, number: of which trial; number -1 is the run that stands by.
        tree: what runs.
        load: what the machine does meanwhile.
        camera: whether pictures are taken.
        faults: that pass, each with the time since the one before [s].
        ending: what ends it, with its time [s].
    """

    seed: int
    number: int
    tree: str
    load: str
    camera: bool
    faults: tuple[tuple[float, Fault], ...]
    ending: tuple[float, Ending]

    def __str__(self) -> str:
        faults = "".join(f"; +{after:.2f} s {fault.name}" for after, fault in (*self.faults, self.ending))
        return f"#{self.number} {self.tree}, {self.load} load{', camera' if self.camera else ''}{faults}"

    def strength(self, index: int) -> np.random.Generator:
        """Return the random numbers of one of its faults."""
        return np.random.default_rng([self.seed, abs(self.number), index])


def planned(seed: int, number: int, camera: bool = True) -> Plan:
    """Return what is done in a trial; without a camera where none can be."""
    rng = np.random.default_rng([seed, number])
    tree, load = str(rng.choice(list(TREES))), str(rng.choice(list(LOADS), p=_LOADS))
    pictures = bool(rng.random() < _CAMERA) and camera
    alive = {"decision", "control", "perception", "recorder", *(["camera"] if pictures else [])}
    faults = []
    for _ in range(int(rng.integers(_MOST_FAULTS + 1))):
        possible = [fault for fault in FAULTS if alive.issuperset(fault.roles)]
        fault = possible[rng.integers(len(possible))]
        alive.difference_update(fault.ends)
        faults.append((float(rng.uniform(0, _LATEST)), fault))
    ending = ENDINGS[rng.integers(len(ENDINGS))]
    return Plan(seed, number, tree, load, pictures, tuple(faults), (float(rng.uniform(0, _LATEST)), ending))
