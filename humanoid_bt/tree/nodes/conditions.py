"""Conditions, with hysteresis: a value that jitters about a threshold does not make the tree flap.

A condition remembers that it held as long as it is checked tick after tick; a branch that was left starts afresh, with
the plain threshold.
"""

from __future__ import annotations

import abc
import math
from collections.abc import Mapping
from typing import Any, ClassVar

from py_trees.common import Status

from humanoid_bt.core.params import PerceptName, param
from humanoid_bt.core.units import readable_pair
from humanoid_bt.perception.track import Track
from humanoid_bt.tree.expressions.expression import Truth
from humanoid_bt.tree.expressions.held import Held
from humanoid_bt.tree.expressions.linking import Unseen
from humanoid_bt.tree.nodes.leaf import Leaf
from humanoid_bt.tree.nodes.told_when_asked import ToldWhenAsked
from humanoid_bt.tree.results import AT_ONCE, SUCCEEDS, Below, Results
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, SUCCESS


class Condition(ToldWhenAsked, Leaf):
    """Succeed while an expression is true.

    A percept that was never seen makes it fail, unless `seen()` asks for it. A comparison can have a hysteresis:
    `distance(target) < 0.5 m hysteresis 5 cm` goes on holding up to 0.55 m.
    """

    main: ClassVar[str] = "expression"

    expression: Truth = param(doc="What must be true.")

    @classmethod
    def possible_results(cls, values: Mapping[str, Any], _below: Below) -> Results:
        """Return SUCCESS and FAILURE, one of them if nothing but numbers and words stand in the expression."""
        constant = values["expression"].constant
        if constant is None:
            return AT_ONCE
        return SUCCEEDS if constant else frozenset({FAILURE})

    def update(self) -> Status:
        """Evaluate the expression on what the robot knew at the start of the tick."""
        try:
            status = SUCCESS if self.expression.evaluate(self.robot) else FAILURE
        except Unseen as unseen:
            self.feedback_message = str(unseen)
            return FAILURE
        self.say(self.expression.explain)
        return status

    def stop(self, new_status: Status) -> None:
        """Take the status; there is nothing to end."""
        self.status = new_status


class PerceptCondition(Leaf):
    """Base of the conditions on one percept."""

    percept: PerceptName = param(doc="The percept to look at.")

    def __init__(self, name: str, **values: Any) -> None:
        super().__init__(name, **values)
        self._held = Held()

    @abc.abstractmethod
    def holds(self, track: Track, held: bool) -> bool:
        """Return whether the condition holds, and say why in the feedback; ``held`` is whether it did before."""

    def initialise(self) -> None:
        """Forget that it held if its branch was left."""
        if self.status is INVALID:
            self._held.holds = False

    def update(self) -> Status:
        """Check the percept as it was at the start of the tick."""
        track, held = self.robot.track(self.percept), self._held.ask(self.robot)
        if track is None:
            self.feedback_message = self.robot.why_unseen(self.percept)
            return FAILURE
        self._held.holds = self.holds(track, held)
        return SUCCESS if self._held.holds else FAILURE

    def stop(self, new_status: Status) -> None:
        """Take the status; there is nothing to end."""
        self.status = new_status


class Confident(PerceptCondition):
    """Succeed while a percept's confidence is high enough."""

    above: float = param(minimum=0, maximum=1, doc="Confidence from which it holds.")
    hysteresis: float = param(0.1, minimum=0, maximum=1, doc="It goes on holding down to this much less.")

    def __init__(self, name: str, **values: Any) -> None:
        super().__init__(name, **values)
        self.check_values()

    def check_values(self) -> None:
        """Refuse a hysteresis that reaches below every confidence."""
        if 0 < self.above <= self.hysteresis:
            raise ValueError(f"'hysteresis' ({self.hysteresis:g}) must be less than 'above' ({self.above:g})")

    def holds(self, track: Track, held: bool) -> bool:
        """Compare the confidence."""
        limit = self.above - self.hysteresis if held else self.above
        good = track.confidence >= limit
        self.feedback_message = f"confidence {track.confidence:.2f} {'>=' if good else '<'} {limit:g}"
        return good


class Within(PerceptCondition):
    """Succeed while a percept is near enough, and ahead if a bearing is given."""

    distance: float = param(above=0, unit="m", doc="Horizontal distance up to which it holds.")
    hysteresis: float = param(0.05, minimum=0, unit="m", doc="It goes on holding up to this much farther.")
    bearing: float | None = param(
        None, above=0, maximum=math.pi, unit="rad", doc="Largest angle to either side; none: any."
    )
    bearing_hysteresis: float = param(0.1, minimum=0, unit="rad", doc="It goes on holding up to this much more.")

    def holds(self, track: Track, held: bool) -> bool:
        """Compare the distance, then the bearing."""
        distance = track.distance
        limit = self.distance + self.hysteresis if held else self.distance
        if not distance <= limit:  # so that NaN is not near
            self.feedback_message = f"distance {distance:.2f} m > {limit:g} m"
            return False
        if self.bearing is not None:
            widest = self.bearing + self.bearing_hysteresis if held else self.bearing
            if not abs(track.bearing) <= widest:
                bearing, limit_in_words = readable_pair(track.bearing, widest, "rad")
                self.feedback_message = f"bearing {bearing} beyond {limit_in_words}"
                return False
        self.feedback_message = f"distance {distance:.2f} m <= {limit:g} m"
        return True
