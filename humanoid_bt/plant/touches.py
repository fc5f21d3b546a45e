"""What of the scene the robot touches, as only the simulation knows it, and whether a hand was sent there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from humanoid_bt.core.messages import SIDES, Array, HandTarget, Side
from humanoid_bt.core.palm import in_world, other_side
from humanoid_bt.plant.scene_model import FLOOR_CONTACTS
from humanoid_bt.robot.config import RobotConfig
from humanoid_bt.robot.model import carriers, palm_site
from humanoid_bt.robot.palm import palm_axes

_SENT = 0.15  # m from a palm's target within which the hand touches what it was sent to; fingers are as long
_PARTED = 0.1  # s without a touch after which a hand and a thing have parted; one that is let go may bounce


@dataclass(frozen=True)
class Touch:
    """A link of the robot touched an object for the first time.

    Attributes:
        time: engine time [s].
        thing: name of the object of the scene, also where it was the object's stand.
        link: the body of the robot.
        meant: whether it was a hand that was sent there: to press on something, or to a place that near; or that still
            touches what it was sent to.
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
        sides = [side for side in SIDES if side in config.hands]
        self._hands: dict[int, Side] = {model.body(config.hands[side].body).id: side for side in sides}
        self._palms = {side: (model.site(palm_site(side)).id, palm_axes(config, side)) for side in sides}
        self._things = np.array([_thing(model, body) for body in model.geom_bodyid])
        self.possible = bool((self._things >= 0).any())
        self.all: list[Touch] = []
        self._on_floor = int(model.sensor(FLOOR_CONTACTS).adr[0])  # how many contacts the floor has
        self._known: set[tuple[str, str, bool]] = set()
        self._meant: dict[tuple[Side, str], float] = {}  # when a hand touched last what it was sent to
        self.targets: Mapping[str, Any] = {}

    def clear(self) -> None:
        """Forget all of them."""
        self.all.clear()
        self._known.clear()
        self._meant.clear()
        self.targets = {}

    def note(self, data: mujoco.MjData, time: float) -> None:
        """Take those of a moment, engine time [s]."""
        if data.ncon == data.sensordata.item(self._on_floor):  # as in most moments
            return
        model, geoms = self._model, data.contact.geom
        things = self._things[geoms]
        for number in np.flatnonzero(things.max(axis=1) >= 0).tolist():
            first, second = things[number].tolist()
            link = int(model.geom_bodyid[geoms[number, 1 if first >= 0 else 0]])
            thing = model.body(max(first, second)).name.split("_", 1)[1]
            hand = next((self._hands[body] for body in carriers(model, link) if body in self._hands), None)
            meant = hand is not None and self._is_meant(hand, thing, data.contact.pos[number], data, time)
            touch = Touch(time, thing, model.body(link).name, meant)
            if (known := (touch.thing, touch.link, touch.meant)) not in self._known:
                self._known.add(known)
                self.all.append(touch)

    def _is_meant(self, hand: Side, thing: str, place: Array, data: mujoco.MjData, time: float) -> bool:
        parted = time - self._meant.get((hand, thing), -math.inf) > _PARTED
        if parted and not self._is_sent(hand, place, data):
            return False
        self._meant[hand, thing] = time
        return True

    def _is_sent(self, hand: Side, place: Array, data: mujoco.MjData) -> bool:
        """Return whether a hand is to press, or to come near a place, shape (3,), world frame [m]."""
        target = self.targets.get(f"{hand}_hand")
        if not isinstance(target, HandTarget):
            return False
        if target.relative:
            site, axes = self._palms[other_side(hand)]
            target = in_world(target, data.site_xpos[site], data.site_xmat[site].reshape(3, 3) @ axes)
        return target.press > 0 or bool(np.linalg.norm(target.position - place) < _SENT)


def _thing(model: mujoco.MjModel, body: int) -> int:
    """Return a body that is an object of the scene or its stand: what stands in the world; -1 for any other."""
    return int(body) if body > 0 and model.body_weldid[body] == 0 else -1
