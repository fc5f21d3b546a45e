"""``check``: what it finds in which files, its exit codes, and its forms for people and programs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.checking.codes import CODES
from humanoid_bt.cli import main
from humanoid_bt.cli.reports import as_json, as_sarif
from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.session.report import ExitCode

SOUND = "format: 1\nroot: {emergency_stop: idle}\n"
DOUBTFUL = "format: 1\nroot: {emergency_stop: idle}  # allow no-hysteresis: it is steady\n"
BARE = "format: 1\nroot: idle\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A workspace with nothing in it, the working directory."""
    monkeypatch.chdir(tmp_path)
    for part in ("trees", "skills"):
        (tmp_path / part).mkdir()
    return tmp_path


@pytest.fixture
def in_project(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)


def write(name: str, text: str) -> None:
    Path(name).write_text(text, encoding="utf-8")


def read_json(capsys: pytest.CaptureFixture[str]) -> Any:
    out, err = capsys.readouterr()
    assert err == ""
    return json.loads(out)


@pytest.mark.usefixtures("in_project")
def test_names_files_and_folders_are_taken(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "fetch", "trees/wait.yaml", "skills", "ball_on_stand", "humanoid"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert [line.endswith(": ok") for line in out] == [True] * 5
    assert "skills/mine.py: ok" in out


def test_every_mistake_is_told_with_its_place(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write("trees/good.yaml", SOUND)
    write("trees/bare.yaml", BARE)
    write("trees/broken.yaml", "format: 1\nroot: [\n")
    write("trees/empty.yaml", "")
    assert main(["check"]) == 2
    out = capsys.readouterr().out.splitlines()
    assert out[:2] == [
        "trees/good.yaml: ok",
        "trees/bare.yaml:2:7: error: 'idle' commands gaze, posture outside an emergency_stop [outside-emergency-stop]",
    ]
    assert out[3].startswith("trees/broken.yaml:3:1: error: not valid YAML")
    assert "trees/empty.yaml:1:1: error: the file is empty [syntax]" in out
    assert out[-1] == "3 errors in 4 files"


def test_a_broken_skill_is_told_once(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write("skills/broken.py", "1 +\n")
    for name in ("one", "two"):
        write(f"trees/{name}.yaml", SOUND)
    assert main(["check"]) == 2
    out = capsys.readouterr().out
    assert out.count("the skill file cannot be imported") == 1
    assert ": ok" not in out
    assert out.endswith("1 error in 3 files\n")


def test_what_is_not_there_does_not_keep_the_rest_from_being_checked(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write("trees/good.yaml", SOUND)
    write("trees/bare.yaml", BARE)
    assert main(["check", "gone.yaml", "trees/good.yaml", "skills", "trees/bare.yaml"]) == 2
    out = capsys.readouterr().out
    assert "gone.yaml: error: no file and no tree, scene, robot, scenario, campaign, skill or percept source" in out
    assert "skills: error: nothing to check in 'skills' [no-file]" in out
    assert "trees/good.yaml: ok" in out
    assert "[outside-emergency-stop]" in out


def test_without_files_it_says_what_to_give(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["check"]) == 2
    assert "give names, files or folders" in capsys.readouterr().err


def test_warnings_fail_only_if_asked_to(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write("trees/a.yaml", DOUBTFUL)
    told = "trees/a.yaml:2:31: warning: 'no-hysteresis' is allowed here and does not occur [unused-allow]"
    assert main(["check"]) == 0
    assert capsys.readouterr().out.splitlines() == [told, "    remove it", "1 warning in 1 file"]
    assert main(["check", "--strict"]) == 2
    write("trees/a.yaml", SOUND)
    assert main(["check", "--strict"]) == 0


def test_run_tells_warnings_and_goes_on(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write("trees/a.yaml", DOUBTFUL)
    arguments = ["run", "trees/a.yaml", "--no-record", "--no-view", "--duration", "0.1"]
    assert main(arguments) == ExitCode.UNFINISHED
    assert capsys.readouterr().err.count("warning: 'no-hysteresis' is allowed here") == 1
    assert main([*arguments, "--quiet"]) == ExitCode.UNFINISHED
    assert capsys.readouterr().err == ""


def test_run_refuses_what_cannot_be_allowed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write("trees/a.yaml", SOUND.strip() + "  # allow outside-watchdog: it works\n")
    assert main(["run", "trees/a.yaml", "--no-record", "--no-view"]) == 2
    assert "trees/a.yaml:2:31: error: 'outside-watchdog' is an error" in capsys.readouterr().err


def test_json_has_every_field(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write("trees/a.yaml", BARE)
    write("trees/b.yaml", SOUND)
    assert main(["check", "gone", ".", "--format", "json"]) == 2
    gone, bare = read_json(capsys)
    assert bare == {
        "file": "trees/a.yaml",
        "line": 2,
        "column": 7,
        "severity": "error",
        "code": "outside-emergency-stop",
        "message": "'idle' commands gaze, posture outside an emergency_stop",
        "hint": "emergency_stop: {...}",
    }
    assert (gone["file"], gone["line"], gone["column"]) == ("gone", None, None)


@pytest.mark.parametrize("form", ["json", "sarif"])
def test_without_findings_programs_get_a_document_too(
    form: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write("trees/a.yaml", SOUND)
    assert main(["check", "--format", form]) == 0
    document = read_json(capsys)
    assert document == [] if form == "json" else document["runs"][0]["results"] == []


def check_sarif(log: Any) -> None:
    """Check what SARIF 2.1.0 and code scanning require of a log."""
    assert log["version"] == "2.1.0"
    (run,) = log["runs"]
    driver = run["tool"]["driver"]
    assert driver["name"] and driver["version"]
    assert run["columnKind"] in ("utf16CodeUnits", "unicodeCodePoints")
    names = [rule["id"] for rule in driver["rules"]]
    assert len(set(names)) == len(names)
    for rule in driver["rules"]:
        assert all(rule[key]["text"] for key in ("shortDescription", "fullDescription", "help"))
        assert rule["defaultConfiguration"]["level"] in ("error", "warning", "note")
        assert "helpUri" not in rule
    for result in run["results"]:
        assert result["message"]["text"]
        assert result["level"] in ("error", "warning", "note")
        assert names[result["ruleIndex"]] == result["ruleId"]
        (location,) = result["locations"]
        physical = location["physicalLocation"]
        assert set(physical["artifactLocation"]["uri"]) <= set(
            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~/%:"
        )
        assert physical["region"]["startLine"] >= 1 and physical["region"]["startColumn"] >= 1


def test_sarif_is_what_code_scanning_takes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write("trees/a b ä.yaml", BARE)
    write("trees/c.yaml", DOUBTFUL)
    assert main(["check", "gone", ".", "--format", "sarif"]) == 2
    log = read_json(capsys)
    check_sarif(log)
    results = log["runs"][0]["results"]
    assert [result["level"] for result in results] == ["error", "error", "warning"]
    where = results[1]["locations"][0]["physicalLocation"]
    assert where["artifactLocation"]["uri"] == "trees/a%20b%20%C3%A4.yaml"
    assert where["region"] == {"startLine": 2, "startColumn": 7}
    assert {rule["id"] for rule in log["runs"][0]["tool"]["driver"]["rules"]} == set(CODES)


def test_files_elsewhere_have_absolute_uris() -> None:
    problems = [Problem("odd", Place("/tmp/a b.yaml", 1, 1), code="syntax")]
    result = json.loads(as_sarif(problems))["runs"][0]["results"][0]
    assert result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] == "file:///tmp/a%20b.yaml"
    assert json.loads(as_json(problems))[0]["file"] == "/tmp/a b.yaml"


def test_a_code_is_explained_with_its_example(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "--explain", "no-hysteresis"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("no-hysteresis  warning. A condition")
    assert "wrong:\n    reactive_sequence:" in out and "right:\n    reactive_sequence:" in out
    assert out.endswith("# allow no-hysteresis: and why\n")
    assert main(["check", "--explain", "outside-watchdog"]) == 0
    assert "allow" not in capsys.readouterr().out


def test_all_codes_are_listed_within_the_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "50")
    assert main(["check", "--explain"]) == 0
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 60
    assert all(name in out for name in CODES)


def test_an_unknown_code_gets_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "--explain", "no-hystersis"]) == 2
    assert "did you mean 'no-hysteresis'? all: humanoid-bt check --explain\n" in capsys.readouterr().err
    assert main(["check", "--explain", "zz"]) == 2
    assert capsys.readouterr().err.endswith("; all: humanoid-bt check --explain\n")


def test_where_no_file_is_found_none_are_counted(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "nosuch"]) == 2
    assert capsys.readouterr().out.endswith("\n1 error\n")
