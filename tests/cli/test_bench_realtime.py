"""What ``bench --realtime`` prints and writes, of figures that are made up."""

from __future__ import annotations

import json
from collections.abc import Callable, Generator
from pathlib import Path

import pytest

from humanoid_bt.bench.baseline import SAME_LOOP
from humanoid_bt.bench.promises import PROTECTIVE_STOP
from humanoid_bt.bench.punctuality import Punctuality
from humanoid_bt.bench.reactions import Reaction
from humanoid_bt.bench.realtime import OURS, Note
from humanoid_bt.bench.ticks import RecordedTicks, Ticks
from humanoid_bt.cli import bench_realtime, main

Figures = Generator[Punctuality | Reaction | RecordedTicks | Note]


@pytest.fixture(autouse=True)
def figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put made-up figures in the place of the measurement; the terminal is a small one."""

    def measure(duration: float, repetitions: int, progress: Callable[[str], None]) -> Figures:
        progress("something")
        cycles = round(duration * 1000)
        for loaded in (False, True):
            yield Punctuality(SAME_LOOP, loaded, True, cycles, 0, 0.02, 10.0, 80.0, 90.0, 0.0, 20.0)
            yield Punctuality(OURS, loaded, False, cycles, 3, 0.03, 25.0, 160.0, 8123.4, 0.1, 30.0)
            yield Reaction("decision killed", "protective stop", loaded, repetitions, (90.0, 99.96), 2, PROTECTIVE_STOP)
            yield Reaction("perception killed", "percept lost", loaded, repetitions, (), 2)
            recorded = Ticks(loaded, True, 500, 1.5, 0.5, 3.0, 9.0, 0, 0.0)
            yield RecordedTicks(recorded, Ticks(loaded, False, 500, 0.5, 0.5, 2.0, 9.0, 0, 0.0))
        yield Note("something to know")

    monkeypatch.setattr(bench_realtime, "measure_realtime", measure)
    monkeypatch.setenv("COLUMNS", "80")


def test_the_tables_fit_a_small_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--realtime", "--repetitions", "3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    rows = [" ".join(line.split()) for line in lines]
    assert "idle servo 0.0 25.0 160 8123 30.0 3/10003" in rows
    assert rows.count("servo to C - 2.5x 2.0x 90.3x 1.5x") == 2
    assert "load decision killed 90.0 100.0 100.0 <= 120 ms 2/3 2/3 missed" in rows
    assert "perception killed - - - 0/3 2/3 missed" in rows
    assert "load with a recording 1.50 0.50 3.00 9.00 0 0.0 s ok" in rows
    assert rows.count("without 0.50 0.50 2.00 9.00 0") == 2
    assert "note: something to know" in rows
    assert any("ulimit -r" in row for row in rows), "control had no realtime priority"
    assert "[us]" in lines[0]


def test_the_file_holds_every_figure(tmp_path: Path) -> None:
    file = tmp_path / "board.json"
    assert main(["bench", "--realtime", "--duration", "2", "--repetitions", "2", "--json", str(file)]) == 0
    data = json.loads(file.read_text(encoding="utf-8"))
    assert (data["duration"], data["repetitions"]) == (2.0, 2)
    assert {"machine", "versions", "cores", "notes"} <= data.keys()
    assert [loop["loop"] for loop in data["loops"]] == [SAME_LOOP, OURS] * 2
    killed = data["reactions"][0]
    assert killed["delays"] == [90.0, 99.96]
    assert (data["ticks"][1]["added"], data["ticks"][1]["verdict"]) == (1.0, "ok")
    assert (killed["p50"], killed["p99"], killed["max"], killed["verdict"]) == (90.0, 99.96, 99.96, "ok")
