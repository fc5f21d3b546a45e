"""``humanoid-bt run``: what it prints and how it exits."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from humanoid_bt.cli import main


@pytest.fixture(autouse=True)
def in_project(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("COLUMNS", "80")


@pytest.fixture(scope="module")
def fetched(project: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[int, list[str], dict[str, object]]:
    """Run the demo once: exit code, printed lines, report."""
    folder = tmp_path_factory.mktemp("fetch")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(project)
        patch.delenv("DISPLAY", raising=False)
        out = folder / "out.txt"
        with out.open("w", encoding="utf-8") as stream:
            patch.setattr("sys.stdout", stream)
            arguments = ["--mode", "lockstep", "--seed", "0", "--no-view", "--report", str(folder / "report.json")]
            code = main(["run", "fetch", *arguments, "--record", str(folder / "fetch.rrd")])
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return code, out.read_text(encoding="utf-8").splitlines(), report


@pytest.mark.trials
def test_the_demo_succeeds(fetched: tuple[int, list[str], dict[str, object]]) -> None:
    code, lines, report = fetched
    assert code == report["exit_code"] == 0
    assert lines[0] == "fetch on humanoid in ball_on_stand, seed 0"
    summary = "\n".join(lines[lines.index("") :])
    assert summary.startswith("\nsuccess: reach: ")
    for row in ("simulated", "hand error", "stops      none", "trace", "recording", "open it"):
        assert f"\n  {row}" in summary
    assert f"{report['recording']}" in summary


@pytest.mark.trials
def test_events_come_in_order_with_causes_before_effects(fetched: tuple[int, list[str], dict[str, object]]) -> None:
    _, lines, _ = fetched
    events = lines[1 : lines.index("")]
    times = [float(re.match(r" *(\d+\.\d\d) s . ", line)[1]) for line in events]  # type: ignore[index]  # every line matches
    assert times == sorted(times)
    at = {text: number for number, line in enumerate(events) for text in [line.split(" s ", 1)[1]]}
    lost = at["• scene: ball hidden"]
    assert events[lost + 1].split()[2:4] == ["✗", "confident"]
    assert events[lost + 2].split()[2:5] == ["○", "approach", "halted:"]
    assert events[lost + 3].split()[2:4] == ["▶", "idle"]


@pytest.mark.trials
def test_what_was_not_running_is_not_halted(fetched: tuple[int, list[str], dict[str, object]]) -> None:
    _, lines, _ = fetched
    assert not [line for line in lines if line.rstrip().endswith("halted")]
    ended = next(number for number, line in enumerate(lines) if "✓ reach" in line)
    assert not [line for line in lines[ended:] if "○" in line]


@pytest.mark.parametrize(
    ("tree", "code", "says"),
    [
        ("wait", 0, "success: pause: waited"),
        ("give_up", 1, "failure: give_up: the thing is not there"),
        ("leave", 4, "the node 'leave/emergency_stop/leave' raised SystemExit: 7"),
        ("raise", 4, "the node 'raise/emergency_stop/walk' raised KeyError: 'missing'\n    raised at skills/mine.py:"),
    ],
)
def test_the_exit_code_tells_the_outcome(tree: str, code: int, says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", tree, "--no-record"]) == code
    told = " ".join(capsys.readouterr().out.split())  # however it is wrapped
    assert told.count(" ".join(says.split())) == 1


def test_a_run_that_failed_says_how_to_find_out_why(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "give_up", "--no-view", "--record", "it failed.rrd"]) == 1
    assert "explain it humanoid-bt explain 'it failed.rrd'" in " ".join(capsys.readouterr().out.split())
    assert main(["explain", "it failed.rrd"]) == 0
    assert capsys.readouterr().out.startswith("'give_up' failed at 0.000 s: the thing is not there\n")


def test_an_exception_is_told_once(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "raise", "--no-record", "--report", "raised.json"]) == 4
    out, err = capsys.readouterr()
    assert (out + err).count("KeyError") == 1
    assert "■ walk raised an exception" in out
    report = json.loads((project / "raised.json").read_text(encoding="utf-8"))
    assert report["traceback"].startswith("Traceback")
    assert report["stops"][0]["reason"] == "a node raised an exception"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["fetsh"], "error: no tree named 'fetsh' [unknown-tree]\n    did you mean 'fetch'?"),
        (["trees"], "'trees' is a folder, not a tree"),
        (["./nope.yaml"], "no tree file './nope.yaml'"),
        (["wait", "--robot", "humanoit"], "did you mean 'humanoid'?"),
        (["wait", "--scene", "emtpy"], "did you mean 'empty'?"),
        (["fetch", "--set", "stop=1"], "has no parameter 'stop'"),
        (["fetch", "--set", "stop_distance"], "is not NAME=VALUE"),
        (["fetch", "--set", "stop_distance=abc"], "'stop_distance' must be a number, not text 'abc'"),
        (["fetch", "--set", "stop_distance=1 kg"], "valid: m, cm, mm"),
        (["fetch", "--set", "max_age=1", "--set", "max_age=2"], "give each name once"),
        (["wait", "--record", "missing/run.rrd"], "'missing' is missing\n    mkdir -p missing"),
        (["wait", "--record", "trees"], "is a folder"),
        (["wait", "--no-record", "--report", "missing/report.json"], "the report cannot be written"),
        (["wait", "--no-record", "--report", "trees"], "the report cannot be written"),
        (["wait", "--record", "a.rrd", "--report", "a.rrd"], "'a.rrd' is called like a recording\n    a.json"),
        (["wait", "--no-record", "--view"], "no display"),
        (["wait", "--workspace", "nowhere"], "the workspace 'nowhere' is not a folder"),
    ],
)
def test_a_mistake_is_one_clear_message(arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", *arguments]) == 2
    out, err = capsys.readouterr()
    assert says in err
    assert re.match(r"(\w+=.*: )?error: ", err)
    assert err.count("error: ") == 1
    assert "Traceback" not in out + err


def test_nothing_is_made_for_a_tree_with_mistakes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", "nothing"]) == 2
    assert list(tmp_path.iterdir()) == []
    assert "valid: fetch" in capsys.readouterr().err


def test_a_port_in_use_is_a_mistake(capsys: pytest.CaptureFixture[str]) -> None:
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["run", "wait", "--no-record", "--serve", str(port)]) == 2
    assert f"port {port} is in use" in capsys.readouterr().err


def test_a_tree_file_finds_its_own_workspace(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", str(project / "trees/wait.yaml")]) == 0
    assert "success: pause: waited" in capsys.readouterr().out
    recordings = list((tmp_path / "runs").glob("wait-*.rrd"))
    assert len(recordings) == 1


def test_a_skill_file_with_a_mistake_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "skills").mkdir()
    (tmp_path / "skills/broken.py").write_text("import nothing_of_this_name\n", encoding="utf-8")
    assert main(["run", "stand", "--workspace", str(tmp_path)]) == 2
    err = capsys.readouterr().err
    assert f"{tmp_path / 'skills/broken.py'}:1:1: error: the skill file cannot be imported: ModuleNotFoundError" in err


def test_quiet_prints_the_summary_only(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "wait", "--no-record", "--quiet"]) == 0
    assert capsys.readouterr().out.startswith("\nsuccess: ")


def test_ascii_terminals_get_ascii_signs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.txt"
    with out.open("w", encoding="ascii") as stream:
        monkeypatch.setattr("sys.stdout", stream)
        assert main(["run", "wait", "--no-record"]) == 0
    assert "0.00 s > pause waiting" in out.read_text(encoding="ascii")


AWAY = """
import os

from humanoid_bt import Skill, Status


class GoAway(Skill):
    \"\"\"Let the program work in another folder.\"\"\"

    bounded = True

    def update(self) -> Status:
        os.chdir("elsewhere")
        return self.succeed("gone")
"""


def test_the_report_is_where_it_was_asked_for_wherever_a_skill_goes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("skills", "trees", "elsewhere"):
        Path(folder).mkdir()
    Path("skills/go_away.py").write_text(AWAY, encoding="utf-8")
    Path("trees/away.yaml").write_text("format: 1\nroot: go_away\n", encoding="utf-8")
    assert main(["run", "away", "--no-record", "--report", "report.json", "--quiet"]) == 0
    assert json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["reason"] == "go_away: gone"
