"""Campaign files: what they mean, and every mistake in them with its place."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from humanoid_bt.campaign.planning import checked_campaign
from humanoid_bt.campaign.stage_trials import pushes
from humanoid_bt.cli import main
from humanoid_bt.cli.arguments import parser
from humanoid_bt.cli.campaign_given import campaign_given
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace

FILE = """\
format: 1
name: slippery
tree: fetch
scene: [random_target, ball_on_stand]
seeds: 0-9, 20
parameters:
  stop_distance: [35 cm, 40 cm]
  look: 5 s .. 9 s
conditions:
  friction: 0.5 .. 1.2
pushes:
  - {at: 1 s .. 6 s, force: [0, 60], direction: 90 deg}
script:
  - {at: 3 s, lose: {percept: target, duration: 1 s}}
require: [success >= 95 %, hand_error_p95 < 1.5 cm]
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A campaign in a workspace of its own."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "campaigns" / "slippery.yaml"
    path.parent.mkdir()
    path.write_text(FILE)
    return Path("campaigns/slippery.yaml")


def test_a_file_becomes_a_plan(file: Path) -> None:
    plan = checked_campaign(file, Workspace()).plan
    assert len(plan) == 11 * 2 * 2 * 2  # seeds, scenes, stop distances, forces
    assert plan.varies == ("scene", "set.stop_distance", "set.look", "condition.friction", "push.1.at", "push.1.force")
    trial = plan.trials[-1]
    assert (trial.tree, trial.robot, trial.scene, trial.seed) == ("fetch", "humanoid", "ball_on_stand", 20)
    assert (trial.given["set.stop_distance"], trial.given["push.1.force"]) == (0.4, 60.0)
    assert trial.given["push.1.duration"] == 0.1
    assert 5.0 <= trial.given["set.look"] <= 9.0
    assert {"trees/fetch.yaml", "skills/reach.py", "sim/humanoid/humanoid.xml"} <= plan.files.keys()


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("tree: fetch", "tree: fetsh", "3:7: error: no tree named 'fetsh'"),
        ("ball_on_stand]", "nowhere]", "4:24: error: no scene named 'nowhere'"),
        ("seeds: 0-9", "seeds: 9-0", "5:8: error: '9-0, 20' are no seeds"),
        ("seeds: 0-9, 20", "seeds: []", "5:8: error: 'seeds' has no seeds"),
        ("stop_distance", "stop_distence", "7:19: error: the tree 'fetch' has no parameter 'stop_distence'"),
        ("40 cm", "40 kg", "7:26: error: 'stop_distance' has the unit 'kg'"),
        ("[35 cm, 40 cm]", "[35 cm, 11 m, 12 m]", "7:26: error: 'distance' must be > 0 and <= 10, not 11"),
        ("[35 cm, 40 cm]", "[35 cm, 11 m, 12 m]", "7:32: error: 'distance' must be > 0 and <= 10, not 12"),
        ("[35 cm, 40 cm]", "35 cm .. 11 m", "7:18: error: 'distance' must be > 0 and <= 10, not 11"),
        ("5 s .. 9 s", "9 s .. 5 s", "8:9: error: 'set.look' runs from 9 down to 5"),
        ("friction", "fricton", "10:3: error: there is no condition 'fricton'"),
        ("1.2", "12", "10:13: error: 'friction' must be >= 0 and <= 10"),
        ("force: [0, 60], ", "", "12:5: error: the key 'force' of"),
        ("90 deg", "90 cm", "12:49: error: 'direction' has the unit 'cm'"),
        ("script:", "duration: 2 s\nscript:", "15:10: error: the event at 3 s never happens"),
        ("lose:", "loose:", "14:15: error: unknown key 'loose'"),
        ("success >=", "sucess >=", "15:11: error: unknown name 'sucess'"),
        ("name: slippery", "name: ../../mine", "2:7: error: '../../mine' cannot be a name"),
        ("format: 1", "format: 2", "1:9: error: 'format' must be"),
        ("seeds:", "sedes:", "5:1: error: unknown key 'sedes' of the campaign"),
        ("scene: [random_target, ball_on_stand]", "scene: []", "4:8: error: 'scene' needs names"),
    ],
)
def test_a_mistake_is_told_with_its_place(
    file: Path, before: str, after: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file.write_text(FILE.replace(before, after, 1))
    with pytest.raises(UserError) as error:
        checked_campaign(file, Workspace())
    assert f"campaigns/slippery.yaml:{message}" in str(error.value)
    assert main(["check", str(file)]) == 2
    assert f"campaigns/slippery.yaml:{message}" in capsys.readouterr().out


def test_several_mistakes_are_told_together(file: Path) -> None:
    file.write_text(FILE.replace("40 cm", "40 kg").replace("5 s .. 9 s", "9 s .. 5 s").replace("1.2", "12"))
    with pytest.raises(UserError) as error:
        checked_campaign(file, Workspace())
    assert len(error.value.problems) == 3


def test_it_is_checked_formatted_and_completed(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check"]) == 0
    assert main(["fmt", "--check"]) == 0
    assert main(["schema", "campaigns", "-o", "schema.json"]) == 0
    schema = json.loads(Path("schema.json").read_text())
    jsonschema.validate(yaml.safe_load(FILE), schema)
    for key, value in (("nam", 1), ("seeds", "x-1"), ("tree", 5), ("conditions", [1]), ("require", 3)):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({**yaml.safe_load(FILE), key: value}, schema)


@pytest.mark.parametrize(("tree", "name"), [("point out (2)", "point out _2_"), ("-a+b", "_a_b"), ("läuft", "läuft")])
def test_a_tree_may_be_called_as_no_campaign_can_be(
    tree: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = Path("trees", f"{tree}.yaml")
    file.parent.mkdir()
    file.write_text("format: 1\nroot: {wait: 1 s}\n")
    for what in (tree, str(file)):
        campaign, _ = campaign_given(parser().parse_args(["campaign", "--dry", "--", what]), Workspace())
        assert campaign.name == name
        assert [item.value for item in campaign.tree.items] == [what]


def _planned(folder: Path, **more: Any) -> Any:
    file = folder / "campaigns" / "mine.yaml"
    file.parent.mkdir(exist_ok=True)
    file.write_text(yaml.safe_dump({"format": 1, "name": "mine", "tree": "stand", **more}))
    return checked_campaign(file, Workspace(folder)).plan


def test_a_push_goes_ahead_and_may_come_at_the_last_moment(tmp_path: Path) -> None:
    plan = _planned(tmp_path, pushes=[{"at": 2, "force": 10}], duration=2)
    assert {factor.name: factor.values for factor in plan.factors} == {
        **{"push.1.at": (2.0,), "push.1.force": (10.0,), "push.1.direction": (0.0,), "push.1.duration": (0.1,)}
    }
    (push,) = pushes(plan.trials[0])
    assert push["push"]["force"] == [10.0, 0.0, 0.0]


def test_nothing_is_named_twice_and_no_dry_run_falls(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="none of them twice"):
        _planned(tmp_path, tree=["stand", "stand"])
    for what in ("fell", "bumped"):
        with pytest.raises(UserError, match=f"fail_on '{what}' needs a body"):
            _planned(tmp_path, dry=True, fail_on=[what])
    assert _planned(tmp_path, dry=True, fail_on=["stopped"]).fail_on == ("stopped",)
