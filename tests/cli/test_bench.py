"""What ``bench`` prints and writes, of figures that are made up."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from humanoid_bt.bench.figure import Figure
from humanoid_bt.bench.promises import ARMS as ARMS_PROMISE
from humanoid_bt.bench.promises import SPEED as SPEED_PROMISE
from humanoid_bt.bench.promises import TICK as TICK_PROMISE
from humanoid_bt.cli import bench, main
from humanoid_bt.files.workspace import Workspace

ARMS = Figure("arms", "mj_step", "us CPU", 310.0, 200.0, 1.55, 1.5, 1.6, promise=ARMS_PROMISE)
TICK = Figure("tick of a tree", "py_trees", "us CPU", 15.0, 12.0, 1.25, 1.2, 1.3, promise=TICK_PROMISE)
SPEED = Figure("lockstep", "CPU time it took", "s", 12.0, 1.0, 12.0, 11.0, 13.0, promise=SPEED_PROMISE)


@pytest.fixture(autouse=True)
def measured(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Put made-up figures in the place of the measurement; return the trees that are asked for."""
    asked: list[Path] = []

    def measure(_repetitions: int) -> Iterator[Figure]:
        yield SPEED
        yield TICK

    def measure_tree(path: Path, _workspace: Workspace, _repetitions: int) -> Iterator[Figure]:
        asked.append(path)
        yield TICK

    def measure_speed(robot: Path, bodies: Sequence[str], _repetitions: int) -> Iterator[Figure]:
        asked.append(robot)
        for body in bodies:
            yield replace(ARMS, name=f"arms of {body}")

    monkeypatch.setattr(bench, "measure", measure)
    monkeypatch.setattr(bench, "measure_speed", measure_speed)
    monkeypatch.setattr(bench, "measure_tree", measure_tree)
    monkeypatch.setenv("COLUMNS", "50")
    return asked


def test_the_table_fits_a_small_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--repetitions", "3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 50
    text = " ".join(" ".join(lines).split())
    assert "median of 3 pairs" in text
    assert "lockstep 12.00x >= 8x ok" in text
    assert "tick of a tree 1.25x <= 1x missed" in text
    assert "to py_trees: 15 to 12 us CPU" in text


@pytest.mark.parametrize("arguments, tree", [(["--tree"], "fetch"), (["--tree", "stand"], "stand")])
def test_only_a_tree_can_be_measured(
    arguments: list[str], tree: str, measured: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", *arguments]) == 0
    out = capsys.readouterr().out
    assert "tick of a tree" in out and "lockstep" not in out
    assert [path.stem for path in measured] == [tree]


def test_a_tree_that_is_not_there_is_named(measured: list[Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--tree", "fetsch"]) == 2
    assert "did you mean 'fetch'?" in capsys.readouterr().err
    assert measured == []


def test_a_robot_is_measured_with_the_bodies_that_it_has(
    measured: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", "--speed", "--robot", "humanoid"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "arms of dcm 310 us <= 300 us missed" in text
    assert "arms of policy" not in text
    assert [path.parent.name for path in measured] == ["humanoid"]
    assert main(["bench", "--robot", "humanoid"]) == 2
    assert "--robot goes with --body or --speed" in capsys.readouterr().err


def test_trees_and_realtime_are_measured_apart(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["bench", "--tree", "--realtime"])
    assert left.value.code == 2
    assert "not allowed with argument --tree" in capsys.readouterr().err


def test_the_file_holds_every_figure(tmp_path: Path) -> None:
    file = tmp_path / "figures.json"
    assert main(["bench", "--json", str(file), "--repetitions", "2"]) == 0
    data = json.loads(file.read_text(encoding="utf-8"))
    assert {"machine", "versions", "repetitions"} <= data.keys()
    assert [entry["name"] for entry in data["figures"]] == ["lockstep", "tick of a tree"]
    assert data["figures"][1]["ratio"] == 1.25
    assert [entry["verdict"] for entry in data["figures"]] == ["ok", "missed"]
