"""``humanoid-bt test``: what it prints, writes and records, and how it exits."""

from __future__ import annotations

import json
import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from humanoid_bt.cli import main
from humanoid_bt.review.replay import replay
from tests.projects import make_project

SCENARIOS = {
    "good": "tree: wait\nseeds: 0-2\nexpect: {within 1 s: outcome == success}\n",
    "bad": (
        "tree: give_up\nseeds: 4\nexpect:\n  - never: fell\n"
        "  - outcome == success and contains(give_up.feedback, 'there')\n  - order: [give_up, give_up succeeded]\n"
    ),
}

MARK = """
import tempfile
from humanoid_bt import Skill, Status

class Mark(Skill):
    \"\"\"Leave a file behind for every run that begins.\"\"\"

    def update(self) -> Status:
        tempfile.NamedTemporaryFile(dir=".", suffix=".begun", delete=False).close()
        return self.succeed("marked")
"""

DIE = """
import os
from humanoid_bt import Skill


class Die(Skill):
    def update(self):
        os._exit(9)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = make_project(tmp_path_factory.mktemp("user") / "project")
    (folder / "scenarios").mkdir()
    for name, text in SCENARIOS.items():
        (folder / "scenarios" / f"{name}.yaml").write_text(f"format: 1\ndry: true\n{text}", encoding="utf-8")
    return folder


@pytest.fixture(autouse=True)
def in_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "60")


@pytest.fixture(scope="module")
def told(folder: Path) -> tuple[int, str]:
    """Run all scenarios once: exit code, what is printed; JUnit's XML is in junit.xml."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("COLUMNS", "60")
        with (folder / "out.txt").open("w", encoding="utf-8") as stream:
            patch.setattr("sys.stdout", stream)
            code = main(["test", "--junit", "junit.xml"])
    return code, (folder / "out.txt").read_text(encoding="utf-8")


def test_what_fails_is_told_with_its_place_the_moment_and_the_values(told: tuple[int, str]) -> None:
    code, out = told
    assert code == 1
    out = re.sub(r"\d{8}-\d{6}", "DATE", re.sub(r"in [\d.]+ s", "in T s", out))
    assert out.splitlines()[:15] == [
        "✗ bad   1 seed, 0.00 s in T s, dry",
        "  seed 4: failure: give_up: the thing is not there",
        "    scenarios/bad.yaml:7:5: outcome == success and",
        "    contains(give_up.feedback, 'there')",
        "      at 0.00 s it was not so at the end",
        "        outcome: failure",
        "        give_up.feedback: the thing is not there",
        "    scenarios/bad.yaml:8:5: order: [give_up, give_up",
        "    succeeded]",
        "      at 0.00 s 'give_up succeeded' did not come after that",
        "        give_up: came at 0.00 s",
        "        give_up succeeded: did not come",
        "    recording  runs/bad-seed4-DATE.rrd",
        "    explain it humanoid-bt explain runs/bad-seed4-DATE.rrd",
        "    try again  humanoid-bt test scenarios/bad.yaml --seeds 4",
    ]
    assert out.splitlines()[-2:] == ["✓ good  3 seeds, 0.60 s in T s, dry", "1 scenario passed, 1 scenario failed"]


def test_the_recording_is_that_of_the_run(told: tuple[int, str], folder: Path) -> None:
    recordings = re.findall(r"^    recording  (\S+)$", told[1], re.MULTILINE)
    assert [Path(name).name[:9] for name in recordings] == ["bad-seed4"]
    assert (folder / recordings[0]).stat().st_size > 1000


def test_junit_xml_has_a_case_for_each_seed(told: tuple[int, str], folder: Path) -> None:
    suites = ElementTree.parse(folder / "junit.xml").getroot()
    assert [(suite.get("name"), suite.get("tests"), suite.get("failures")) for suite in suites] == [
        ("bad", "1", "1"),
        ("good", "3", "0"),
    ]
    assert [case.get("name") for case in suites[1]] == ["seed 0", "seed 1", "seed 2"]
    failure = suites[0][0].find("failure")
    assert failure is not None and failure.text is not None
    assert failure.get("message", "").startswith("outcome == success and contains")
    assert "humanoid-bt test scenarios/bad.yaml --seeds 4" in failure.text


