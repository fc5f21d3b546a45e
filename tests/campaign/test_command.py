"""The command, with real trees on the stage: dry where that is enough."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.campaign.store import COSTS, RESULTS
from humanoid_bt.cli import main

pytestmark = pytest.mark.slow

DRY = ["campaign", "fetch", "--dry", "--scene", "random_target", "--seeds", "0-4", "--quiet"]


BAD = """
format: 1
name: bad
tree: fetch
scene: random_target
seeds: 0-1
dry: true
recordings: 0
script: [{at: 0.1 s, raise: {node: reactive_selector}}]
"""
SAY = """
from humanoid_bt import Skill, Status, param


class Say(Skill):
    \"\"\"Say something and fail.\"\"\"

    times: int = param(1, doc="How often.")

    def update(self) -> Status:
        \"\"\"Fail.\"\"\"
        return self.fail(f"{self.times} times")
"""
MINE = """
format: 1
parameters: {times: 3, long: 0.1, label: ""}
root: {sequence: [{wait: $long}, {log: {text: $label}}, {say: {times: $times}}]}
"""


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign whose trials end too early, but for one."""
    out = tmp_path_factory.mktemp("campaign") / "early"
    assert main([*DRY, "--duration", "4.5", "--recordings", "0", "--out", str(out), "--require", "fell == 0"]) == 0
    return out


def test_results_and_reports_are_there(done: Path) -> None:
    assert {path.name for path in done.iterdir() if path.is_file()} >= {
        *(RESULTS, "results.parquet", COSTS, "report.html", "report.md", "summary.json"),
    }
    said = json.loads((done / "summary.json").read_text())
    assert (said["done"], said["planned"]) == (5, 5)
    assert said["success"]["count"] + sum(cause["count"] for cause in said["causes"]) == 5
    assert said["causes"][0]["reason"].startswith("the tree still ran after 4.5 s")


def test_the_page_needs_nothing_but_itself(done: Path) -> None:
    page = (done / "report.html").read_text()
    assert "without physics" in page
    assert page.count("<svg") >= 1
    for outside in ("http://", "https://", "<script", "<link", "src="):
        assert outside not in page


