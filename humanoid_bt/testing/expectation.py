"""The kinds of expectations: what must be true of a run, and when.

within 20 s: P              it becomes true at some time, 20 s after the beginning at the latest
within 2 s after Q: P       ... each time that Q has become true, 2 s after that at the latest
never: P [while Q]          it is true at no time
always: P [while Q]         it is true all the time
order: [A, B]               A comes first, then B: nodes that begin, or claims that become true
P                           it is true at the end
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from humanoid_bt.core.errors import Place
from humanoid_bt.core.texts import told
from humanoid_bt.testing.claim import Claim, RunNames
from humanoid_bt.testing.course import Course
from humanoid_bt.testing.step import Step

_AT = 1e-9  # s; engine times are sums of floats


@dataclass(frozen=True)
class Broken:
    """How an expectation was not met.

    Attributes:
        time: since the run began [s].
        why: in words.
        values: what it asks and the values at that time, as people read them.
    """

    time: float
    why: str
    values: Mapping[str, str] = field(default_factory=dict)


class Expectation(ABC):
    """What must be true of a run, and when. It is for one run at a time.

    Args:
        text: as it is written.
        place: where.

    Attributes:
        broken: how it was not met, None as long as it may be.
    """

    def __init__(self, text: str, place: Place) -> None:
        self.text, self.place = text, place
        self.broken: Broken | None = None

    @property
    @abstractmethod
    def claims(self) -> Sequence[Claim]:
        """The claims in it."""

    def begin(self, names: RunNames) -> None:
        """Begin with a run.

        Args:
            names: what names mean in it.

        Raises:
            UserError: a name means nothing, or types or units do not go together.
        """
        self.broken = None
        for claim in self.claims:
            claim.link(names)

    def tick(self, course: Course) -> None:
        """Look at a run after a tick."""
        if self.broken is None:
            self._guarded(course, last=False)

    def end(self, course: Course) -> None:
        """Look at a run that has ended."""
        if self.broken is None:
            self._guarded(course, last=True)

    def _guarded(self, course: Course, last: bool) -> None:
        try:
            self.look(course)
            if last and self.broken is None:
                self.close(course)
        except (TypeError, ArithmeticError) as error:
            self.broken = Broken(course.time, f"it cannot be judged: {told(error)}")

    @abstractmethod
    def look(self, course: Course) -> None:
        """Look at what a tick has brought; at the end, at how the run ended."""

    @abstractmethod
    def close(self, course: Course) -> None:
        """Judge what can be judged only when nothing more comes."""

    def break_at(self, course: Course, why: str, time: float | None = None) -> None:
        """Note how it was not met, now or at a time [s]."""
        values = {name: value for claim in self.claims for name, value in claim.values(course.robot).items()}
        self.broken = Broken(course.time if time is None else time, why, values)


class AtEnd(Expectation):
    """True at the end.

    Args:
        claim: what is.
    """

    def __init__(self, text: str, place: Place, claim: Claim) -> None:
        super().__init__(text, place)
        self._claim = claim

    @property
    def claims(self) -> Sequence[Claim]:
        """The claims in it."""
        return (self._claim,)

    def look(self, course: Course) -> None:
        """Wait for the end."""

    def close(self, course: Course) -> None:
        """Judge it."""
        if not self._claim.holds(course.robot):
            self.break_at(course, "it was not so at the end")


class Within(Expectation):
    """True at some time within a limit, from the beginning on or each time after something has become true.

    Args:
        limit: [s].
        claim: what becomes true.
        after: what becomes true before, None for the beginning.
    """

    def __init__(self, text: str, place: Place, limit: float, claim: Claim, after: Claim | None) -> None:
        super().__init__(text, place)
        self.limit = limit
        self._claim, self._after = claim, after
        self._since: float | None = None  # when it began to count [s], None when it does not
        self._held = self._ever = False

    @property
    def claims(self) -> Sequence[Claim]:
        """The claims in it."""
        return (self._claim,) if self._after is None else (self._claim, self._after)

    def begin(self, names: RunNames) -> None:
        """Begin with a run."""
        super().begin(names)
        self._since = 0.0 if self._after is None else None
        self._held, self._ever = False, self._after is None

    def look(self, course: Course) -> None:
        """See whether it has become true in time."""
        if self._after is not None:
            before, self._held = self._held, bool(self._after.holds(course.robot))
            if self._held and not before:
                self._ever = True
                self._since = course.time if self._since is None else self._since
        if self._since is None:
            return
        if course.time > self._since + self.limit + _AT:
            self.break_at(course, "it had not become so by then", self._since + self.limit)
        elif self._claim.holds(course.robot):
            self._since = None

    def close(self, course: Course) -> None:
        """Judge what has not become true."""
        if not self._ever:
            assert self._after is not None
            self.break_at(course, f"nothing was looked at: {self._after.text!r} was never so")
        elif self._since is not None:
            self.break_at(course, "the run ended before it became so")


class Throughout(Expectation):
    """Always or never true, perhaps only while something else is.

    Args:
        claim: what is.
        wanted: True for always, False for never.
        meanwhile: when it counts, None for all the time.
    """

    def __init__(self, text: str, place: Place, claim: Claim, wanted: bool, meanwhile: Claim | None) -> None:
        super().__init__(text, place)
        self._claim, self._wanted, self._meanwhile = claim, wanted, meanwhile
        self._looked = self._judged = False

    @property
    def claims(self) -> Sequence[Claim]:
        """The claims in it."""
        return (self._claim,) if self._meanwhile is None else (self._claim, self._meanwhile)

    def begin(self, names: RunNames) -> None:
        """Begin with a run."""
        super().begin(names)
        self._looked = self._judged = False

    def look(self, course: Course) -> None:
        """See whether it is as it must be."""
        if self._meanwhile is not None and not self._meanwhile.holds(course.robot):
            return
        self._looked = True
        holds = self._claim.holds(course.robot)
        self._judged = self._judged or holds is not None
        if holds is (not self._wanted):
            self.break_at(course, "it was not so" if self._wanted else "it became so")

    def close(self, course: Course) -> None:
        """Refuse what was never looked at: a test that cannot fail shows nothing."""
        if not self._looked:
            assert self._meanwhile is not None
            self.break_at(course, f"nothing was looked at: {self._meanwhile.text!r} was never so")
        elif not self._judged and (self._wanted or self._claim.untold):  # all else may come in some runs only
            self.break_at(course, f"nothing was looked at: {self._claim.untold or 'it never had a value'}")


class Order(Expectation):
    """Steps that come one after the other; steps of one tick come in the order in which they are written.

    Args:
        steps: them.
    """

    def __init__(self, text: str, place: Place, steps: Sequence[Step]) -> None:
        super().__init__(text, place)
        self._steps = steps
        self._came: list[float] = []
        self._times: dict[str, list[float]] = {}  # all at which a step came, in order or not
        self._early: tuple[float, str] | None = None  # when one came that was not its turn, and how
        self._looked = False

    @property
    def claims(self) -> Sequence[Claim]:
        """The claims in it."""
        return ()

    def begin(self, names: RunNames) -> None:
        """Begin with a run."""
        super().begin(names)
        self._came, self._times, self._early, self._looked = [], {}, None, False
        for step in self._steps:
            step.begin(names)

    def look(self, course: Course) -> None:
        """See which steps come."""
        looked = {step.text: step for step in self._steps}
        now = {text for text, step in looked.items() if step.comes(course)}
        for text in now:
            self._times.setdefault(text, []).append(course.time)
        if self._early is not None:
            return
        while len(self._came) < len(self._steps) and (text := self._steps[len(self._came)].text) in now:
            now.remove(text)
            self._came.append(course.time)
        done, waiting = self._steps[: len(self._came)], self._steps[len(self._came) :]
        passed = {step.text for step in done}
        if not self._looked:  # what is true from the beginning on has not become so
            passed |= {text for text, step in looked.items() if step.is_claim}
        self._looked = True
        early = [step.text for step in waiting if step.text in now and step.text not in passed]
        if early:
            self._early = course.time, f"{early[0]!r} came before {waiting[0].text!r}"

    def close(self, course: Course) -> None:
        """Judge what came when it was not its turn, and what did not come: only now it is known when each did."""
        waiting = self._steps[len(self._came) :]
        if not waiting:
            return
        why = f"{waiting[0].text!r} did not come" + (" after that" if self._came else "")
        time, why = self._early or (course.time, why)
        names = [step.text for step in self._steps]
        again = {index: names[:index].count(name) + 1 for index, name in enumerate(names)}
        shown = [f"{name} #{again[index]}" if again[index] > 1 else name for index, name in enumerate(names)]
        came = [f"came at {time:.2f} s" if time is not None else "did not come" for time in self._all_came()]
        self.broken = Broken(time, why, dict(zip(shown, came, strict=True)))

    def _all_came(self) -> Iterator[float | None]:
        """Yield when each step came, in order or not; None if it did not."""
        yield from self._came
        last = {step.text: time for step, time in zip(self._steps, self._came, strict=False)}
        left = {text: [time for time in times if time > last.get(text, -1.0)] for text, times in self._times.items()}
        for step in self._steps[len(self._came) :]:
            yield left[step.text].pop(0) if left.get(step.text) else None