def test_programs_get_a_list_of_runs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["test", "scenarios/bad.yaml", "good", "--seeds", "7-8", "--json", "--no-record"]) == 1
    runs = json.loads(capsys.readouterr().out)
    assert [(run["scenario"], run["seed"], run["passed"], run["recording"]) for run in runs] == [
        ("bad", 7, False, ""),
        ("bad", 8, False, ""),
        ("good", 7, True, ""),
        ("good", 8, True, ""),
    ]
    assert runs[0]["failures"][0]["place"] == "scenarios/bad.yaml:7:5"
    assert runs[0]["failures"][0]["values"] == {"outcome": "failure", "give_up.feedback": "the thing is not there"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing"], "no scenario named 'nothing'"),
        (
            ["scenarios/goood.yaml"],
            "no scenario file 'scenarios/goood.yaml' [unknown-scenario]\n    did you mean 'good'?",
        ),
        (["trees", "skills"], "no scenarios in 'skills'"),
        (["good", "--seeds", "3-1"], "'3-1' are no seeds"),
        (["good", "-j", "0"], "must be a whole number above 0, not '0'"),
        (["good", "--junit", "trees/wait.yaml"], "--junit would overwrite 'trees/wait.yaml'"),
        (["good", "--junit", "nowhere/junit.xml"], "the results cannot be written to 'nowhere/junit.xml'"),
        (["trees/wait.yaml"], "trees/wait.yaml:2:1: error: unknown key 'root' of the scenario"),
        (["--workspace", "skills"], "no scenarios in 'skills'"),
    ],
)
def test_mistakes_are_told_before_anything_runs(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = main(["test", *arguments])
    except SystemExit as end:
        code = int(str(end.code))
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    assert message in err


@pytest.mark.trials
def test_a_terminal_shows_colors_in_lines_that_fit(folder: Path) -> None:
    code, out = on_terminal(folder, ["test", "bad", "--seeds", "0", "--no-record"], columns=44)
    assert code == 1
    assert "\x1b[" in out
    plain = re.sub(r"\x1b\[[\d;?]*[A-Za-z]", "", out).replace("\r", "\n")
    told = [line for line in plain.splitlines() if "try again" not in line]
    assert any(line.startswith("✗ bad") for line in told)
    assert max(map(len, told)) <= 44


@pytest.mark.trials
def test_several_processes_give_the_same_answers_in_the_same_order(folder: Path) -> None:
    command = [sys.executable, "-m", "humanoid_bt", "test", "--json", "--no-record"]
    one, two = (as_json([*command, "-j", jobs], folder) for jobs in ("1", "2"))
    for run in (*one, *two):
        del run["wall_time"]
    assert one == two
    assert len(one) == 4


@pytest.mark.trials
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_ctrl_c_tells_what_was_done(folder: Path, tmp_path: Path, jobs: str) -> None:
    for name, text in {
        "skills/mark.py": MARK,
        "trees/marked.yaml": "format: 1\nroot: {emergency_stop: {sequence: [mark, idle]}}\n",
        "long.yaml": "format: 1\ntree: marked\nseeds: 0-99\nduration: 3 s\nexpect: not fell\n",
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "humanoid_bt", "test", "long.yaml", "-j", jobs, "--junit", "junit.xml"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while process.poll() is None and len(list(tmp_path.glob("*.begun"))) < 4:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (130, "")
    told = r"○ long  (\d+) seeds? of 100, .*\n0 scenarios passed, interrupted after (\d+) of 100 runs\n"
    found = re.fullmatch(told, out)
    assert found is not None, out
    assert found[1] == found[2]
    assert len(ElementTree.parse(tmp_path / "junit.xml").getroot()[0]) == int(found[1])


@pytest.mark.trials
def test_a_process_that_dies_is_one_clear_message(tmp_path: Path) -> None:
    for name, text in {
        "skills/die.py": DIE,
        "trees/die.yaml": "format: 1\nroot: {emergency_stop: die}\n",
        "scenarios/die.yaml": "format: 1\ntree: die\ndry: true\nseeds: 0-3\nexpect: not fell\n",
    }.items():
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "humanoid_bt", "test", "-j", "2"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 4
    message = "error: a process that tried scenarios has died, out of memory perhaps; 0 of 4 runs are done\n"
    assert done.stderr == message


def test_of_what_failed_a_percept_that_could_never_come_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "format: 1\ntree: fetch\ndry: true\nparameters: {target: bal}\nduration: 0.1 s\nexpect: outcome == success\n"
    (tmp_path / "slip.yaml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["test", "slip.yaml", "--no-record"]) == 1
    assert re.search(r"note +the scene 'ball_on_stand' publishes no percept 'bal' \(valid: ", capsys.readouterr().out)


@pytest.mark.trials
def test_a_recorded_failure_is_bit_for_bit_the_run_that_failed(folder: Path, tmp_path: Path) -> None:
    text = "format: 1\ntree: fetch\nduration: 2 s\nexpect: outcome == success\n"
    (tmp_path / "short.yaml").write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "humanoid_bt", "test", "short.yaml", "--json"]
    (run,) = as_json(command, tmp_path)
    assert (run["note"], run["outcome"]) == ("", "unfinished")
    again = replay(tmp_path / run["recording"])
    assert again.outcome == "unfinished" and again.difference is None


def as_json(command: list[str], folder: Path) -> Any:
    return json.loads(subprocess.run(command, cwd=folder, capture_output=True, check=False).stdout)


def on_terminal(folder: Path, arguments: list[str], columns: int) -> tuple[int, str]:
    """Run the command line on a terminal; return its exit code and what it wrote."""
    ours, theirs = pty.openpty()
    environment = os.environ | {"COLUMNS": str(columns), "TERM": "xterm-256color"}
    command = [sys.executable, "-m", "humanoid_bt", *arguments]
    process = subprocess.Popen(command, cwd=folder, stdout=theirs, stderr=theirs, stdin=theirs, env=environment)
    os.close(theirs)
    written = b""
    try:
        while part := os.read(ours, 65536):
            written += part
    except OSError:  # the other side is closed
        pass
    os.close(ours)
    return process.wait(30), written.decode()
