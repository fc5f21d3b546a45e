"""Files that are edited while a campaign runs, or before one of its trials is run again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from humanoid_bt.campaign.conduct import Progress, conduct, recording_of
from humanoid_bt.campaign.file import CampaignFile
from humanoid_bt.campaign.planning import planned
from humanoid_bt.campaign.result import Cost
from humanoid_bt.campaign.stage_trials import Setup, make
from humanoid_bt.campaign.store import Store, read_results
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.workers import Done
from humanoid_bt.cli import main
from humanoid_bt.core.errors import Place
from humanoid_bt.core.items import item_of
from humanoid_bt.core.reading import read
from humanoid_bt.files.workspace import Workspace

TREE = """
format: 1
parameters: {most: 3}
root: {condition: $most > 5}
"""


class Here:
    """Runs trials in this process."""

    def __init__(self, setup: Setup) -> None:
        self._run = make(setup)

    def run(self, tasks: Iterable[Task]) -> Iterator[Done]:
        for task in tasks:
            result, explained, _ = self._run(task)
            yield Done(task, result, Cost(), explained)

    def close(self) -> None:
        pass


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of a tree of which a campaign in ``out`` has run a trial."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "trees").mkdir()
    file = tmp_path / "trees" / "edited.yaml"
    file.write_text(TREE)
    asked = {"format": 1, "name": "edited", "tree": "edited", "seeds": 0, "dry": True}
    plan = planned(read(CampaignFile, item_of(asked, Place("asked")), "the campaign"), Workspace(tmp_path)).plan
    with Store(tmp_path / "out", plan, resume=False) as store:
        conduct(store, Here(Setup.of(plan, str(tmp_path))), 0, Progress())
    return file


def test_a_trial_that_cannot_run_again_keeps_its_recording(tree: Path) -> None:
    recording = Path(recording_of(Path("out"), read_results(Path("out")).rows[0]))
    recording.write_bytes(b"old")
    tree.write_text(TREE.replace("$most", "$least"))
    assert main(["campaign", "rerun", "out", "0"]) == 2
    assert recording.read_bytes() == b"old"
