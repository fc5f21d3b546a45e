"""Files that are edited while a campaign runs, or before one of its trials is run again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from humanoid_bt.campaign.conduct import Progress, Runners, conduct, recording_of
from humanoid_bt.campaign.digests import called, changes, find
from humanoid_bt.campaign.file import CampaignFile
from humanoid_bt.campaign.planning import planned
from humanoid_bt.campaign.result import Cost
from humanoid_bt.campaign.stage_trials import Setup, make
from humanoid_bt.campaign.store import Store, read_results
from humanoid_bt.campaign.table import Table
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.unchanged import Unchanged
from humanoid_bt.campaign.workers import Done
from humanoid_bt.cli import main
from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.items import item_of
from humanoid_bt.core.reading import read
from humanoid_bt.files.workspace import Workspace, builtin_root

TREE = """
format: 1
parameters: {most: 3}
root: {condition: $most > 5}
"""


class Here(Runners):
    """Runs trials in this process."""

    def __init__(self, setup: Setup) -> None:
        self._run = make(setup)

    def run(self, tasks: Iterable[Task]) -> Iterator[Done]:
        for task in tasks:
            result, explained, _ = self._run(task)
            yield Done(task, result, Cost(), explained)

    def close(self) -> None:
        pass


class Edits(Progress):
    """Puts another text into a file when a trial is done."""

    def __init__(self, file: Path, number: int, text: str) -> None:
        self.file, self.number, self.text = file, number, text

    def trial(self, done: Done) -> None:
        if done.task.trial.number == self.number:
            self.file.write_text(self.text)


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of a tree."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "trees" / "edited.yaml"
    file.parent.mkdir()
    file.write_text(TREE)
    return file


def campaign(progress: Progress | None = None, resume: bool = False) -> Table:
    """Run a campaign of dry trials of the tree in this process, in ``out``."""
    asked = {"format": 1, "name": "edited", "tree": "edited", "seeds": "0-3", "dry": True}
    asked["parameters"] = {"most": [3, 4]}
    found = planned(read(CampaignFile, item_of(asked, Place("asked")), "the campaign"), Workspace())
    runners = Unchanged(Here(Setup.of(found.plan, ".")), found.files, found.plan.files)
    with Store(Path("out"), found.plan, resume) as store:
        conduct(store, runners, 0, progress or Progress())
        return Table.of(found.plan, store.results)


def test_a_campaign_ends_when_a_file_changes_and_goes_on_when_it_is_put_back(tree: Path) -> None:
    edited = TREE.replace("> 5", "< 5")
    with pytest.raises(UserError, match=r"changed while the campaign ran: trees/edited.yaml\n"):
        campaign(Edits(tree, 2, edited))
    assert len(read_results(Path("out")).rows) == 3
    with pytest.raises(UserError, match=r"trees/edited.yaml has changed"):
        campaign(resume=True)
    tree.write_text(TREE)
    assert [row.result.outcome for row in campaign(resume=True).rows] == ["failure"] * 8


def test_a_trial_that_cannot_run_again_keeps_its_recording(tree: Path) -> None:
    recording = Path(recording_of(Path("out"), campaign().rows[0]))
    recording.write_bytes(b"old")
    tree.write_text(TREE.replace("$most", "$least"))
    assert main(["campaign", "rerun", "out", "0"]) == 2
    assert recording.read_bytes() == b"old"


def test_a_trial_that_runs_another_way_names_what_has_changed(tree: Path, capsys: pytest.CaptureFixture[str]) -> None:
    campaign()
    tree.write_text(TREE.replace("> 5", "> 6"))
    main(["campaign", "rerun", "out", "0"])
    told = [line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines()]
    assert ["again", "not bit for bit as it was"] in told
    assert ["changed", "trees/edited.yaml"] in told


def test_a_file_that_is_called_like_a_built_in_one_is_another(tmp_path: Path) -> None:
    own, builtin = tmp_path / "skills" / "reach.py", builtin_root() / "skills" / "reach.py"
    own.parent.mkdir()
    own.write_text("# of one's own")
    workspace = Workspace(tmp_path)
    names = {called(file, workspace): file for file in (own, builtin)}
    assert names.keys() == {"skills/reach.py", str(builtin)}
    assert find(names, workspace) == names
    assert called(builtin, Workspace()) == "skills/reach.py"


def test_files_that_only_one_side_knows_have_changed() -> None:
    assert changes({"a": "1"}, {"a": "1", "b": "2"}) == ["b"]
    assert changes({"a": "1", "b": "2"}, {"a": "1"}) == ["b"]
