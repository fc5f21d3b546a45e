"""A simulated robot's own links: which of them touch, and how near those that can touch come to each other."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import mujoco

from humanoid_bt.plant.mujoco_plant import MujocoPlant

Pair = tuple[str, str]
"""Names of two bodies, in order."""

FAR = 0.5  # m; farther apart counts as this far


class OwnLinks:
    """Measures on MuJoCo's own geometry, and knows nothing of what keeps the links apart.

    Args:
        plant: the robot in its scene.
    """

    def __init__(self, plant: MujocoPlant) -> None:
        self._model, self._data = plant.model, plant.data
        self._bodies = plant.robot.model.nbody  # those of the scene come after them
        excluded = {frozenset(divmod(int(signature), 1 << 16)) for signature in self._model.exclude_signature}
        solid = [
            geom
            for geom in range(self._model.ngeom)
            if 0 < self._model.geom_bodyid[geom] < self._bodies
            and (self._model.geom_contype[geom] or self._model.geom_conaffinity[geom])
        ]
        self._pairs = [
            (a, b)
            for a, b in itertools.combinations(solid, 2)
            if not self._joined(a, b) and frozenset(self._owners(a, b)) not in excluded
        ]

    def touching(self) -> Iterator[Pair]:
        """Yield the links that physics lets touch each other now."""
        contact = self._data.contact
        for geoms in contact.geom[contact.dist < 0].tolist():
            owners = self._owners(*geoms)
            if all(0 < body < self._bodies for body in owners):
                yield self._names(owners)

    def distances(self) -> dict[Pair, float]:
        """Return how far apart the links that can touch are now, negative for those that are in each other [m]."""
        found: dict[Pair, float] = {}
        for a, b in self._pairs:
            names = self._names(self._owners(a, b))
            distance = mujoco.mj_geomDistance(self._model, self._data, a, b, FAR, None)
            found[names] = min(distance, found.get(names, FAR))
        return found

    def _owners(self, a: int, b: int) -> tuple[int, int]:
        return int(self._model.geom_bodyid[a]), int(self._model.geom_bodyid[b])

    def _names(self, bodies: tuple[int, int]) -> Pair:
        first, second = sorted(self._model.body(body).name for body in bodies)
        return first, second

    def _joined(self, a: int, b: int) -> bool:
        """Return whether they belong to one link, or to two that a joint joins."""
        welds = self._model.body_weldid
        first, second = (int(welds[body]) for body in self._owners(a, b))
        above = (int(welds[self._model.body_parentid[body]]) for body in (first, second))
        return first == second or first in above or second in above
