"""What whoever runs trials answers, in whatever process or on whatever machine that is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from humanoid_bt.campaign.result import Explained, Result
from humanoid_bt.campaign.trial import Task
from humanoid_bt.core.errors import HumanoidBtError, Problem, UserError

Answer = tuple[Result, Explained | None, float]
"""What came of a task, what its recording shows, and how long of it was simulation [s]."""

Run = Callable[[Task], Answer]
"""Runs a task."""


@dataclass(frozen=True)
class Refused:
    """Why a task cannot be run at all, as it is told to another process.

    Attributes:
        text: why.
        problems: the mistakes of a user's that it is for, if it is.
    """

    text: str
    problems: tuple[Problem, ...] = ()

    @classmethod
    def of(cls, error: HumanoidBtError) -> Refused:
        """Return what an error says."""
        return cls(str(error), error.problems if isinstance(error, UserError) else ())

    @property
    def error(self) -> HumanoidBtError:
        """The error that said it, or one as good."""
        return UserError(self.problems) if self.problems else HumanoidBtError(self.text)
