"""Conditions of a run on the stage: what is different from the numbers that the robot and the scene give."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from humanoid_bt.core.errors import Place
from humanoid_bt.core.items import item_of
from humanoid_bt.core.params import param, params_of
from humanoid_bt.core.reading import read
from humanoid_bt.core.units import readable
from humanoid_bt.plant.scene_config import SceneConfig


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """What is different from the beginning of a run to its end. The robot's control does not know of it."""

    friction: float = param(1.0, minimum=0, maximum=10, doc="Factor of the friction of everything.")
    drives: float = param(
        1.0, minimum=0, maximum=2, doc="What every drive gives of the torque that it is asked for, and of its largest."
    )
    payload: float = param(0.0, minimum=0, maximum=100, unit="kg", doc="What the torso carries, at its centre of mass.")
    perception_noise: float = param(
        1.0, minimum=0, maximum=100, doc="Factor of the standard deviations with which the scene's percepts are seen."
    )

    @classmethod
    def of(cls, given: Conditions | Mapping[str, Any] | None) -> Conditions:
        """Return conditions that may be written as in YAML; raises UserError."""
        if isinstance(given, Conditions):
            return given
        conditions: Conditions = read(cls, item_of(dict(given or {}), Place("conditions")), "the conditions")
        return conditions

    @property
    def of_body(self) -> dict[str, float]:
        """Those that the simulated body feels, as arguments of ``MujocoPlant.alter``."""
        return {"friction": self.friction, "drives": self.drives, "payload": self.payload}

    @property
    def changed(self) -> dict[str, float]:
        """Those that are not as the robot and the scene say, by name."""
        return {name: value for name, value in vars(self).items() if value != params_of(Conditions)[name].default}

    def __str__(self) -> str:
        specs = params_of(Conditions)
        return ", ".join(f"{name} {readable(value, specs[name].unit)}" for name, value in self.changed.items())

    def seen(self, scene: SceneConfig) -> SceneConfig:
        """Return a scene as it is seen under these conditions."""
        factor = self.perception_noise
        if factor == 1.0:
            return scene
        percepts = {
            name: replace(seen, noise=seen.noise * factor, noise_per_meter=seen.noise_per_meter * factor)
            for name, seen in scene.percepts.items()
        }
        return replace(scene, percepts=percepts)
