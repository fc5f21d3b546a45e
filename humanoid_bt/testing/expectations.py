"""Expectations of a run, judged: the same for scenario files and for tests in Python."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass

from humanoid_bt.core.errors import Place, Problem, UserError
from humanoid_bt.core.items import Item
from humanoid_bt.testing.claim import RunNames
from humanoid_bt.testing.course import Course, Missed, Run
from humanoid_bt.testing.expectation import Broken, Expectation
from humanoid_bt.testing.expectation_text import expectation, expectations_in
from humanoid_bt.tree.tree import Tree


@dataclass(frozen=True)
class Failure:
    """An expectation that a run has not met.

    Attributes:
        expectation: as it is written.
        place: where.
        time: since the run began [s].
        why: in words.
        values: what it asks and the values at that time, as people read them.
    """

    expectation: str
    place: Place
    time: float
    why: str
    values: Mapping[str, str]

    @property
    def moment(self) -> str:
        """What was at which time, in one line."""
        return f"at {self.time:.2f} s {self.why}"

    def __str__(self) -> str:
        lines = [self.expectation, self.moment, *(f"{name}: {value}" for name, value in self.values.items())]
        return "\n    ".join(lines)


class Expectations:
    """Expectations, as a file or a test says them.

    Args:
        all_: them.
    """

    described = "list of expectations"

    def __init__(self, all_: Iterable[Expectation]) -> None:
        self._all = tuple(all_)

    def __iter__(self) -> Iterator[Expectation]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    @classmethod
    def from_item(cls, item: Item, name: str) -> Expectations:
        """Read expectations from a YAML value; raises UserError."""
        return cls(expectations_in(item, name))

    @classmethod
    def of(cls, texts: Iterable[str]) -> Expectations:
        """Return the expectations that texts say; raises UserError."""
        return cls(expectation(text) for text in texts)

    def check(self, tree: Tree, percepts: Collection[str] | None = None) -> None:
        """Look up all names in a tree.

        Args:
            tree: it.
            percepts: those that there may be; any if None.

        Raises:
            UserError: with every name that means nothing, and every type or unit that does not go with another.
        """
        names = RunNames(Course(tree), percepts)
        problems: list[Problem] = []
        for one in self._all:
            try:
                one.begin(names)
            except UserError as error:
                problems += error.problems
        if problems:
            raise UserError(problems)

    def failures(self, run: Run, percepts: Collection[str] | None = None) -> list[Failure]:
        """Judge a run that is over; return what it has not met.

        Args:
            run: it.
            percepts: those that there may be; any if None.

        Raises:
            UserError: a name means nothing in its tree, or types or units do not go together.
        """
        course = Course(run.tree, run.stops)
        names = RunNames(course, percepts)
        for one in self._all:
            one.begin(names)
        for view in run.views():
            course.tick(view)
            for one in self._all:
                one.tick(course)
        course.finish(run)
        for one in self._all:
            one.end(course)
        found = [_failure(one, one.broken) for one in self._all if one.broken]
        found += [_unplayed(missed, run.time) for missed in run.missed if not missed.optional]
        if run.outcome == "error" and not any(claim.asks_outcome for one in self._all for claim in one.claims):
            why = f"the run ended with an error: {run.reason}"
            found.append(Failure("no error", Place(""), run.time, why, {}))
        return found


def expect(run: Run, texts: Iterable[str], percepts: Collection[str]) -> None:
    """Judge a run by expectations.

    Args:
        run: it.
        texts: them.
        percepts: those that there may be.

    Raises:
        AssertionError: it has not met all of them; with the moment and the values then.
        UserError: a text says none.
    """
    __tracebackhide__ = True
    failures = Expectations.of(texts).failures(run, percepts)
    if failures:
        raise AssertionError("\n".join([*map(str, failures), f"{run.outcome}: {run.reason}"]))


def _unplayed(missed: Missed, time: float) -> Failure:
    """Return that an event did not happen: a test whose script was not played out shows nothing."""
    why = "the run was over, and it had never happened (optional: true allows that)"
    return Failure(f"event {missed.event}", missed.place, time, why, missed.values)


def _failure(one: Expectation, broken: Broken) -> Failure:
    return Failure(one.text, one.place, broken.time, broken.why, dict(broken.values))
