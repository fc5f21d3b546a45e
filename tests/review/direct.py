"""A recorder in the process of the test: the same recording without the second that a process takes to come up."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Self

import pytest

from humanoid_bt.core.messages import Array, Level
from humanoid_bt.perception.track import Track
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.tick import Tick
from humanoid_bt.session import drive
from humanoid_bt.session.options import RunOptions

_SAVED = 100  # cycles between two blocks of the flight log


class DirectRecorder:
    """Records a run at once."""

    url, missing = "", 0.0

    def __init__(self) -> None:
        self._recorder: Recorder | None = None
        self._news: list[tuple[Level, str]] = []

    def open(self, **setup: Any) -> None:
        self._recorder = Recorder(**setup, tell=lambda level, text: self._news.append((level, text)))

    def sample(
        self, tick: Tick, tracks: Mapping[str, Track], objects: Mapping[str, Array], hidden: Iterable[str] = ()
    ) -> None:
        assert self._recorder is not None
        self._recorder.sample(tick.state, tracks, objects, frozenset(hidden), tick.encode())
        if tick.state.cycle % _SAVED == 0:
            self._recorder.save()

    def cycles(self, plans: Array, cycles: Array) -> None:
        assert self._recorder is not None
        self._recorder.cycles(plans.copy(), cycles.copy())  # as the way to another process does: they are a table's own

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return what takes the other calls."""
        return getattr(self._recorder, name)  # type: ignore[no-any-return]  # as the recorder has it

    def take_news(self) -> list[tuple[Level, str]]:
        news, self._news = self._news, []
        return news

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._recorder is not None:
            self._recorder.close()


@contextmanager
def recorded_directly() -> Iterator[None]:
    """Record lockstep runs in this process."""
    made = drive.new_recorder

    def new(options: RunOptions) -> Any:
        return DirectRecorder() if options.mode == "lockstep" and options.sinks.active else made(options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drive, "new_recorder", new)
        yield
