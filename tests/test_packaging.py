"""The wheel: what is in it, and that it works from an empty environment in a user's own folder."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

from tests.projects import make_project

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", folder, ROOT]
    subprocess.run(command, check=True, cwd=folder)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def program(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the wheel with what it declares to need into an empty environment; return its program."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=True)
    command = [folder / "bin" / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*command, "-c", ROOT / "constraints.txt", wheel], check=True, cwd=folder, env=environment())
    return folder / "bin" / "humanoid-bt"


def environment() -> dict[str, str]:
    """Return an environment in which this checkout cannot be imported and no display is found."""
    hidden = ("PYTHONPATH", "VIRTUAL_ENV", "DISPLAY", "WAYLAND_DISPLAY")
    return {name: value for name, value in os.environ.items() if name not in hidden}


def run_in(folder: Path, program: Path, *arguments: str) -> dict[str, object]:
    """Run a tree from a folder and return its report."""
    report = folder / "report.json"
    done = subprocess.run(
        [program, "run", *arguments, "--no-view", "--report", report],
        check=False,
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    values: dict[str, object] = json.loads(report.read_text(encoding="utf-8"))
    return values


def test_the_wheel_holds_the_package_and_its_data(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"humanoid_bt"}
    for folder in ("trees", "skills", "perception", "sim", "scenarios", "template"):
        here = {
            f"humanoid_bt/builtin/{path.relative_to(ROOT).as_posix()}"
            for path in (ROOT / folder).rglob("*")
            if path.is_file() and "__pycache__" not in path.parts
        }
        assert here <= names
    assert "humanoid_bt/py.typed" in names
    assert not [name for name in names if "__pycache__" in name]


def test_the_metadata_says_what_a_user_needs(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        read = {
            name.split("/", 1)[1]: archive.read(name).decode() for name in archive.namelist() if ".dist-info/" in name
        }
    metadata = read["METADATA"]
    assert "licenses/LICENSE" in read
    for line in ("Name: humanoid-bt", "License-Expression: MIT", "Requires-Python: >=3.11", "Keywords: ", "Summary: "):
        assert f"\n{line}" in metadata
    assert "\nClassifier: Typing :: Typed" in metadata
    assert "\nDescription-Content-Type: text/markdown" in metadata
    for package in ("mujoco", "mink", "py-trees", "rerun-sdk", "pyyaml"):
        assert f"requires-dist: {package}" in metadata.lower().replace("_", "-")
    assert "humanoid-bt = humanoid_bt.__main__:main" in read["entry_points.txt"]
    assert "[pytest11]\nhumanoid_bt = humanoid_bt.testing.plugin" in read["entry_points.txt"]


@pytest.mark.install
def test_the_demo_runs_from_a_users_folder(program: Path, tmp_path: Path) -> None:
    project = make_project(tmp_path / "project")
    report = run_in(project, program, "fetch")
    assert report["outcome"] == "success"
    assert Path(project / str(report["recording"])).stat().st_size > 0


@pytest.mark.install
def test_a_users_skill_runs_beside_the_built_in_ones(program: Path, tmp_path: Path) -> None:
    project = make_project(tmp_path / "project")
    tree = "format: 1\nroot:\n  emergency_stop:\n    parallel:\n      success: one\n      children: [pause, idle]\n"
    (project / "trees/both.yaml").write_text(tree, encoding="utf-8")
    report = run_in(project, program, "both", "--no-record")
    assert report["reason"] == "pause: waited"
