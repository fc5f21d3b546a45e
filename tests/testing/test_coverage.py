"""Tree coverage in a user's own project: what pytest and the command line say of what was tried."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from typing import Any

import pytest

import humanoid_bt.testing.rig  # noqa: F401 (the inner pytest forgets what it imports, and numpy loads only once)
from humanoid_bt.cli import main
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.testing import coverage
from humanoid_bt.testing.coverage import TreeCoverage, counting, coverage_in, save, tree_coverage, tree_files
from humanoid_bt.testing.coverage_page import page
from humanoid_bt.tree.counting import FOLDER
from humanoid_bt.tree.coverage import DEEDS, Coverage, FileCoverage, NodeCoverage
from humanoid_bt.tree.source.load import load_tree
from tests.tree.helpers import Run as ByHand
from tests.tree.helpers import make_workspace, write

CHOOSES = """\
root:
  selector:
    - act: {script: f}
    - act: {name: second, script: rs}
"""
NEVER = "root: {act: {script: s}}\n"

TESTS = """
from pathlib import Path
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.source.load import load_tree
from tests.tree.helpers import Run

def run(ticks):
    life = Run(load_tree(Path(__file__).parent / "trees" / "chooses.yaml", Workspace(Path(__file__).parent)))
    life.ticks(ticks)
    return life

def test_to_the_end():
    assert run(2).executor.status.name == "SUCCESS"

def test_halted():
    run(1).halt()

def test_left_as_it_is():
    run(1)
"""


def trial(*values: str) -> Any:
    return pytest.param(*values, marks=pytest.mark.trials)


@pytest.fixture
def project(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A project with two trees, one of which its tests run."""
    workspace = make_workspace(pytester.path / "project")
    write(workspace, "chooses", CHOOSES)
    write(workspace, "never", NEVER)
    (workspace.root / "test_trees.py").write_text(TESTS, encoding="utf-8")
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2]))
    monkeypatch.delenv(FOLDER, raising=False)
    monkeypatch.chdir(workspace.root)
    return pytester


def run(project: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    return project.runpytest_inprocess("-p", "no:cacheprovider", "--rootdir=.", *arguments)


def test_tells_which_lines_never_did_what(project: pytest.Pytester) -> None:
    result = run(project, "--tree-coverage=trees")
    result.assert_outcomes(passed=3)
    result.stdout.fnmatch_lines(["*tree coverage*"])
    assert [line for line in result.outlines if line.startswith(("trees/", "  ", "all"))] == [
        "trees/chooses.yaml       7/12   58 %",
        "      3  selector: never failure",
        "      4  act: never success, running or halted",
        "      5  second: never failure",
        "trees/never.yaml          0/4    0 %",
        "         never run",
        "all                      7/16   43 %",
    ]
    assert FOLDER not in os.environ


def test_writes_a_page_and_data_and_fails_below_a_threshold(project: pytest.Pytester) -> None:
    files = ("--tree-coverage-html=c.html", "--tree-coverage-json=c.json")
    result = run(project, "--tree-coverage=trees/chooses.yaml", "--tree-coverage-fail-under=60", *files)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["ERROR: 58.3 % of what nodes can do was tried, less than 60 %"])
    page = Path("c.html").read_text(encoding="utf-8")
    assert page.count('class="mark never"') == 1 + 5  # that of the legend
    assert page.count('class="mark seen"') == 4 + 7
    assert '<span class="key">script</span>: rs' in page
    assert "http" not in page, "it needs nothing else"
    data = json.loads(Path("c.json").read_text(encoding="utf-8"))
    assert data["totals"] == {"seen": 7, "possible": 12, "percent": 58.33}
    assert data["files"][0]["file"] == "trees/chooses.yaml"
    assert main(["coverage", "c.json", "--tree", "chooses", "--fail-under", "58.3"]) == 0
    assert main(["coverage", "c.json", "--tree", "chooses", "--fail-under", "60"]) == 1


@pytest.mark.trials
def test_is_content_with_what_is_enough(project: pytest.Pytester) -> None:
    result = run(project, "--tree-coverage=chooses", "--tree-coverage-fail-under=58")
    assert result.ret == pytest.ExitCode.OK


