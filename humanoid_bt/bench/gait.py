"""How briskly a robot walks: its speed, how soon it starts and comes to rest, how long a metre takes it."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from humanoid_bt.bench.promises import FROM_COMMAND, FROM_TOUCHDOWN, METRE, PACE, Promise, Verdict
from humanoid_bt.campaign.result import Value
from humanoid_bt.core.messages import SIDES
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.robot.model import foot_sensor, sole_site
from humanoid_bt.testing.tree_run import TreeRun, View

_IN_THE_AIR = 1.0  # N on a foot
_LIFTED = 0.003  # m above where it stood, of a sole that is off the floor
_MIDDLE = (1 / 3, 2 / 3)  # of the way

ROW_OF = {"speed": "straight", "time": "metre", "start": "metre", "rest": "metre"}
"""The row of ``bench --body`` that tells each figure."""

PROMISES_OF = {"speed": PACE, "time": METRE, "start": FROM_COMMAND, "rest": FROM_TOUCHDOWN}
"""What is promised of the mean of each figure."""


UNITS = {name: promise.unit for name, promise in PROMISES_OF.items()}
"""Of :attr:`GaitWatch.values`."""


class GaitWatch:
    """Watches a walk, in physics, and says what is known of it in :attr:`values`.

    Args:
        plant: gives the plant on which it walks.
        way: how far it is to walk [m].

    Attributes:
        values: of the walk so far: ``start``, from the command until a foot is off the floor [s]; ``rest``, from the
            last touchdown until the base counts as settled [s]; ``time``, from the command until then [s]; ``speed``,
            of the base over the middle third of the way [m/s].
    """

    def __init__(self, plant: Callable[[], MujocoPlant | None], way: float) -> None:
        self._plant, self._way = plant, way
        self._begin: tuple[float, float] | None = None
        self._passed: list[tuple[float, float]] = []  # time [s] and way [m] where the middle third begins and ends
        self._stood: list[float] = []  # heights of the soles at the beginning [m]
        self._last_up = 0.0
        self.values: dict[str, float] = {}

    def tick(self, view: View) -> None:
        """Look at the feet and at the base."""
        plant = self._plant()
        assert plant is not None
        x, y = plant.data.qpos[:2].tolist()
        self._begin = self._begin or (x, y)
        made = math.dist((x, y), self._begin)
        if len(self._passed) < len(_MIDDLE) and made >= _MIDDLE[len(self._passed)] * self._way:
            self._passed.append((plant.time, made))
            if len(self._passed) == len(_MIDDLE):
                (since, first), (until, last) = self._passed
                self.values["speed"] = (last - first) / (until - since)
        self._look_at_feet(plant, settled=view.state.base_settled)

    def end(self, run: TreeRun) -> None:
        """Nothing is left to be seen."""

    def _look_at_feet(self, plant: MujocoPlant, settled: bool) -> None:
        up = min(abs(plant.data.sensor(foot_sensor(side)).data[2]) for side in SIDES) < _IN_THE_AIR
        heights = [plant.data.site(sole_site(side)).xpos[2] for side in SIDES]
        self._stood = self._stood or heights
        if any(height - stood > _LIFTED for height, stood in zip(heights, self._stood, strict=True)):
            self.values.setdefault("start", plant.time)
        if "start" not in self.values:
            return
        if up:
            self._last_up = plant.time
            self.values.pop("rest", None)
        elif settled and "rest" not in self.values:
            self.values |= {"rest": plant.time - self._last_up, "time": plant.time}


@dataclass(frozen=True)
class GaitFigure:
    """A figure of the gait.

    Attributes:
        name: the figure's.
        value: its mean over the trials of its row that reached their goal.
        median, most: of the same.
        promise: of the mean.
    """

    name: str
    value: float
    median: float
    most: float
    promise: Promise

    @property
    def verdict(self) -> Verdict:
        """Whether it keeps its promise."""
        return self.promise.verdict(self.value)


def gait_figures(row: str, values: Sequence[Mapping[str, Value]]) -> list[GaitFigure]:
    """Return the figures that a row of trials tells of the gait.

    Args:
        row: its name.
        values: what :class:`GaitWatch` saw in each trial that reached its goal.
    """
    found: list[GaitFigure] = []
    for name, of in ROW_OF.items():
        seen = [float(each[name]) for each in values if name in each]
        if of == row and seen:
            promise = PROMISES_OF[name]
            figures = statistics.fmean(seen), statistics.median(seen), min(seen) if promise.at_least else max(seen)
            found.append(GaitFigure(name, *figures, promise))
    return found