def test_campaigns_are_compared(done: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", "compare", str(done), str(done)]) == 0
    told = capsys.readouterr().out
    assert "nothing differs beyond chance" in told
    assert main(["campaign", "compare", str(done), str(done), "--json", "--out", str(tmp_path / "told.md")]) == 0
    assert json.loads(capsys.readouterr().out)["better"] == []
    assert "nothing differs beyond chance" in (tmp_path / "told.md").read_text(encoding="utf-8")
    assert main(["campaign", "compare", str(done), str(tmp_path)]) == 2
    assert "there is no campaign in" in capsys.readouterr().err


@pytest.mark.trials
def test_parameters_of_a_trial_come_with_what_was_staged(done: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", "rerun", str(done), "1"]) in (0, 5)
    (recording,) = (done / "recordings").iterdir()
    capsys.readouterr()
    assert main(["params", str(recording)]) == 0
    head = capsys.readouterr().out.splitlines()
    assert head[2] == "# staged: dry: without physics, the robot is at once where it is told to be"
    assert head[3] == f"# again: humanoid-bt campaign rerun {done} 1"


def test_a_campaign_without_any_result_is_no_success(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.yaml").write_text(BAD)
    assert main(["campaign", "bad.yaml", "--quiet"]) == 4
    assert capsys.readouterr().err == "no trial came to a result: 2 error\n"


def test_it_goes_on_only_where_that_is_asked(done: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = (done / RESULTS).read_bytes()
    same = [*DRY, "--duration", "4.5", "--recordings", "0", "--out", str(done)]
    assert main(same) == 2
    assert "--resume goes on with it" in capsys.readouterr().err
    assert main([*same, "--resume", "--require", "success > 99 %", "--require", "fell == 0"]) == 1
    told = capsys.readouterr()
    assert "not met: success > 99 %: success is " in told.err
    assert "fell == 0 (fell is 0)" in told.out
    assert told.out.endswith(f"\n    humanoid-bt campaign rerun {done} 2\n"), "not broken, so that it can be copied"
    assert json.loads((done / "summary.json").read_text())["required"] == {"success > 99 %": False, "fell == 0": True}
    assert (done / RESULTS).read_bytes() == table


def test_what_was_killed_before_it_made_its_folder_begins_anew(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*DRY, "--seeds", "0", "--out", str(tmp_path / "out"), "--resume"]) == 0
    assert "it begins anew" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("fetsh", "no tree and no campaign named 'fetsh'"),
        ("fetch --set stop_distence=3", "has no parameter 'stop_distence'"),
        ("fetch --set look=9s..5s", "runs from 9 down to 5"),
        ("fetch --condition fricton=2", "there is no condition 'fricton'"),
        ("fetch --condition friction=-1", "must be >= 0"),
        ("fetch --push force=10", "'at' of"),
        ("fetch --push at=1s", "the key 'force' of a push is missing"),
        ("fetch --push at=1s,force", "is not NAME=VALUE"),
        ("fetch --dry --condition friction=0.5", "the condition 'friction' needs a body, and a dry run simulates none"),
        ("fetch --dry --condition drives=0.5..1", "run it without dry, or leave it out"),
        ("fetch --dry --condition slope=5deg", "the condition 'slope' needs a body"),
        (
            "fetch --perception color_blob --condition perception_noise=2 --seeds 0 --duration 1",
            "percepts come from 'color_blob'",
        ),
        ("fetch --dry --push at=1s,force=9", "a push needs a body"),
        ("fetch --seeds 3-x", "are no seeds"),
        ("fetch --require 'sucess > 3'", "unknown name 'sucess'"),
        ("fetch --scene nowhere", "no scene named 'nowhere'"),
        ("fetch --resume", "--resume needs the folder"),
        ("fetch stand", "one campaign at a time"),
        ("compare a", "campaign compare takes 2 arguments, not 1\n    humanoid-bt campaign compare A B"),
        ("rerun", "campaign rerun takes 2 arguments, not 0\n    humanoid-bt campaign rerun DIR TRIAL"),
        ("recover", "does not run alone"),
        ("fetch --duration 6 --push at=2s..7s,force=9", "a push at 7 s never happens: a trial ends after 6 s"),
    ],
)
def test_what_cannot_be_run_is_told_before_anything_is_written(
    line: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["campaign", *shlex.split(line)]) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("compare a b --require 'success > 1'", "campaign compare takes no '--require'"),
        ("--seeds 3 compare a b", "campaign compare takes no '--seeds'"),
        ("rerun a 3 -j 2", "campaign rerun takes no '-j'"),
    ],
)
def test_what_a_campaign_that_is_over_cannot_take_is_refused(
    line: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as exit_:
        main(["campaign", *shlex.split(line)])
    assert exit_.value.code == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("word", "has", "lacks"), [("compare", "--out FILE", "--workspace"), ("rerun", "DIR", "--out")]
)
def test_what_is_done_with_one_that_is_over_has_help_of_its_own(
    word: str, has: str, lacks: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as exit_:
        main(["campaign", word, "a", "--help"])
    told = capsys.readouterr().out
    assert exit_.value.code == 0
    assert told.startswith(f"usage: humanoid-bt campaign {word} ")
    assert has in told
    assert not {lacks, "--seeds", "--require"} & set(told.split())


def test_a_tree_may_be_called_as_what_is_done_with_campaigns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("trees").mkdir()
    Path("trees/compare.yaml").write_text("format: 1\nroot: {wait: 0.1 s}\n", encoding="utf-8")
    assert main(["campaign", "compare", "--dry", "--seeds", "0", "--json", "--out", "out"]) == 0
    assert json.loads(capsys.readouterr().out)["success"]["count"] == 1


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A workspace with a tree that fails at once."""
    for place, text in {"trees/mine.yaml": MINE, "skills/say.py": SAY}.items():
        (tmp_path / "project" / place).parent.mkdir(parents=True)
        (tmp_path / "project" / place).write_text(text)
    monkeypatch.chdir(tmp_path / "project")
    return tmp_path / "project"


def campaign(*arguments: str) -> int:
    return main(["campaign", "mine", "--dry", "--seeds", "0", "--quiet", "--recordings", "0", *arguments])


def test_a_trial_is_run_again_from_another_folder(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert campaign("--out", "runs/a") == 0
    monkeypatch.chdir(project.parent)
    capsys.readouterr()
    main(["campaign", "rerun", "project/runs/a", "0"])
    told = capsys.readouterr()
    assert "as it was, bit for bit" in told.out, told.err


def test_what_is_drawn_is_tried_before_a_trial_runs(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert campaign("--set", "times=1 .. 3", "--out", "runs/a") == 2
    assert "'times' must be a whole number" in capsys.readouterr().err
    assert not (project / "runs").exists()


def test_units_are_taken_as_run_takes_them(project: Path) -> None:
    assert campaign("--set", "long=200ms", "--out", "runs/a") == 0
    (factor,) = json.loads((project / "runs/a/campaign.json").read_text())["factors"]
    assert (factor["unit"], factor["values"]) == ("s", [0.2])


def test_results_stay_where_they_were_asked_for(project: Path, tmp_path: Path, monkeypatch: Any) -> None:
    (project / "skills/goes.py").write_text(f"import os\n\nos.chdir({str(tmp_path)!r})\n")
    assert campaign("--out", "runs/a") == 0
    assert (project / "runs/a/report.html").exists()


def test_text_is_taken_as_run_takes_it(project: Path) -> None:
    texts = ["12", "yes", "a: b", "[a, b]", "../a", ""]
    assert campaign(*(f"--set=label={text}" for text in texts), "--out", "runs/a") == 0
    assert campaign("--set", "label=../a", "--out", "runs/b") == 0
    for folder, tried in {"a": texts, "b": ["../a"]}.items():
        (factor,) = json.loads((project / f"runs/{folder}/campaign.json").read_text())["factors"]
        assert factor["values"] == tried