@pytest.mark.trials
def test_a_broken_file_is_never_enough_and_hides_nothing_else(project: pytest.Pytester) -> None:
    write(Workspace(Path.cwd()), "broken", "root: {act: {scrip: s}}\n")
    asked = "--tree-coverage=trees", "--tree-coverage-fail-under=0"
    assert run(project, *asked).ret == pytest.ExitCode.TESTS_FAILED
    assert run(project, *asked, "-k", "none").ret == pytest.ExitCode.NO_TESTS_COLLECTED


def test_counts_nothing_unless_it_is_asked_to(project: pytest.Pytester) -> None:
    assert "tree coverage" not in run(project).stdout.str()


@pytest.mark.parametrize(
    ("argument", "said"),
    [
        ("--tree-coverage=choses", "*no tree named 'choses'*"),
        trial("--tree-coverage=skills", "*no tree files in 'skills'*"),
        trial("--tree-coverage-fail-under=150", "*must be a number from 0 to 100, not '150'"),
        trial("--tree-coverage-html=no/c.html", "*'no/c.html' cannot be written: No such file or directory*"),
    ],
)
def test_what_cannot_be_is_one_message(project: pytest.Pytester, argument: str, said: str) -> None:
    result = run(project, "-k", "halted", argument)
    assert result.ret != pytest.ExitCode.OK
    (result.stdout if "html" in argument else result.stderr).fnmatch_lines([said])


