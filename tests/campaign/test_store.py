"""The folder of a campaign: which campaign may begin or go on there, and what is told of one that may not."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import NoReturn

import pytest

from humanoid_bt.campaign.journal import Unwritable
from humanoid_bt.campaign.store import Store, read_results
from humanoid_bt.core.errors import UserError
from tests.campaign.conftest import Conduct, plan_of


def test_another_campaign_does_not_go_on_in_its_folder(campaign: Conduct, tmp_path: Path) -> None:
    campaign(plan_of("0-3"))
    with pytest.raises(UserError, match=r"a campaign in .* already\n.*--resume"):
        Store(tmp_path / "out", plan_of("0-3"), resume=False)
    with pytest.raises(UserError, match="its seeds are others"):
        Store(tmp_path / "out", plan_of("0-4"), resume=True)
    with pytest.raises(UserError, match=r"trees/fetch.yaml has changed"):
        Store(tmp_path / "out", plan_of("0-3", files={"trees/fetch.yaml": "1234"}), resume=True)
    with Store(tmp_path / "out", plan_of("0-3", description="in other words"), resume=True) as store:
        assert len(store.results) == 4


@pytest.mark.parametrize(
    ("file", "written", "other"),
    [
        ("campaign.json", '"seeds"', '"seed"'),
        ("journal.jsonl", '"outcome"', '"later":1,"outcome"'),
        ("journal.jsonl", '"result"', '"results"'),
        ("journal.jsonl", '"wall"', '"later"'),
        ("journal.jsonl", '"cost":{', '"cost":1,"costs":{'),
        ("explained.jsonl", '"kind"', '"later"'),
    ],
)
def test_a_damaged_campaign_does_not_go_on(
    campaign: Conduct, tmp_path: Path, file: str, written: str, other: str
) -> None:
    campaign(plan_of("3"))
    path = tmp_path / "out" / file
    path.write_text(path.read_text().replace(written, other))
    told = rf"{file}' is damaged, or of another version"
    with pytest.raises(UserError, match=told):
        Store(tmp_path / "out", plan_of("3"), resume=True)
    if other not in ('"later"', '"cost":1,"costs":{'):  # what the results are not made of
        with pytest.raises(UserError, match=told):
            read_results(tmp_path / "out")


def test_a_campaign_that_never_came_to_a_trial_is_begun_anew(campaign: Conduct, tmp_path: Path) -> None:
    with Store(tmp_path / "out", plan_of("0-3"), resume=False):
        pass
    assert campaign(plan_of("0-5")).planned == 6
    assert read_results(tmp_path / "out").plan == plan_of("0-5")


def test_a_folder_that_cannot_be_looked_into_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_folder: Path) -> NoReturn:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(Path, "iterdir", refuse)
    with pytest.raises(Unwritable, match="cannot be written: Permission denied"):
        Store(tmp_path, plan_of("0-3"), resume=False)


def test_a_folder_with_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("...")
    with pytest.raises(UserError, match="holds no campaign"):
        Store(tmp_path / "mine", plan_of("0-3"), resume=False)
    for out in (tmp_path / "mine" / "thesis.tex", tmp_path / "mine" / "thesis.tex" / "x"):
        with pytest.raises(Unwritable, match=rf"'{out}' cannot be written: Not a directory"):
            Store(out, plan_of("0-3"), resume=False)
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["thesis.tex"]


def test_what_goes_on_keeps_the_plan_that_it_began_with(campaign: Conduct, tmp_path: Path) -> None:
    campaign(plan_of("0-3", description="as it was", workspace="here"))
    with Store(tmp_path / "out", plan_of("0-3", description="otherwise", workspace="there"), resume=True):
        pass
    assert read_results(tmp_path / "out").plan.description == "as it was"


@pytest.mark.parametrize(
    "left", ["recordings", "workers", "journal.jsonl", "explained.jsonl", ".campaign.json.1a2b3c4d"]
)
def test_what_a_kill_leaves_before_campaign_json_is_no_hindrance(campaign: Conduct, tmp_path: Path, left: str) -> None:
    path = tmp_path / "out" / left
    path.parent.mkdir()
    path.touch() if "." in left else path.mkdir()
    assert campaign(plan_of("0-1")).done == 2
