"""``humanoid-bt recordings`` and ``keep``."""

from __future__ import annotations

import fcntl
import json
from pathlib import Path

import pytest

from humanoid_bt.cli import main
from humanoid_bt.record.parts import MAGIC


@pytest.fixture
def runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of two recordings, one of which is of a run that came to its end."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    folder = tmp_path / "runs"
    folder.mkdir()
    (folder / "fetch-20260101-120000.rrd").write_bytes(MAGIC + bytes(1_299_900))
    (folder / "fetch-20260101-120000.part002.rrd").write_bytes(MAGIC)
    (folder / "fetch-20260101-120000.json").write_text('{"outcome": "success", "sim_time": 12.62}')
    (folder / "walk-20260102-120000.rrd").write_bytes(MAGIC)
    return folder


def shown(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 0) -> str:
    """Return what a command prints."""
    assert main(arguments) == code
    out, err = capsys.readouterr()
    return err if code else out


def test_recordings_are_listed_newest_first(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert shown(capsys, "recordings").splitlines() == [
        "2026-01-02 12:00:00  walk   unknown          4 B     runs/walk-20260102-120000.rrd",
        "2026-01-01 12:00:00  fetch  success  12.6 s  1.3 MB  runs/fetch-20260101-120000.rrd, 2 parts",
        "2 of at most 500, 1.3 MB of at most 20 GB",
    ]


def test_a_narrow_terminal_gets_all_of_it(
    runs: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for width in (60, 80):
        monkeypatch.setenv("COLUMNS", str(width))
        lines = shown(capsys, "recordings").splitlines()
        assert max(map(len, lines)) <= width
        assert "    runs/fetch-20260101-120000.rrd, 2 parts" in lines


def test_one_that_is_written_says_so(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with (runs / "walk-20260102-120000.rrd").open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        assert "walk   being written" in shown(capsys, "recordings")


def test_programs_get_all_of_them(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    walk, fetch = json.loads(shown(capsys, "recordings", "--json"))
    assert fetch == {
        "recording": "runs/fetch-20260101-120000.rrd",
        "tree": "fetch",
        "began": "2026-01-01T12:00:00",
        "outcome": "success",
        "sim_time": 12.62,
        "size": 1_299_949,
        "parts": ["runs/fetch-20260101-120000.rrd", "runs/fetch-20260101-120000.part002.rrd"],
        "kept": False,
        "being_written": False,
    }
    assert (walk["outcome"], walk["sim_time"]) == (None, None)


def test_of_many_the_newest_are_shown(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number in range(30):
        (runs / f"walk-20260103-1200{number:02}.rrd").write_bytes(MAGIC)
    lines = shown(capsys, "recordings").splitlines()
    assert len(lines) == 22
    assert lines[-1] == "12 older ones are not shown: --all"
    assert len(shown(capsys, "recordings", "--all").splitlines()) == 33


def test_without_recordings_it_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert shown(capsys, "recordings") == "0 of at most 500, 0 B of at most 20 GB\n"
    assert json.loads(shown(capsys, "recordings", "--json")) == []


@pytest.mark.parametrize(
    "name",
    [
        "fetch-20260101-120000",
        "fetch-20260101-120000.rrd",
        "runs/fetch-20260101-120000.rrd",
        "runs/fetch-20260101-120000.part002.rrd",
        "./runs/fetch-20260101-120000.json",
    ],
)
def test_one_is_kept_and_no_longer(runs: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    mark = runs / "fetch-20260101-120000.keep"
    assert shown(capsys, "keep", name) == "kept: runs/fetch-20260101-120000.rrd\n"
    assert mark.exists()
    assert shown(capsys, "keep", name) == "kept already: runs/fetch-20260101-120000.rrd\n"
    text = shown(capsys, "recordings")
    assert "2 parts, kept" in text
    assert text.splitlines()[2:] == ["1 of at most 500, 4 B of at most 20 GB", "1 kept besides, 1.3 MB"]
    assert shown(capsys, "keep", "--undo", name) == "no longer kept: runs/fetch-20260101-120000.rrd\n"
    assert not mark.exists()


def test_all_files_of_one_are_one(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = [str(path) for path in sorted(runs.iterdir())]
    assert shown(capsys, "keep", *names).splitlines() == [
        "kept: runs/fetch-20260101-120000.rrd",
        "kept: runs/walk-20260102-120000.rrd",
    ]


def test_names_that_are_wrong_keep_nothing(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = shown(capsys, "keep", "walk-20260102-120000", "fetch-20260101-120001", code=2)
    assert "no recording 'fetch-20260101-120001'" in text
    assert "did you mean 'fetch-20260101-120000'?" in text
    text = shown(capsys, "keep", "elsewhere/fetch-20260101-120000.rrd", code=2)
    assert "'elsewhere/fetch-20260101-120000.rrd' is not in 'runs'" in text
    assert "only recordings in 'runs' are ever removed" in text
    assert not list(runs.glob("*.keep"))


def test_where_nothing_is_nothing_can_be_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "there is none in 'runs' here" in shown(capsys, "keep", "fetch", code=2)


def test_mistakes_in_the_limits_are_shown(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (runs / "limits.yaml").write_text("size: much\n")
    assert "runs/limits.yaml:1:7: error: 'size' must be a size" in shown(capsys, "recordings", code=2)
