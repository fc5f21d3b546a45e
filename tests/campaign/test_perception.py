"""Scenarios and campaigns that name percept sources: checked, tried, and run again with the same ones."""

from __future__ import annotations

import shlex
from pathlib import Path

import jsonschema
import pytest

from humanoid_bt.campaign.file import CampaignFile
from humanoid_bt.campaign.planning import checked_campaign
from humanoid_bt.campaign.reproduce import command
from humanoid_bt.campaign.store import read_results
from humanoid_bt.cli import main
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.testing.scenario import Scenario
from humanoid_bt.testing.scenario_check import checked_scenario
from humanoid_bt.testing.scenario_schema import file_schema
from tests.perception.sources import SIGN, write

SEE = """\
format: 1
root:
  emergency_stop:
    watchdog: {percept: sign, max_age: 0.5 s, wait_until: "distance(sign) > 1.9 m"}
"""
SCENARIO = """\
format: 1
tree: see
dry: true
perception: {door_sign: {ahead: 250 cm}}
script:
  - {at: 1 s, lose: sign, optional: true}
expect: outcome == success
"""
CAMPAIGN = """\
format: 1
name: signs
tree: see
dry: true
perception: {door_sign: {ahead: 250 cm}}
seeds: 0-1
recordings: 0
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write(tmp_path, "door_sign.py", SIGN)
    for name, text in (("trees", SEE), ("scenarios", SCENARIO), ("campaigns", CAMPAIGN)):
        (tmp_path / name).mkdir()
        (tmp_path / name / f"{'see' if name == 'trees' else 'signs'}.yaml").write_text(text)
    return tmp_path


def test_a_scenario_sees_with_what_it_names(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check"]) == 0
    assert main(["test", "signs"]) == 0
    (project / "scenarios/near.yaml").write_text(SCENARIO.replace("250", "150"))
    assert main(["test"]) == 1  # both, with one robot in one scene
    assert "1 scenario passed, 1 scenario failed" in capsys.readouterr().out


MISTAKES = {
    "a name": ("door_sign:", "dor_sign:", "no percept source named 'dor_sign'", "'door_sign'"),
    "a value": ("250 cm", "250 kg", "'ahead' has the unit 'kg'", "valid: m, cm, mm"),
    "a kind": ("{door_sign: {ahead: 250 cm}}", "5", "a percept source must be named, and this is a number", "NAME"),
    "a picture": ("{door_sign: {ahead: 250 cm}}", "color_blob", "'color_blob' needs the head camera", "without dry"),
}


@pytest.mark.parametrize(("old", "new", "message", "hint"), MISTAKES.values(), ids=list(MISTAKES))
def test_a_mistake_is_told_with_its_place(project: Path, old: str, new: str, message: str, hint: str) -> None:
    for text, name, checked, line in (
        (SCENARIO, "scenarios/signs.yaml", checked_scenario, 4),
        (CAMPAIGN, "campaigns/signs.yaml", checked_campaign, 5),
    ):
        Path(name).write_text(text.replace(old, new))
        with pytest.raises(UserError) as raised:
            checked(Path(name), Workspace())
        assert f"{name}:{line}:" in str(raised.value)
        assert message in str(raised.value)
        assert hint in str(raised.value)


def test_a_fault_can_end_what_is_published_and_nothing_else(project: Path) -> None:
    Path("scenarios/signs.yaml").write_text(SCENARIO.replace("lose: sign", "lose: target"))
    with pytest.raises(UserError, match=r"6:21: error: no percept source publishes 'target'"):
        checked_scenario(Path("scenarios/signs.yaml"), Workspace())


def test_noise_of_the_tracker_that_does_not_see_is_refused(project: Path) -> None:
    Path("campaigns/signs.yaml").write_text(f"{CAMPAIGN}conditions: {{perception_noise: [1, 3]}}\n")
    with pytest.raises(UserError, match=r"8:33: error: the condition 'perception_noise' .* from 'door_sign'"):
        checked_campaign(Path("campaigns/signs.yaml"), Workspace())
    Path("campaigns/signs.yaml").write_text(f"{CAMPAIGN}conditions: {{perception_noise: 1}}\n")
    assert checked_campaign(Path("campaigns/signs.yaml"), Workspace()).plan.factors


@pytest.mark.trials
def test_a_campaign_sees_with_what_it_names(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", "signs", "--quiet", "--out", "far", "--require", "success == 100 %"]) == 0
    assert "door_sign" in Path("far/report.html").read_text()
    plan = checked_campaign(Path("campaigns/signs.yaml"), Workspace()).plan
    assert "perception/door_sign.py" in plan.files
    near = ["--perception", "door_sign: {ahead: 1.5}", "--duration", "1"]
    assert main(["campaign", "signs", "--quiet", "--out", "near", *near, "--require", "success == 0"]) == 0
    capsys.readouterr()
    assert main(["campaign", "compare", "far", "near"]) == 0  # two trials are no proof
    assert "perception" in capsys.readouterr().out
    assert main(["campaign", "signs", "--quiet", "--out", "near", "--resume"]) == 2
    capsys.readouterr()
    assert main(["campaign", "rerun", "near", "0"]) == 5
    assert "as it was, bit for bit" in capsys.readouterr().out


def test_the_command_of_a_trial_names_them(project: Path) -> None:
    Path("campaigns/signs.yaml").write_text(CAMPAIGN.replace("dry: true\n", ""))
    plan = checked_campaign(Path("campaigns/signs.yaml"), Workspace()).plan
    words = shlex.split(command(plan.trials[0], plan, Path("runs/mine")))
    assert words[words.index("--perception") + 1] == '{"door_sign": {"ahead": "250 cm"}}'
    assert main([*words[1:], "--no-record", "--quiet"]) == 0


def test_what_was_kept_is_read_again(project: Path) -> None:
    assert main(["campaign", "signs", "--quiet", "--out", "far"]) == 0
    assert read_results(Path("far")).plan == checked_campaign(Path("campaigns/signs.yaml"), Workspace()).plan


@pytest.mark.parametrize("cls", [Scenario, CampaignFile])
def test_editors_know_the_names(cls: type) -> None:
    schema = file_schema(cls, "a file", Workspace(builtin_root()))
    assert schema["properties"]["perception"]["examples"] == ["color_blob", "tracker"]
    form = {"properties": {"perception": schema["properties"]["perception"]}}
    for right in ("color_blob", {"color_blob": None}, ["tracker", {"color_blob": {"color": "purple"}}]):
        jsonschema.validate({"perception": right}, form)
    for wrong in (5, [], {}, {"color_blob": "purple"}, [["tracker"]]):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({"perception": wrong}, form)
