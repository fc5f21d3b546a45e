"""What came of trying something against the rules that control has for all of its kind."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RuleOutcome:
    """What came of one rule.

    Attributes:
        name: of the rule.
        passed: whether it is kept.
        shown: what shows it.
    """

    name: str
    passed: bool
    shown: str

    def __str__(self) -> str:
        return f"{'passed' if self.passed else 'FAILED'}  {self.name:<10} {self.shown}"


@dataclass(frozen=True)
class Conformance:
    """What came of all of them.

    Attributes:
        subject: what was tried, as in "the body of humanoid".
        rules: every rule that was tried.
    """

    subject: str
    rules: tuple[RuleOutcome, ...]

    @property
    def passed(self) -> bool:
        """Whether all rules are kept."""
        return all(rule.passed for rule in self.rules)

    def assert_passed(self) -> None:
        """Raise if they are not.

        Raises:
            AssertionError: with what came of every rule.
        """
        if not self.passed:
            raise AssertionError(str(self))

    def __str__(self) -> str:
        return "\n".join([self.subject, *map(str, self.rules)])
