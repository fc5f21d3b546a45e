"""``show``: from a file, and of a run that this process plays."""

from __future__ import annotations

import io
import re
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest
from py_trees.common import Status
from rich.console import Console

from humanoid_bt.cli import main
from humanoid_bt.cli import show as show_module
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.link import run_folder
from humanoid_bt.link.run_folder import RunFolder, RunInfo, lockstep_root
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.live_tree import TreeTeller, TreeWatch
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.tree import Tree


@pytest.fixture(autouse=True)
def in_project(project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand in a project, and let runs live elsewhere than those of a real robot do."""
    monkeypatch.chdir(project)
    monkeypatch.setattr(run_folder, "default_root", lambda: tmp_path / "runs")


class Played:
    """A run in lockstep that does nothing but tell."""

    def __init__(self) -> None:
        workspace = Workspace(builtin_root())
        self.tree: Tree = load_tree(workspace.find_tree("fetch"), workspace)
        self.folder = RunFolder.create(RunInfo("fetch", "humanoid"), lockstep_root())
        channels.create_lockstep_channels(self.folder)
        self.teller = TreeTeller(self.folder)
        for node in self.tree.nodes[:3]:
            node.behaviour.status = Status.RUNNING
        idle = self.tree.nodes[-2].behaviour
        idle.status, idle.feedback_message = Status.RUNNING, "looking around"

    def tell(self, time: float) -> None:
        self.teller.tell({"time": time}, self.tree)

    @property
    def run_id(self) -> str:
        return self.folder.info.run_id

    def watch(self) -> TreeWatch:
        return TreeWatch(self.folder)

    def remove(self) -> None:
        self.teller.close()
        self.folder.close()


@pytest.fixture
def played() -> Iterator[Played]:
    played = Played()
    yield played
    played.remove()


def test_a_file_gets_the_format_of_its_suffix(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    begins = {"txt": "fetch: ", "svg": "<svg ", "dot": "digraph ", "gv": "digraph ", "mmd": "flowchart TD"}
    for suffix, begin in begins.items():
        file = tmp_path / f"fetch.{suffix}"
        assert main(["show", "fetch", "-o", str(file)]) == 0
        assert file.read_text(encoding="utf-8").startswith(begin)
        assert capsys.readouterr().out == f"{file}: 18 nodes of fetch\n"
    file = tmp_path / "any.name"
    assert main(["show", "fetch", "--output", str(file), "--format", "svg"]) == 0
    assert ElementTree.fromstring(file.read_text(encoding="utf-8")).tag.endswith("svg")


@pytest.mark.parametrize(("drawing", "begin"), [("svg", "<svg "), ("mermaid", "flowchart TD"), ("dot", "digraph ")])
def test_a_format_is_printed(drawing: str, begin: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "fetch", "--format", drawing]) == 0
    assert capsys.readouterr().out.startswith(begin)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "which tree? Give its name or file, or --live"),
        (["fetch", "--live"], "TREE does not go with --live"),
        (["fetch", "--run", "x"], "TREE does not go with --run"),
        (["fetch", "-o", "fetch.png"], "'fetch.png' does not say in which format\n    end it in .txt, .svg"),
        (["fetch", "-o", "nowhere/fetch.svg"], "'nowhere/fetch.svg' cannot be written: No such file"),
        (["fech"], "did you mean 'fetch'?"),
        (["--live"], "no robot is running\n    humanoid-bt run TREE starts one"),
        (["--run", "x"], "no run 'x' is running\n    running: none"),
    ],
)
def test_wrong_input_gets_one_message(arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", *arguments]) == 2
    out, err = capsys.readouterr()
    assert says in err
    assert (out, err.count("error:")) == ("", 1)


def test_a_run_is_drawn_with_its_statuses(played: Played, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    played.tell(1.24)
    assert main(["show", "--live"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "fetch: on humanoid at 1.2 s"
    assert lines[1] == "└─ ▶ emergency_stop"
    assert [line.lstrip(" │") for line in lines[-3:]] == [
        "└─ ▶ idle  look_around: true",
        "→ looking around",
        "└─ ○ turn  angle: 120 deg",
    ]
    file = tmp_path / "now.svg"
    assert main(["show", "--live", "-o", str(file)]) == 0
    text = file.read_text(encoding="utf-8")
    assert text.count('class="node skill running"') == 1
    assert "looking around" in text


def test_of_several_runs_one_is_chosen(played: Played, capsys: pytest.CaptureFixture[str]) -> None:
    other = Played()
    played.tell(1.0)
    other.tell(2.0)
    assert main(["show", "--live"]) == 2
    assert f"humanoid-bt show --live --run {other.run_id}   # fetch" in capsys.readouterr().err
    assert main(["show", "--run", other.run_id]) == 0
    assert capsys.readouterr().out.startswith("fetch: on humanoid at 2.0 s")
    other.remove()


def test_a_run_that_tells_nothing_is_an_error(
    played: Played, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(show_module, "_PATIENCE", 0.0)
    assert main(["show", "--live"]) == 4
    assert "the run does not tell what its tree does" in capsys.readouterr().err


def test_a_terminal_follows_a_run_to_its_end(played: Played, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each wait between two looks is a step of the run."""
    steps = iter([lambda: played.tell(2.0), lambda: played.tell(3.0), played.remove])
    monkeypatch.setattr(show_module.time, "sleep", lambda _: next(steps)())
    out = io.StringIO()
    console = Console(file=out, force_terminal=True, width=50, height=40, _environ={"TERM": "xterm"})
    played.tell(1.0)
    watch = played.watch()
    show_module._follow(watch, played.teller._folder.info, console, Namespace(closed=False, depth=None))
    lines = re.sub(r"\x1b\[[\d;?]*[A-Za-z]", "", out.getvalue()).replace("\r", "\n").splitlines()
    titles = [line for line in lines if line.startswith("fetch: ")]
    assert list(dict.fromkeys(titles)) == [f"fetch: on humanoid at {time}.0 s" for time in (1, 2, 3)]
    assert lines[-1] == "the run is over"
    assert max(map(len, lines)) <= 50


def test_what_is_idle_is_folded_where_a_tree_is_too_tall(played: Played) -> None:
    played.tell(1.0)
    moment = played.watch().latest()
    assert moment is not None
    short = Console(force_terminal=True, width=80, height=9)
    text = show_module._colored(moment, moment.outline, short).plain
    assert "act on target (reactive_sequence)  9 below" in text
    assert "approach" not in text
    tall = Console(force_terminal=True, width=80, height=40)
    assert "approach" in show_module._colored(moment, moment.outline, tall).plain
