"""Conditions of a run on the stage: what is different from the numbers that the robot and the scene give."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.core.messages import Array
from humanoid_bt.core.params import param, params_of
from humanoid_bt.core.reading import read
from humanoid_bt.core.units import readable
from humanoid_bt.perception.choice import Chosen
from humanoid_bt.plant.floor import Floor
from humanoid_bt.plant.scene import random_stream
from humanoid_bt.plant.scene_config import SceneConfig
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.tree.source.given import plain_item

NOISE = "perception_noise"
"""The one condition that is not of a body, or of what it stands on: the one that a dry run can have."""


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """What is different from the beginning of a run to its end. The robot's control does not know of it."""

    friction: float = param(1.0, minimum=0, maximum=10, doc="Factor of the friction of everything.")
    drives: float = param(
        1.0, minimum=0, maximum=2, doc="What every drive gives of the torque that it is asked for, and of its largest."
    )
    payload: float = param(0.0, minimum=0, maximum=100, unit="kg", doc="What the torso carries, at its centre of mass.")
    hand_payload: float = param(
        0.0, minimum=0, maximum=100, unit="kg", doc="What each hand carries, at its centre of mass."
    )
    drive_delay: float = param(
        0.0,
        minimum=0,
        maximum=1,
        unit="s",
        doc="How much later drives hear of commands, to the millisecond.",
    )
    encoder_error: float = param(
        0.0,
        minimum=-0.5,
        maximum=0.5,
        unit="rad",
        doc="What the encoder of one joint of a leg shows too much, to control and to the joint's drive; "
        "the seed says which joint.",
    )
    slope: float = param(
        0.0,
        minimum=0,
        maximum=0.5,
        unit="rad",
        doc="How steep the floor is. The robot starts with its feet flat on it; other things stay where they are.",
    )
    uphill: float = param(0.0, minimum=-7, maximum=7, unit="rad", doc="Where a steep floor rises; 0 is the world's x.")
    plates: float = param(
        0.0,
        minimum=0,
        maximum=0.1,
        unit="m",
        doc="How thick the flat plates are that lie about on the floor; the seed says where.",
    )
    perception_noise: float = param(
        1.0, minimum=0, maximum=100, doc="Factor of the standard deviations with which the scene's percepts are seen."
    )

    @classmethod
    def of(cls, given: Conditions | Mapping[str, Any] | None) -> Conditions:
        """Return conditions that may be made in Python or written as in YAML; both are read alike.

        Raises:
            UserError: with everything that is wrong with them.
        """
        written = vars(given) if isinstance(given, Conditions) else {} if given is None else given
        place = Place("conditions")
        conditions: Conditions = read(cls, plain_item("conditions", written, place), "the conditions")
        return conditions

    @property
    def of_body(self) -> dict[str, float]:
        """Those that the simulated body has in it, as arguments of ``MujocoPlant.alter``."""
        return {name: getattr(self, name) for name in ("friction", "payload", "hand_payload", "drives", "drive_delay")}

    @property
    def floor(self) -> Floor:
        """What the robot stands on."""
        return Floor(self.slope, self.uphill, self.plates)

    def encoders(self, robot: RobotModel, seed: int) -> Array | None:
        """Return what each encoder of a robot shows too much, shape (nj,) [rad]; None if all are as they should be."""
        if not self.encoder_error:
            return None
        legs, errors = robot.leg_joints, np.zeros(len(robot.joint_names))
        errors[random_stream(seed, "encoder").choice(legs)] = self.encoder_error
        return errors

    def refused(self, robot: RobotModel, chosen: Sequence[Chosen], dry: bool) -> Iterator[tuple[str, Problem]]:
        """Yield those that a run of a robot with these percept sources cannot have, each by its name."""
        for name in self.changed:
            if dry and name != NOISE:
                message = f"the condition {name!r} needs a body, and a dry run simulates none"
                yield name, Problem(message, hint="leave it out, or dry", code="exclusive-keys")
            elif name == "hand_payload" and not robot.config.hands:
                message = f"the condition {name!r} needs hands, and {robot.config.name} has none"
                yield name, Problem(message, hint="leave it out", code="model")
            elif name == NOISE and (problem := unsimulated(chosen)) is not None:
                yield name, problem

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


def unsimulated(chosen: Sequence[Chosen]) -> Problem | None:
    """Return why noise of the scene's percepts would change nothing in a run with these sources, None if it would."""
    if any("scene" in one.cls.needs and one.names for one in chosen):
        return None
    seeing = ", ".join(dict.fromkeys(repr(one.name) for one in chosen if one.names))
    instead = f"percepts come from {seeing}" if seeing else "there are no percepts"
    message = f"the condition {NOISE!r} is noise of the simulated tracker, and here {instead}"
    return Problem(message, hint="leave it out", code="exclusive-keys")