@pytest.mark.trials
def test_workers_and_other_processes_count_too(project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    program = "import sys; sys.path.insert(0, '.'); import test_trees; test_trees.run(1).halt()"
    start = f"subprocess.run([sys.executable, '-c', {program!r}], check=True)"
    Path("test_other.py").write_text(f"import subprocess, sys\ndef test_it():\n    {start}\n", encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
    for tests, seen in (("test_other.py", "5/12"), ("test_trees.py", "7/12")):
        arguments = ("-p", "no:cacheprovider", "--rootdir=.", "-n2", "--tree-coverage=chooses", tests)
        result = project.runpytest_subprocess(*arguments)
        result.stdout.fnmatch_lines([f"trees/chooses.yaml *{seen}*"])


# ---- from Python, and on the command line ---------------------------------------------------------------------------


@pytest.fixture
def halted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A workspace in which the first tree was halted, once; the folder with what was counted lies in it."""
    workspace = make_workspace(tmp_path / "project")
    write(workspace, "chooses", CHOOSES)
    monkeypatch.chdir(workspace.root)
    with counting() as folder:
        life = ByHand(load_tree(workspace.root / "trees" / "chooses.yaml", workspace))
        life.tick()
        life.halt()
        save()
        folder.rename(workspace.root / "counted")
        folder.mkdir()
    return workspace.root


def test_what_was_counted_apart_is_merged(halted: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (halted / "nightly.json").write_text((halted / "counted").glob("*.json").__next__().read_text(), encoding="utf-8")
    assert main(["coverage", "counted", "nightly.json", "--json", "all.json", "--html", "all.html"]) == 0
    assert capsys.readouterr().out.startswith("trees/chooses.yaml       5/12   41 %\n")
    assert Coverage.read(halted / "all.json").files.keys() == coverage_in(halted / "counted").files.keys()


def report_of(*seen: set[str]) -> TreeCoverage:
    """Return what there is to say of nodes that can do all and did this."""
    nodes = {(line, 1): NodeCoverage(line, 1, "n", "act", set(DEEDS), did, True) for line, did in enumerate(seen, 1)}
    return TreeCoverage((FileCoverage(Path("t.yaml"), "", nodes),))


def test_exactly_enough_is_enough() -> None:
    half = report_of({"success", "halted"})
    assert not half.missed(50)
    assert not report_of().missed(100), "all of nothing"
    assert half.missed(50.1) == "50 % of what nodes can do was tried, less than 50.1 %"


def test_nearly_all_is_not_all() -> None:
    nearly = report_of(*[set(DEEDS)] * 499, {"success", "failure", "running"})  # 99.95 %
    assert nearly.shown == "99.9"
    assert nearly.text(100).splitlines() == ["t.yaml  1999/2000   99 %", "    500  n: never halted"]


def test_what_was_ticked_and_did_nothing_was_ticked() -> None:
    assert report_of(set()).text(100).splitlines()[1:] == ["      1  n: never success, failure, running or halted"]


def test_what_a_node_did_and_should_not_be_able_to_is_counted() -> None:
    node = NodeCoverage(1, 1, "n", "act", {"success", "running"}, {"failure"})
    assert (node.counted, node.missing) == (("success", "failure", "running"), ("success", "running"))


@pytest.mark.parametrize("asked", [[], ["."], ["trees"]])
def test_the_trees_of_a_workspace_are_no_scenes_scenarios_and_campaigns(halted: Path, asked: list[str]) -> None:
    for other in ("scenarios/x.yaml", "campaigns/x.yaml", "sim/scenes/x.yaml", "trees/parts/x.yaml"):
        (halted / other).parent.mkdir(parents=True, exist_ok=True)
        (halted / other).write_text("format: 1\n", encoding="utf-8")
    assert [relative(file) for file in tree_files(asked, halted)] == ["trees/chooses.yaml", "trees/parts/x.yaml"]
    shutil.rmtree(halted / "trees")
    with pytest.raises(UserError, match=r"no tree (files|named)"):
        tree_files(asked, halted)


def test_of_an_edited_file_nothing_counts(halted: Path) -> None:
    counted = coverage_in(halted / "counted")
    assert tree_coverage(counted, tree_files(["chooses"], halted)).seen == 5
    write(Workspace(halted), "chooses", "# edited\n" + CHOOSES)
    assert tree_coverage(counted, tree_files(["chooses"], halted)).seen == 0


def test_a_broken_file_is_told_and_is_not_enough(halted: Path) -> None:
    write(Workspace(halted), "broken", "root: {act: {scrip: s}}\n")
    report = tree_coverage(coverage_in(halted / "counted"), tree_files([], halted))
    assert "did you mean 'script'?" in report.text()
    assert "broken.yaml:2:" in report.missed(0)
    assert report.percent == 0


@pytest.mark.parametrize("asked", [[], ["--fail-under", "1"]])
def test_with_a_broken_file_the_command_fails_as_check_does(
    halted: Path, asked: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    write(Workspace(halted), "broken", "root: {act: {scrip: s}}\n")
    assert main(["coverage", "counted", *asked]) == 2
    assert capsys.readouterr().err.startswith("error: trees/broken.yaml:2:")


def test_what_cannot_be_read_is_not_covered(tmp_path: Path) -> None:
    file = tmp_path / "broken.yaml"
    file.write_text("format: 1\nroot: {nosuch: {}}\n")
    report = tree_coverage(Coverage(), [file])
    assert "100 %" not in report.text(80)
    assert "100&thinsp;%" not in page(report)
    assert "all tried" not in page(report)


def test_a_page_of_a_folder_that_is_called_strangely_is_written(tmp_path: Path) -> None:
    coverage.write(tmp_path / "page.html", "b\udcffd")
    assert (tmp_path / "page.html").read_text() == "b?d"


def test_a_narrow_terminal_wraps(halted: Path) -> None:
    report = tree_coverage(coverage_in(halted / "counted"), tree_files([], halted))
    assert max(map(len, report.text(40).splitlines())) <= 40
    assert report.text(40).split() == report.text(100).split()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["trees"], "nothing was counted in 'trees'"),
        (["none.json"], "'none.json' cannot be read: No such file or directory"),
        (["skills/test_skills.py"], "holds no tree coverage"),
        (["counted", "--html", "no/x.html"], "'no/x.html' cannot be written"),
    ],
)
def test_the_command_says_what_is_wrong(
    halted: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], said: str
) -> None:
    assert main(["coverage", *arguments]) == 2
    assert said in capsys.readouterr().err


def test_the_command_wants_a_share(halted: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["coverage", "counted", "--fail-under", "x"])
    assert "must be a number from 0 to 100" in capsys.readouterr().err
