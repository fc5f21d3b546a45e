from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace, builtin_root, yaml_files


@pytest.fixture
def project(tmp_path: Path) -> Path:
    for name in ("trees/walk.yaml", "trees/fetch.yaml", "sim/scenes/table.yaml", "sim/r2/robot.yaml", "skills/_no.py"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("format: 1\n")
    (tmp_path / "skills" / "wave.py").write_text("")
    return tmp_path


def test_names_are_looked_up_in_the_workspace_first_then_in_the_built_in_one(project: Path) -> None:
    workspace = Workspace(project)
    assert workspace.find_tree("walk") == project / "trees" / "walk.yaml"
    assert workspace.find_tree("fetch") == project / "trees" / "fetch.yaml"
    assert workspace.find_scene("table") == project / "sim" / "scenes" / "table.yaml"
    assert workspace.find_robot("r2") == project / "sim" / "r2" / "robot.yaml"
    elsewhere = Workspace(project / "skills")
    assert elsewhere.find_tree("fetch") == builtin_root() / "trees" / "fetch.yaml"


def test_paths_work_too(project: Path) -> None:
    workspace = Workspace(builtin_root())
    assert workspace.find_tree(str(project / "trees" / "walk.yaml")) == project / "trees" / "walk.yaml"
    assert workspace.find_robot(str(project / "sim" / "r2")) == project / "sim" / "r2" / "robot.yaml"


def test_the_users_skills_come_last_and_private_files_are_left_out(project: Path) -> None:
    files = Workspace(project).skill_files()
    assert files[-1] == project / "skills" / "wave.py"
    assert not any(path.name.startswith("_") for path in files)


def test_an_unknown_name_is_answered_with_the_nearest(project: Path) -> None:
    workspace = Workspace(project)
    with pytest.raises(UserError, match=r"no tree named 'wlak' \[unknown-tree\]\n    did you mean 'walk'\?"):
        workspace.find_tree("wlak")
    with pytest.raises(UserError, match=r"no tree file 'trees/wlak.yaml' \[unknown-tree\]\n    did you mean 'walk'\?"):
        workspace.find_tree("trees/wlak.yaml")
    with pytest.raises(UserError, match="no robot named 'r3'"):
        workspace.find_robot("r3")


def test_a_tree_belongs_to_the_folder_above_its_trees(project: Path) -> None:
    assert Workspace.of_tree(project / "trees" / "deep" / "walk.yaml").root == project.resolve()


def test_scenarios_are_found_like_trees(project: Path) -> None:
    (project / "scenarios" / "deep").mkdir(parents=True)
    for name in ("lost.yaml", "deep/more.yaml"):
        (project / "scenarios" / name).touch()
    workspace = Workspace(project)
    assert workspace.find_scenario("lost") == project / "scenarios" / "lost.yaml"
    assert "fetch_lost" in workspace.scenarios()  # built in
    with pytest.raises(UserError, match=r"no scenario named 'lsot' \[unknown-scenario\]\n    did you mean 'lost'\?"):
        workspace.find_scenario("lsot")
    assert Workspace.of_tree(project / "scenarios" / "lost.yaml").root == project.resolve()
    assert [path.name for path in yaml_files(project)][-2:] == ["more.yaml", "lost.yaml"]


def test_a_workspace_is_a_folder(project: Path) -> None:
    with pytest.raises(UserError, match="is not a folder"):
        Workspace(project / "none")


@pytest.mark.parametrize("root", [None, "here", Path("here")])
def test_without_a_working_directory_nothing_is_found_from_it(
    root: str | Path | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    with pytest.raises(UserError, match="the working directory is gone") as raised:
        Workspace(root)
    assert raised.value.problems[0].hint == "cd to a folder that is there"
    assert Workspace(tmp_path).root == tmp_path


def test_a_folder_gives_its_own_kinds_of_files_and_nobody_elses(tmp_path: Path) -> None:
    ours = ("trees/a.yaml", "trees/deep/b.yaml", "sim/scenes/c.yaml", "sim/robot/robot.yaml")
    others = ("sim/robot/meshes/d.yaml", "charts/e.yaml", "f.yaml", "trees/g.txt")
    for name in (*ours, *others):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()

    def found(folder: str) -> set[str]:
        return {str(path.relative_to(tmp_path)) for path in yaml_files(tmp_path / folder)}

    assert found(".") == set(ours)
    assert found("trees") == {"trees/a.yaml", "trees/deep/b.yaml"}
    assert found("trees/deep") == {"trees/deep/b.yaml"}
    assert found("sim") == {"sim/scenes/c.yaml", "sim/robot/robot.yaml"}
    assert found("charts") == {"charts/e.yaml"}
    (tmp_path / "trees").rename(tmp_path / "charts/trees_of_another_kind")
    (tmp_path / "sim").rename(tmp_path / "charts/sim_of_another_kind")
    assert found(".") == {"f.yaml"}


@pytest.mark.parametrize("inner", ["sim", "trees", "scenarios", "campaigns"])
@pytest.mark.parametrize("kind", ["trees", "scenarios", "campaigns"])
def test_folders_below_one_of_trees_may_have_any_name(tmp_path: Path, kind: str, inner: str) -> None:
    ours = [tmp_path / kind / name for name in ("a.yaml", f"{inner}/b.yaml", f"{inner}/deep/c.yaml")]
    other = tmp_path / "sim/scenes/d.yaml"
    for path in (*ours, other):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    assert set(yaml_files(tmp_path)) == {*ours, other}
    assert yaml_files(tmp_path / kind) == yaml_files(tmp_path, [kind]) == ours
    assert yaml_files(tmp_path / kind / inner, [kind]) == ours[1:]
    assert {Workspace.of_tree(path).root for path in ours} == {tmp_path}
    assert yaml_files(tmp_path / kind, ["sim"]) == []


def test_a_workspace_may_be_called_like_a_folder_of_trees(tmp_path: Path) -> None:
    ours, other = tmp_path / "trees/trees/a.yaml", tmp_path / "trees/charts/b.yaml"
    for path in (ours, other):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    assert yaml_files(tmp_path / "trees") == [ours]
    assert yaml_files(other.parent) == [other]
