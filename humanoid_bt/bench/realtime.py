"""Realtime mode measured on this machine: how punctual, how quick to stop, idle and under load, beside C."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from humanoid_bt.bench.baseline import Baseline
from humanoid_bt.bench.busy_cores import load
from humanoid_bt.bench.punctuality import Punctuality, punctuality
from humanoid_bt.bench.reactions import Reaction, reactions
from humanoid_bt.bench.subject import Subject
from humanoid_bt.bench.ticks import RecordedTicks, recorded_ticks
from humanoid_bt.realtime.schedule import last_core

OURS = "servo"
"""The loop of the real control process."""


@dataclass(frozen=True)
class Note:
    """Something that a reader of the figures has to know."""

    text: str


def measure_realtime(
    duration: float, repetitions: int, progress: Callable[[str], None], loads: Sequence[bool] = (False, True)
) -> Generator[Punctuality | Reaction | RecordedTicks | Note]:
    """Measure everything, one figure after the other. Closing the generator ends every process it started.

    Args:
        duration: of each phase of wake-ups [s].
        repetitions: of each reaction.
        progress: told what is measured next.
        loads: with which load, in this order: False for idle, True for every core busy.
    """
    with tempfile.TemporaryDirectory() as folder:
        baseline = Baseline.compile(Path(folder))
        if baseline is None:
            yield Note("no C compiler, or one that cannot compile this here: no baseline")
        for loaded in loads:
            with load() if loaded else nullcontext():
                if baseline is not None:
                    progress(f"{_load(loaded)}: the same loop in C, {duration:g} s")
                    figures = baseline.run(duration, last_core(), loaded)
                    yield from figures or (Note(f"{_load(loaded)}: the loop in C failed: no baseline"),)
                yield from _ours(duration, repetitions, loaded, progress)
                progress(f"{_load(loaded)}: ticks with a recording and without, {duration:g} s each")
                yield recorded_ticks(duration, loaded, Path(folder))


def _ours(
    duration: float, repetitions: int, loaded: bool, progress: Callable[[str], None]
) -> Iterator[Punctuality | Reaction | Note]:
    """Measure the real processes under one load."""
    progress(f"{_load(loaded)}: starting control")
    with Subject() as subject:
        progress(f"{_load(loaded)}: wake-ups of the servo, {duration:g} s")
        woke, late, _, skipped = np.array(subject.collect(duration), dtype=np.int64).reshape(-1, 4).T
        yield punctuality(OURS, loaded=loaded, fifo=subject.fifo, woke=woke, late=late, skipped=skipped)
        progress(f"{_load(loaded)}: reactions, {repetitions} times each")
        for reaction in reactions(subject, repetitions, loaded):
            yield reaction
            progress(f"{_load(loaded)}: reactions; measured: {reaction.cause}")
        if stalls := subject.stalls:
            text = f"{stalls[0]}, and {len(stalls) - 1} more times" if len(stalls) > 1 else stalls[0]
            yield Note(f"{_load(loaded)}: {text}; a stop takes longer then, for silence counts anew")


def _load(loaded: bool) -> str:
    return "under load" if loaded else "idle"
