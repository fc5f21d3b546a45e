"""What came of trying a skill against the contract: every rule, what shows it, and what to do."""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

Verdict = Literal["passed", "failed", "not tried"]
"""What came of one rule; not tried is what an earlier failure stands in the way of."""

_LETTING_GO: Mapping[str, str] = {
    "still commanded": "Leave `stop` alone, which lets go of everything.",
    "in the tick after it": "End in `terminate` every thread that the skill has started, so that none commands on.",
    "raised": "Clean up in `terminate` so that nothing raises there.",
}
"""How a skill does not let go -> what to do."""

RULES: Mapping[str, tuple[str, str]] = {
    "exceptions": (
        "raises nothing",
        "Answer what can go wrong with `return self.fail(...)`: an exception stops the robot and ends the run.",
    ),
    "blocking": (
        "does not block",
        "Return RUNNING and go on in the next tick. Do what takes long beforehand, in `setup`, or in a thread that "
        "`update` only looks at.",
    ),
    "halting": (
        "lets go when halted",
        " ".join(_LETTING_GO.values()),
    ),
    "restarting": (
        "starts anew",
        "Set in `initialise` everything that `update` changes; parameters are set when the skill is made, and stay.",
    ),
    "ending": (
        "ends as it declares",
        "Say it in the class: `ends = False` of a skill that never succeeds or fails, `runs = False` of one that "
        "answers at once. Checks of trees rely on it.",
    ),
    "commands": (
        "commands what it declares",
        "Name it in `resources`, and let `resources_for` return it for these parameters.",
    ),
    "percepts": (
        "reads what it declares",
        "Make the percept's name a parameter of type `PerceptName`, so that checks see to a watchdog above it.",
    ),
    "snapshot": (
        "leaves the snapshot alone",
        "Work on a copy, `position.copy()`, or write `a = a + b` for `a += b`: all nodes of a tick see the same state.",
    ),
    "reasons": (
        "says why it fails",
        "Tell a person who was not there: `return self.fail(f'comes no nearer than {error * 100:.0f} cm')`.",
    ),
    "sameness": (
        "does the same again",
        "Take time from `self.robot.clock.now()`, random numbers from a generator made in `initialise` with a seed of "
        "its own, and keep nothing in the class or the module.",
    ),
    "estop": (
        "survives an emergency stop",
        "Let `update` go on while the robot stands still: it waits and says for what, or gives up and says why.",
    ),
    "lost": (
        "survives lost percepts",
        "Ask `self.robot.track(name)` in every tick; it is None while the thing was never seen: "
        "`return self.fail(self.robot.why_unseen(name))`.",
    ),
}
"""Rule -> what a skill that keeps it does, and what to do about one that does not."""

_MARKS: Mapping[str, str] = {"failed": "✗", "passed": "✓", "not tried": "○"}


@dataclass(frozen=True)
class RuleResult:
    """What came of one rule.

    Attributes:
        rule: its name.
        verdict: passed, failed or not tried.
        evidence: what shows it.
    """

    rule: str
    verdict: Verdict
    evidence: str

    @property
    def title(self) -> str:
        """What a skill that keeps the rule does."""
        return RULES[self.rule][0]

    @property
    def advice(self) -> str:
        """What to do if it failed, else ""."""
        if self.verdict != "failed":
            return ""
        causes = _LETTING_GO if self.rule == "halting" else {}
        return next((advice for cause, advice in causes.items() if cause in self.evidence), RULES[self.rule][1])


@dataclass(frozen=True)
class SkillCheck:
    """What came of trying a skill against the contract.

    Attributes:
        skill: its name in trees.
        place: where it is written.
        rules: what came of each rule, by its name.
    """

    skill: str
    place: str
    rules: Mapping[str, RuleResult]

    @property
    def passed(self) -> bool:
        """Whether it keeps every rule."""
        return all(result.verdict == "passed" for result in self.rules.values())

    @property
    def failed(self) -> tuple[str, ...]:
        """The rules that it breaks."""
        return tuple(name for name, result in self.rules.items() if result.verdict == "failed")

    def assert_passed(self) -> None:
        """Fail a test unless the skill keeps every rule.

        Raises:
            AssertionError: it breaks some; those that it does not keep as text.
        """
        if not self.passed:
            raise AssertionError(self.text(kept=False))

    def text(self, width: int | None = None, kept: bool = True) -> str:
        """Return every rule with what shows it and what to do, first those that are broken.

        Args:
            width: longest line; that of the terminal if not given.
            kept: also those that are kept.
        """
        return "\n".join(self._lines(max(width or shutil.get_terminal_size().columns, 40), kept))

    def __str__(self) -> str:
        return self.text()

    def _lines(self, width: int, kept: bool) -> Iterator[str]:
        of = {verdict: [one for one in self.rules.values() if one.verdict == verdict] for verdict in _MARKS}
        count = f"{len(of['passed'])} of {len(self.rules)}"
        yield from textwrap.wrap(f"{self.skill} keeps {count} rules of skills ({self.place})", width)
        rows = [("failed", one.title, one.evidence, one.advice) for one in of["failed"]]
        rows += [("passed", one.title, one.evidence, "") for one in of["passed"] if kept]
        for reason in dict.fromkeys(one.evidence for one in of["not tried"]):
            titles = ", ".join(one.title for one in of["not tried"] if one.evidence == reason)
            rows.append(("not tried", "not tried", f"{titles}: {reason}", ""))
        column = max(len(title) for title, _ in RULES.values())
        for verdict, title, evidence, advice in rows:
            head = f"  {_MARKS[verdict]} {title.ljust(column)}  "
            indent = " " * (len(head) if width >= 2 * len(head) else 6)
            yield from textwrap.wrap(head + evidence, width, subsequent_indent=indent)
            if advice:
                yield from textwrap.wrap(f"→ {advice}", width, initial_indent=indent, subsequent_indent=indent)
