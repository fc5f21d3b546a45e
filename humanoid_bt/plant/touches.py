"""What of the scene the robot touches, as only the simulation knows it, and whether a hand was sent there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from humanoid_bt.core.messages import Array, HandTarget
from humanoid_bt.robot.config import RobotConfig
from humanoid_bt.robot.model import carriers

_LOOK_AGAIN = 9  # moments in which as many contacts as before are taken for the same ones
_SENT = 0.15  # m from a palm's target within which the hand touches what it was sent to; fingers are as long


@dataclass(frozen=True)
class Touch:
    """A link of the robot touched an object for the first time.

    Attributes:
        time: engine time [s].
        thing: name of the object of the scene, also where it was the object's stand.
        link: the body of the robot.
        meant: whether it was a hand that was sent there: to press on something, or to a place that near.
    """

    time: float
    thing: str
    link: str
    meant: bool

    @property
    def text(self) -> str:
        """It for people: ``left hand touches table``."""
        return f"{self.link.replace('_', ' ')} touches {self.thing}"


class Touches:
    """Every touch since the robot was placed: once for each object, link, and whether it was meant.

    Args:
        model: the robot in its scene.
        config: the robot's.

    Attributes:
        possible: whether there is anything to touch besides the floor.
        all: them, in the order in which they came.
        targets: of hands, by resource, as the command in force has them; set them as they change.
    """

    def __init__(self, model: mujoco.MjModel, config: RobotConfig) -> None:
        self._model = model
        self._hands = {model.body(hand.body).id: f"{side}_hand" for side, hand in config.hands.items()}
        self._things = np.array([_thing(model, body) for body in model.geom_bodyid])
        self.possible = bool((self._things >= 0).any())
        self.all: list[Touch] = []
        self._known: set[tuple[str, str, bool]] = set()
        self.targets: Mapping[str, Any] = {}
        self._harmless = -1  # contacts when it was last looked, if none of them was with a thing
        self._passed = 0  # moments since then

    def clear(self) -> None:
        """Forget all of them."""
        self.all.clear()
        self._known.clear()
        self._harmless = -1
        self.targets = {}

    def note(self, data: mujoco.MjData, time: float) -> None:
        """Take those of a moment, engine time [s]."""
        if data.ncon == self._harmless and self._passed < _LOOK_AGAIN:  # as in most moments
            self._passed += 1
            return
        self._passed = 0
        geoms = data.contact.geom
        things = self._things[geoms]
        if not len(things) or things.max() < 0:
            self._harmless = len(things)
            return
        self._harmless = -1
        model = self._model
        for number in np.flatnonzero(things.max(axis=1) >= 0).tolist():
            first, second = things[number].tolist()
            link = int(model.geom_bodyid[geoms[number, 1 if first >= 0 else 0]])
            thing = model.body(max(first, second)).name.split("_", 1)[1]
            touch = Touch(time, thing, model.body(link).name, self._is_meant(link, data.contact.pos[number]))
            if (known := (touch.thing, touch.link, touch.meant)) not in self._known:
                self._known.add(known)
                self.all.append(touch)

    def _is_meant(self, link: int, place: Array) -> bool:
        resource = next((self._hands[body] for body in carriers(self._model, link) if body in self._hands), "")
        target = self.targets.get(resource)
        if not isinstance(target, HandTarget):
            return False
        return target.press > 0 or (not target.relative and bool(np.linalg.norm(target.position - place) < _SENT))


def _thing(model: mujoco.MjModel, body: int) -> int:
    """Return a body that is an object of the scene or its stand: what stands in the world; -1 for any other."""
    return int(body) if body > 0 and model.body_weldid[body] == 0 else -1
