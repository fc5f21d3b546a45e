"""What follows when something touches the robot: an arm yields, and what is in its way stops the robot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from humanoid_bt.core.clock import cycles
from humanoid_bt.core.messages import SIDES, TORSO, Array, BaseTarget, Command, Contact, HandTarget, Side
from humanoid_bt.robot.config import ContactConfig

_ENDS = 0.6  # share of the force that begins a contact up to which it ends (hysteresis)
_HOMEWARD = 0.6  # share of the limit up to which an arm does not yield that goes home from what it touched
_PRESS_SHARE = 2.0  # of the force that a hand is to press with, before that is more than was expected
_PRESS_NOTICED = 0.6  # of it, from which on it touches something, if that is less than for a hand that is not to
_FORGET = 1.0  # s without contact after which a robot may go on that something was in the way of
_OFTEN, _OFTEN_WITHIN = 3, 20.0  # so many stops for that in so many s, and only a person lets it go on
_LONG = 10.0  # s that one of them lasts, likewise
_LEAK = 0.25  # s that are forgotten of contact in every second without
_ARMS = tuple((side, f"{side}_arm", f"{side}_hand") for side in SIDES)  # group of links, resource
_AGAINST = -0.5  # cosine of the angle between a force and the way, up to which it is against it


@dataclass
class _Yield:
    """An arm that yields.

    Attributes:
        source: node whose target the hand had then, "" for none.
        largest: force so far [N].
        touched: servo cycle at which it was touched last.
        asked_anew: whether that target was let go since.
    """

    source: str
    largest: float
    touched: int
    asked_anew: bool


class ContactRule:
    """Decides what touches the robot, which arms yield to it, and whether it may go on.

    An arm that is pushed harder than the limit yields: its hand's target is let go, and it follows what pushes it. It
    is stiff again after a time without contact, once the node that wanted the hand there has let go of it.

    A push on the torso is for balance to catch, and is only told: a robot that steps withstands more than one that is
    stopped. Something in the robot's way is another matter: it would be pushed with the robot's whole weight. It stops
    the robot until it is gone; but whoever commands the robot may send it there again and again, and what stays there
    may be a person who cannot get away: then only a person lets it go on.

    Args:
        config: the robot's numbers.

    Attributes:
        yielding: the arms that yield.
        homeward: those that have yielded, and go home from what touched them; set it. They yield sooner.
        pressed: the groups of links that touch something, or are to.
        held: why the robot must not go on, "" when it may.
        blocked: why it must not until a person says so, "" when it may.
    """

    def __init__(self, config: ContactConfig) -> None:
        self._config = config
        self._quiet, self._lasting, self._forget = map(cycles, (config.quiet, config.lasting, _FORGET))
        self._often_within, self._long = map(cycles, (_OFTEN_WITHIN, _LONG))
        self.reset()

    def reset(self) -> None:
        """Begin with a robot that nothing touches."""
        self._touches: dict[str, float] = {}  # largest force so far [N], by group
        self._yields: dict[str, _Yield] = {}  # by group
        self._forces: Mapping[str, Array] = {}
        self._command: Command | None = None
        self._pressing: dict[str, float] = {}  # with which force each arm is to press [N], by group
        self.yielding: frozenset[Side] = frozenset()
        self.homeward: frozenset[Side] = frozenset()
        self.pressed: frozenset[str] = frozenset()
        self._looked = 0
        self.forgive()

    def forgive(self) -> None:
        """Let the robot go on: nothing has been in its way."""
        self.held = self.blocked = ""
        self._holds: list[int] = []  # servo cycles in which something came to be in the way
        self._against = 0.0  # servo cycles with something in the way, less a part of those without
        self._free = 0

    def look(self, cycle: int, forces: Mapping[str, Array], command: Command | None, place: Array) -> None:
        """Look at what pushes the robot.

        Args:
            cycle: the servo cycle that begins.
            forces: group of links -> force, shape (3,) [N].
            command: what decision wants.
            place: where the base is, of which x and y count [m].
        """
        self._forces = forces
        if command is not self._command:
            self._command, self._pressing = command, _pressing(command)
        pressing, touches, config = self._pressing, self._touches, self._config
        for group, vector in forces.items():
            begins = config.torso if group == TORSO else config.notice
            if group in pressing:
                begins = min(begins, _PRESS_NOTICED * pressing[group])
            x, y, z = vector.tolist()
            force = math.sqrt(x * x + y * y + z * z)
            if force > begins or group in touches:
                self._feel(group, force, begins)
        if touches or self._yields:
            for side, arm, hand in _ARMS:
                self._judge_arm(cycle, side, arm, hand, command, pressing.get(arm, 0.0))
        self._judge_way(cycle, command, place)
        if pressing or self._yields or TORSO in self._touches or self.pressed:
            torso = {TORSO} & self._touches.keys()
            self.pressed = frozenset(pressing.keys() | self._yields.keys() | torso)

    @property
    def contacts(self) -> dict[str, Contact]:
        """What touches the robot, and the arms that yield."""
        found: dict[str, Contact] = {}
        if not (self._yields or self._touches):
            return found
        for group, force in self._forces.items():
            yields, largest = self._yields.get(group), self._touches.get(group)
            if yields is not None:
                found[group] = Contact(force.copy(), yields.largest, yields=True)
            elif largest is not None:
                found[group] = Contact(force.copy(), largest)
        return found

    def _feel(self, group: str, force: float, begins: float) -> None:
        largest = self._touches.get(group, 0.0)
        if force > (_ENDS * begins if largest else begins):
            self._touches[group] = max(largest, force)
        elif largest:
            del self._touches[group]

    def _judge_arm(self, cycle: int, side: Side, arm: str, hand: str, command: Command | None, press: float) -> None:
        touch, yields = self._touches.get(arm, 0.0), self._yields.get(arm)
        source = command.sources.get(hand, "") if command and hand in command.targets else ""
        if yields is None:
            limit = self._config.limit * (_HOMEWARD if side in self.homeward else 1.0)
            if touch > max(limit, _PRESS_SHARE * press):
                self._yields[arm] = _Yield(source, touch, cycle, asked_anew=not source)
                self.yielding |= {side}
            return
        yields.asked_anew = yields.asked_anew or source != yields.source
        if touch:
            yields.touched, yields.largest = cycle, max(yields.largest, touch)
        elif yields.asked_anew and cycle - yields.touched > self._quiet:
            del self._yields[arm]
            self.yielding -= {side}

    def _judge_way(self, cycle: int, command: Command | None, place: Array) -> None:
        """Judge whether the robot may walk on; contact that comes and goes with its steps counts, too."""
        passed, self._looked = cycle - self._looked, cycle
        against = self._against_the_way(command, place) if self._touches else []
        if self.held:
            self._free = 0 if self._touches else self._free + passed
            if self._free > self._forget:
                self.held, self._against = "", 0.0
            elif cycle - self._holds[-1] > self._long:
                self.blocked = self.blocked or f"{self.held}, for more than {_LONG:g} s"
        elif against:
            self._against += passed
            if self._against >= self._lasting:
                group, largest = against[0]
                self.held = f"something is in the way of the {group.replace('_', ' ')}: {largest:.0f} N"
                self._holds = [before for before in self._holds if cycle - before < self._often_within] + [cycle]
                if len(self._holds) >= _OFTEN:
                    self.blocked = f"{self.held}, {_OFTEN} times within {_OFTEN_WITHIN:g} s"
        elif self._against:
            self._against = max(0.0, self._against - _LEAK * passed)

    def _against_the_way(self, command: Command | None, place: Array) -> list[tuple[str, float]]:
        """Return the groups of links that something pushes back from where the base is to go, and how hard [N]."""
        base = command.targets.get("base") if command else None
        if not isinstance(base, BaseTarget):
            return []
        way = base.position - place[:2]
        return [
            (group, largest)
            for group, largest in self._touches.items()
            if (group == TORSO or group in self._yields) and _opposes(self._forces[group][:2], way)
        ]


def _opposes(force: Array, way: Array) -> bool:
    """Return whether a force, shape (2,), pushes back one who has a way to go, shape (2,)."""
    return float(force @ way) < _AGAINST * math.sqrt(float(force @ force) * float(way @ way))


def _pressing(command: Command | None) -> dict[str, float]:
    """Return the arms whose hands are to press, and with which force [N]."""
    targets = {arm: command.targets.get(hand) for _, arm, hand in _ARMS} if command else {}
    return {arm: hand.press for arm, hand in targets.items() if isinstance(hand, HandTarget) and hand.press}
