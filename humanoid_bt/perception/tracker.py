"""The simulated tracker as a percept source: what is used where nobody names another."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

from humanoid_bt.core.messages import Percept
from humanoid_bt.core.params import PerceptName, param
from humanoid_bt.perception.simulated import SimulatedPerception
from humanoid_bt.perception.source import Moment, Need, PerceptSource


class Tracker(PerceptSource):
    """Publish the scene's `percepts` as a camera in the head with a tracker behind it would: simulated.

    Beside other sources it publishes those that none of them does.
    """

    needs: ClassVar[tuple[Need, ...]] = ("scene",)

    only: list[PerceptName] = param([], doc="The scene's percepts that it publishes; default: all of them.")

    def setup(self) -> None:
        """Begin with nothing seen."""
        self._simulated = SimulatedPerception(self.scene, self.scene.seed)

    def look(self, now: Moment) -> Iterable[Percept]:
        """Look from where the robot's eyes really are."""
        assert now.truth is not None
        return [seen for seen in self._simulated.observe(now.truth) if seen.name in self.names]

    def why_unseen(self, name: str) -> str:
        """Return why it cannot be seen."""
        return self._simulated.unseen.get(name, "")
