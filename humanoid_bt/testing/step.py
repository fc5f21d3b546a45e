"""Steps of an order: a node that begins, or a claim that becomes true."""

from __future__ import annotations

import re

from humanoid_bt.core.errors import Place, UserError, nearest
from humanoid_bt.testing.claim import VERBS, Claim, RunNames
from humanoid_bt.testing.course import Course, Life
from humanoid_bt.tree.expressions.linking import CODE, within

_NAME = re.compile(r"[^<>=!()+*.'\"]+")  # no claim but a node's name or path; so is all that is in quotes


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
        quoted = len(text) > 2 and text[0] == text[-1] and text[0] in "'\"" and text.count(text[0]) == 2
        self.text = text[1:-1] if quoted else text
        self._place, self._text_at = place, text_at
        words = {"and", "or", "not", *VERBS}.intersection(re.findall(r"\w+", self.text))
        self._is_name = quoted or (bool(_NAME.fullmatch(self.text)) and not words)
        self._claim: Claim | None = None if self._is_name else self._parsed
        self._lives: list[Life] = []
        self._held = False

    @property
    def is_claim(self) -> bool:
        """Whether it is a claim, and no node."""
        return self._claim is not None

    @property
    def _parsed(self) -> Claim:
        return Claim.parse(self.text, self._place, self._text_at)

    def begin(self, names: RunNames) -> None:
        """Begin with a run.

        Raises:
            UserError: there is no such node, or a name of the claim means nothing.
        """
        course = names.course
        found = course.nodes(self.text)
        self._held, self._lives = False, course.lives(found)
        if found:
            self._claim = None
            return
        if self._is_name and names.value(self.text) is None:
            message, place = f"the tree {course.tree.name!r} has no node {self.text!r}", self._place
            raise UserError(message, within(place, self._text_at, 0), nearest(self.text, course.node_names), CODE)
        self._claim = self._parsed
        self._claim.link(names)

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
