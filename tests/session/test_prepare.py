"""Loading, checking and looking up skills, as programs do it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import humanoid_bt as hbt

SKILL = """\
from humanoid_bt import Skill, Status, param


class Nod(Skill):
    times: int = param(3, doc="How often.")

    def update(self) -> Status:
        return self.succeed("nodded")
"""
TREE = "format: 1\nparameters: {often: {type: integer, default: 2}}\nroot: {nod: {times: $often}}\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A workspace with one skill and one tree, which is not the working directory."""
    for name, text in {"skills/nod.py": SKILL, "trees/nods.yaml": TREE}.items():
        path = tmp_path / "mine" / name
        path.parent.mkdir(parents=True)
        path.write_text(text, encoding="utf-8")
    return tmp_path / "mine"


def test_a_tree_is_loaded_by_name_or_file(folder: Path) -> None:
    trees = [
        hbt.load("nods", workspace=folder),
        hbt.load("nods", workspace=hbt.Workspace(str(folder))),
        hbt.load(folder / "trees" / "nods.yaml"),
        hbt.load(str(folder / "trees" / "nods.yaml")),
    ]
    assert {tree.to_yaml() for tree in trees} == {trees[0].to_yaml()}


@pytest.mark.parametrize("value", [5, "5", 5.0, np.int64(5)])
def test_a_value_is_plain_or_text(folder: Path, value: object) -> None:
    tree = hbt.load("nods", workspace=folder, often=value)
    assert tree.parameters == {"often": 5}
    assert tree.node("nod").values == {"times": 5}


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"oftn": 3},
            "oftn=3: error: the tree has no parameter 'oftn' [unknown-parameter]\n"
            "    did you mean 'often'? valid: often",
        ),
        (
            {"scen": 3},
            "scen=3: error: the tree has no parameter 'scen' [unknown-parameter]\n"
            "    did you mean the argument 'scene'?",
        ),
        ({"often": 2.5}, "often=2.5: error: 'often' must be a whole number, not a number 2.5"),
        ({"often": None}, "often=None: error: 'often' must be a whole number, not nothing"),
        (
            {"robot": "humanod"},
            "robot=humanod: error: no robot named 'humanod' [unknown-robot]\n    did you mean 'humanoid'?",
        ),
    ],
)
def test_a_mistake_is_one_clear_message(folder: Path, values: dict[str, object], message: str) -> None:
    with pytest.raises(hbt.UserError) as raised:
        hbt.load("nods", workspace=folder, **values)  # type: ignore[arg-type]  # of each their own kind
    assert str(raised.value).startswith(message)


def test_warnings_stand_beside_a_mistake_and_not_in_its_text(folder: Path) -> None:
    path = folder / "trees" / "idle.yaml"
    path.write_text("format: 1\nblackboard: {unread: 1}\nroot: idle\n", encoding="utf-8")
    with pytest.raises(hbt.UserError) as raised:
        hbt.load(path)
    assert [problem.severity for problem in raised.value.problems] == ["warning", "error"]
    assert "unread" not in str(raised.value)


def test_check_finds_what_the_command_finds(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert hbt.check(workspace=folder) == []
    (folder / "trees" / "wrong.yaml").write_text(TREE.replace("nod:", "nodd:"), encoding="utf-8")
    (problem,) = hbt.check(workspace=folder)
    assert (problem.code, problem.severity) == ("unknown-node", "error")
    assert hbt.check("nods", folder / "skills", workspace=folder) == []
    assert hbt.check(folder / "trees" / "wrong.yaml", "fetch") == [problem]
    monkeypatch.chdir(folder)
    assert [problem.code for problem in hbt.check("nodds")] == ["no-file"]


def test_skills_are_those_of_a_folder_and_the_built_in_ones(folder: Path) -> None:
    skills = hbt.skills(folder)
    assert {"nod", "approach", "idle"} <= skills.keys()
    tree = hbt.make_tree(skills["nod"]("mine", times=4), folder)
    assert tree.nodes[0].values == {"times": 4}
    assert hbt.run(tree).reason == "mine: nodded"
    with pytest.raises(hbt.UserError, match="is not a folder"):
        hbt.skills(folder / "nowhere")
