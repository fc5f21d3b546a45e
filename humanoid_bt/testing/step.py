"""Steps of an order: a node that begins, or a claim that becomes true."""

from __future__ import annotations

import re

from humanoid_bt.core.errors import Place, UserError, nearest
from humanoid_bt.testing.claim import VERBS, Claim, RunNames
from humanoid_bt.testing.course import Course, Life
from humanoid_bt.tree.expressions.linking import CODE, within

_NAME = re.compile(r"[^<>=!()+*.'\"]+")  # no claim but a node's name or path


class Step:
    """One step: ``approach`` when this node begins, ``fell or reach failed`` when that becomes true.

    Args:
        text: as it is written.
        place: where.
        text_at: how many columns behind its place its first character stands, None if that is not known.

    Raises:
        UserError: it is neither.
    """

    def __init__(self, text: str, place: Place, text_at: int | None) -> None:
        self.text, self._place = text, within(place, text_at, 0)
        self._claim = None if self._is_name else Claim.parse(text, place, text_at)
        self._lives: list[Life] = []
        self._held = False

    @property
    def _is_name(self) -> bool:
        words = re.findall(r"\w+", self.text)
        return bool(_NAME.fullmatch(self.text)) and not {"and", "or", "not", *VERBS}.intersection(words)

    def begin(self, names: RunNames) -> None:
        """Begin with a run.

        Raises:
            UserError: there is no such node, or a name of the claim means nothing.
        """
        self._held, self._lives = False, []
        if self._claim is not None:
            self._claim.link(names)
            self._claim.forget()
            return
        course = names.course
        found = course.nodes(self.text)
        if not found:
            message = f"the tree {course.tree.name!r} has no node {self.text!r}"
            raise UserError(message, self._place, nearest(self.text, course.node_names), CODE)
        self._lives = course.lives(found)

    def comes(self, course: Course) -> bool:
        """Return whether it comes in this tick.

        Raises:
            TypeError: the value of a key has the wrong type.
            ArithmeticError: something cannot be computed.
        """
        if self._claim is None:
            return any(life.begins for life in self._lives)
        before, self._held = self._held, bool(self._claim.holds(course.robot))
        return self._held and not before
