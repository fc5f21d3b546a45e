"""A new workspace: everything in it works, and nothing that was there is lost."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from humanoid_bt.campaign.planning import checked_campaign
from humanoid_bt.cli import main
from humanoid_bt.cli.init import SCHEMAS
from humanoid_bt.files.workspace import Workspace, builtin_root

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> str:
    """Make a workspace and go there; return what was said."""
    monkeypatch.chdir(tmp_path)
    assert main(["init", "my robot"]) == 0
    monkeypatch.chdir(tmp_path / "my robot")
    return capsys.readouterr().out


def steps() -> list[str]:
    """Return what the checks for GitHub run, but what installs the package."""
    workflow = yaml.safe_load(Path(".github/workflows/check.yml").read_text(encoding="utf-8"))
    lines = [step["run"] for step in workflow["jobs"]["check"]["steps"] if "run" in step]
    return [line for line in lines if not line.startswith("pip install")]


def test_it_has_no_mistakes_and_the_form_of_fmt(made: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check"]) == 0
    assert main(["fmt", "--check", "trees", "scenarios", "campaigns", "sim"]) == 0
    assert "warning" not in capsys.readouterr().out


@pytest.mark.trials
def test_its_tree_succeeds(made: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "point_out", "--no-record", "--no-view"]) == 0
    assert "pointed at ball" in capsys.readouterr().out


@pytest.mark.trials
def test_what_github_runs_passes(made: str) -> None:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    variables = {**os.environ, "PATH": path, "GITHUB_STEP_SUMMARY": "summary.md"}
    for line in steps():
        done = subprocess.run(line, shell=True, env=variables, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
    assert "100 %" in Path("summary.md").read_text(encoding="utf-8")
    commands = {line.split()[1] for line in steps() if line.startswith("humanoid-bt")}
    assert commands == {"fmt", "check", "test", "campaign"}


def test_it_says_what_to_do_next(made: str) -> None:
    lines = made.splitlines()
    files = [path for path in Path().rglob("*") if path.is_file()]
    assert lines[0] == f"my robot: a workspace with {len(files)} files. What to do next:"
    assert lines[1] == "  cd 'my robot'"
    assert len(lines) <= 9
    for command in (line.split()[1] for line in lines if line.startswith("  humanoid-bt ")):
        with pytest.raises(SystemExit) as ended:
            main([command, "--help"])
        assert ended.value.code == 0


def test_its_campaign_is_found_by_its_name(made: str) -> None:
    workspace = Workspace()
    assert set(workspace.campaigns()) == {"point_anywhere"}
    assert "point_anywhere" not in workspace.trees()
    assert checked_campaign(workspace.campaigns()["point_anywhere"], workspace).plan.name == "point_anywhere"


def test_its_readme_names_every_file(made: str) -> None:
    readme = Path("README.md").read_text(encoding="utf-8")
    for path in Path().rglob("*"):
        if path.is_file() and path.name not in ("README.md", ".gitignore"):
            assert f"`{path}`" in readme or f"`{path.parts[0]}/`" in readme, path


def test_editors_know_its_skill(made: str) -> None:
    settings = json.loads(Path(".vscode/settings.json").read_text(encoding="utf-8"))
    schemas = settings["yaml.schemas"]
    assert set(schemas) == {str(path) for path in SCHEMAS.values()}
    assert all(list(Path().glob(pattern)) for patterns in schemas.values() for pattern in patterns)
    assert "type_stretch_toward" in json.loads(SCHEMAS["trees"].read_text(encoding="utf-8"))["definitions"]
    assert json.loads(SCHEMAS["scenarios"].read_text(encoding="utf-8"))["properties"]["expect"]
    assert json.loads(SCHEMAS["campaigns"].read_text(encoding="utf-8"))["properties"]["require"]


def test_the_page_on_editors_shows_its_task_and_its_schemas() -> None:
    page = (ROOT / "docs" / "editors.md").read_text(encoding="utf-8")
    settings = builtin_root() / "template" / ".vscode"
    assert (settings / "tasks.json").read_text(encoding="utf-8") in page
    schemas = json.loads((settings / "settings.json").read_text(encoding="utf-8"))["yaml.schemas"]
    assert all(f'"{schema}": {json.dumps(files)}' in page for schema, files in schemas.items())


def test_it_goes_beside_what_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "LICENSE").write_text("mine")
    monkeypatch.chdir(tmp_path)
    assert main(["init", "."]) == 0
    assert Path("trees/point_out.yaml").exists()
    assert Path("LICENSE").read_text() == "mine"
    assert "\n  cd " not in capsys.readouterr().out
    assert main(["init", "."]) == 2
    files = sum(path.is_file() for path in tmp_path.rglob("*")) - 1
    assert f" and {files - 3} more in '.'" in capsys.readouterr().err


def test_what_is_installed_for_reading_is_copied_for_writing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(builtin_root() / "template", tmp_path / "installed" / "template")
    for path in [path for path in (tmp_path / "installed").rglob("*") if path.is_file()]:
        path.chmod(0o444)
        (path.parent / "__pycache__").mkdir(exist_ok=True)
        (path.parent / "__pycache__" / "left.pyc").touch()
    monkeypatch.setattr("humanoid_bt.cli.init.builtin_root", lambda: tmp_path / "installed")
    assert main(["init", str(tmp_path / "mine")]) == 0
    assert all(path.stat().st_mode & 0o200 for path in (tmp_path / "mine").rglob("*"))
    assert not list((tmp_path / "mine").rglob("*.pyc"))


@pytest.mark.parametrize("name", ["README.md", ".vscode/tree.schema.json"])
def test_it_overwrites_nothing(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = tmp_path / name
    mine.parent.mkdir(exist_ok=True)
    mine.symlink_to("nowhere")  # what would be written through it is no less in the way
    assert main(["init", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith(f"error: init would overwrite {name} in ")
    assert [path for path in tmp_path.rglob("*") if not path.is_dir()] == [mine]


def test_a_file_is_no_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("mine")
    assert main(["init", str(tmp_path / "file")]) == 2
    assert main(["init", str(tmp_path / "file" / "below")]) == 2
    first, second = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error")]
    assert first.endswith("is no folder")
    assert "cannot be written: Not a directory" in second
