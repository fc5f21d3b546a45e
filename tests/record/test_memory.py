"""Recording for hours does not fill the memory."""

from __future__ import annotations

import gc
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.record.parts import part_of
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.sinks import Sinks
from tests.record.helpers import make_state
from tests.record.test_parts import LAYOUT, tick

Maker = Callable[..., Recorder]
ALLOWED = 100_000  # bytes: caches of the libraries, which are full some time


def grown(work: Callable[[int], object]) -> int:
    """Return by how many bytes of Python's memory six rounds of work grow it, after two others."""
    tracemalloc.start()
    try:
        for number in range(2):
            work(number)
        gc.collect()
        before, _ = tracemalloc.get_traced_memory()
        for number in range(2, 8):
            work(number)
        gc.collect()
        return tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()


@pytest.mark.trials
@pytest.mark.parametrize("part_size", [1, 10_000_000], ids=["parts", "one file"])
def test_the_recorder_keeps_nothing_of_what_it_has_written(record: Maker, tmp_path: Path, part_size: int) -> None:
    """A round is a second: six of them have 1 MB of servo cycles alone."""
    file = tmp_path / "run.rrd"
    with record(sinks=Sinks(file, part_size=part_size)) as recorder:

        def second(number: int) -> None:
            for index in range(50 * number, 50 * (number + 1)):
                tick(recorder, index)
                recorder.node_changed(0.02 * index, "root/reach", ("RUNNING", "FAILURE")[index % 2], f"{index} times")
                recorder.event(0.02 * index, "info", f"it is {index}")
                recorder.results(0.02 * index, "root/reach", [])
            recorder.write()

        assert grown(second) < ALLOWED
        assert part_of(file, 2).exists() == (part_size == 1)


def test_what_control_does_while_decision_hangs_is_written(record: Maker) -> None:
    with record() as recorder:
        recorder.sample(make_state(0.0), {}, {})

        def second(_number: int) -> None:
            recorder.cycles(np.zeros((200, LAYOUT.plan.width)), np.zeros((1000, LAYOUT.cycle.width)))
            recorder.write()

        assert grown(second) < ALLOWED
