"""Trials that are run only for as long as no file changes that they depend on."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from humanoid_bt.campaign.conduct import Runners
from humanoid_bt.campaign.digests import changes, digests
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.workers import Done
from humanoid_bt.core.errors import UserError


class Unchanged:
    """Runs trials as others do, until a file changes that these depend on.

    Args:
        runners: who runs them, and reads files as it needs them.
        files: every file, by what it is called.
        before: what :func:`digests` returned of them.
    """

    def __init__(self, runners: Runners, files: Mapping[str, Path], before: Mapping[str, str]) -> None:
        self._runners, self._files, self._before = runners, files, before

    def run(self, tasks: Iterable[Task]) -> Iterator[Done]:
        """Yield tasks as they are done, each once.

        Raises:
            UserError: a file has changed.
        """
        for done in self._runners.run(tasks):
            if names := changes(self._before, digests(self._files)):
                hint = "put it back to go on, or begin anew with another --out"
                raise UserError(f"changed while the campaign ran: {', '.join(names)}", hint=hint)
            yield done

    def close(self) -> None:
        """Leave nothing running."""
        self._runners.close()
