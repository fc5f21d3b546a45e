"""How a campaign goes, while it runs: a line that moves on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Self

from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from humanoid_bt.campaign.conduct import Progress
from humanoid_bt.campaign.statistics import Rate
from humanoid_bt.campaign.summary import between, percent
from humanoid_bt.campaign.workers import Done
from humanoid_bt.cli.console import SafeConsole

_EVERY = 30.0  # s between two lines where there is no terminal
_BAR = 16  # columns


class CampaignProgress(Progress):
    """Shows how a campaign goes.

    Args:
        console: where.
        total: how many trials there are to be.
        before: of those that are done already, how many succeeded.
        quiet: show nothing.
    """

    def __init__(self, console: SafeConsole, total: int, before: Rate, quiet: bool) -> None:
        self._console, self._total, self._quiet = console, total, quiet
        self._begun = before.of
        self._done, self._good = before.of, before.count
        self._since = self._told = time.monotonic()
        self._explaining = self._explained = 0
        live = console.is_terminal and not quiet
        self._live = (
            Live(console=console, refresh_per_second=4, transient=True, get_renderable=self._row) if live else None
        )

    def trial(self, done: Done) -> None:
        """Count a trial."""
        self._done += 1
        self._good += done.result.succeeded
        self._tell(last=self._done == self._total)

    def explaining(self, count: int) -> None:
        """Say that some failures are recorded now."""
        self._explaining = count
        if not self._live and not self._quiet:
            self._console.print(f"recording {count} of the failures, to explain them")

    def explained(self, done: Done) -> None:
        """Count one of them."""
        self._explained += 1

    def __enter__(self) -> Self:
        if self._live:
            self._live.start()
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        if self._live:
            self._live.stop()

    def _tell(self, last: bool) -> None:
        """Print a line if there is no terminal, and the last one is a while ago."""
        now = time.monotonic()
        if not self._quiet and not self._live and (last or now - self._told >= _EVERY):
            self._told = now
            self._console.print("  ".join(self._words()), soft_wrap=True)

    def _words(self) -> list[str]:
        """Return what there is to say: how many, how fast, how good, how long."""
        if self._explaining:
            return [f"{self._explained}/{self._explaining} failures recorded and explained"]
        passed, here = time.monotonic() - self._since, self._done - self._begun
        words = [f"{self._done}/{self._total} trials"]
        if here:
            words.append(f"{here / passed:.1f}/s")
        if self._done:
            rate = Rate(self._good, self._done)
            words.append(f"{percent(rate.share)} succeed ({between(rate.interval)})")
        if here and self._done < self._total:
            words.append(f"{duration(passed / here * (self._total - self._done))} left")
        return words

    def _row(self) -> Table:
        done, total = (self._explained, self._explaining) if self._explaining else (self._done, self._total)
        row = Table.grid(padding=(0, 2))
        row.add_row(
            ProgressBar(total or 1, done, width=_BAR), Text("  ".join(self._words()), no_wrap=True, overflow="ellipsis")
        )
        return row


def duration(seconds: float) -> str:
    """Return a time on the wall clock as people read it."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {seconds} s"
