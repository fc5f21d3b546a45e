"""``model: robot_descriptions:NAME``: cloned by the real package, from a repository on this machine."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model_file import described_file, described_name, model_file

HUMANOID = builtin_root() / "sim" / "humanoid"

Command = Callable[..., subprocess.CompletedProcess[str]]


def _known_repositories() -> Any:
    return importlib.import_module("robot_descriptions._repositories").REPOSITORIES


def _git(folder: Path, *arguments: str) -> str:
    identity = ["-c", "user.name=somebody", "-c", "user.email=somebody@example.org"]
    done = subprocess.run(["git", *identity, *arguments], cwd=folder, check=True, capture_output=True, text=True)
    return done.stdout.strip()


@pytest.fixture
def published(tmp_path: Path) -> Path:
    """A repository in which a robot lies where Menagerie's is."""
    pytest.importorskip("robot_descriptions", reason="pip install 'humanoid-bt[descriptions]'")
    repository = tmp_path / "published"
    (repository / "unitree_g1").mkdir(parents=True)
    shutil.copy(HUMANOID / "humanoid.xml", repository / "unitree_g1" / "g1.xml")
    shutil.copy(HUMANOID / "humanoid.xml", repository / "unitree_g1" / "g1_with_hands.xml")
    _git(repository, "init", "--quiet")
    _git(repository, "add", ".")
    _git(repository, "commit", "--quiet", "-m", "A robot")
    return repository


@pytest.fixture
def command(tmp_path: Path, published: Path) -> Command:
    """``humanoid-bt`` in a process of its own, for which GitHub is that repository."""
    workspace = tmp_path / "mine"
    workspace.mkdir()
    environment = {
        **os.environ,
        "ROBOT_DESCRIPTIONS_CACHE": str(tmp_path / "cache"),
        "ROBOT_DESCRIPTION_COMMIT": _git(published, "rev-parse", "HEAD"),
        "GIT_CONFIG_COUNT": "1",
        "GIT_CONFIG_KEY_0": f"url.{published.as_uri()}.insteadOf",
        "GIT_CONFIG_VALUE_0": _known_repositories()["mujoco_menagerie"].url,
    }

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        call = [sys.executable, "-m", "humanoid_bt", *arguments]
        return subprocess.run(call, check=False, cwd=workspace, env=environment, capture_output=True, text=True)

    return run


@pytest.mark.trials
def test_a_description_is_cloned_once_and_becomes_a_robot(command: Command, published: Path, tmp_path: Path) -> None:
    first = command("robots", "init", "robot_descriptions:g1_mj_description")
    assert first.returncode == 0, first.stderr
    assert "sim/g1/robot.yaml: a first description" in first.stdout
    assert "Cloning" in first.stderr
    assert "Cloning" not in first.stdout
    robot = tmp_path / "mine" / "sim" / "g1" / "robot.yaml"
    assert 'model: "robot_descriptions:g1_mj_description"\n' in robot.read_text()

    shutil.move(published, published.with_name("unreachable"))  # what is in the cache needs no network
    checked = command("check", "sim/g1/robot.yaml")
    assert checked.returncode == 0, checked.stdout + checked.stderr
    run = command("run", "stand", "--robot", "g1", "--duration", "0.1", "--record", "run.rrd")
    assert "recording  run.rrd" in run.stdout, run.stderr


@pytest.mark.trials
def test_another_file_beside_the_description_s_own(command: Command, tmp_path: Path) -> None:
    done = command("robots", "init", "robot_descriptions:g1_mj_description/g1_with_hands.xml")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "mine" / "sim" / "g1_with_hands" / "robot.yaml").read_text()
    assert 'model: "robot_descriptions:g1_mj_description/g1_with_hands.xml"\n' in text
    wrong = command("robots", "init", "robot_descriptions:g1_mj_description/g1_with_hand.xml")
    assert wrong.returncode == 2
    assert "'g1_mj_description' has no file 'g1_with_hand.xml'" in wrong.stderr
    assert "valid: g1.xml, g1_with_hands.xml" in wrong.stderr


@pytest.mark.trials
def test_what_cannot_be_fetched_says_why_and_what_else_there_is(
    command: Command, published: Path, tmp_path: Path
) -> None:
    assert command("robots", "init", "robot_descriptions:g1_mj_description").returncode == 0
    shutil.rmtree(tmp_path / "cache")
    shutil.rmtree(published)
    found = command("check", "sim/g1/robot.yaml")
    assert found.returncode == 2
    said = " ".join((found.stdout + found.stderr).split())
    assert "sim/g1/robot.yaml:7:8: error: the robot description 'g1_mj_description' cannot be fetched: fatal:" in said
    assert "ROBOT_DESCRIPTIONS_CACHE" in said
    assert "its MJCF file in place of the description" in said
    assert "Traceback" not in said


def _robot(folder: Path, model: str) -> Path:
    text = (HUMANOID / "robot.yaml").read_text().replace("model: humanoid.xml", f"model: {model}")
    path = folder / "robot.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("model", "says", "hint"),
    [
        ("g1_mj", "there is no robot description 'g1_mj'", "g1_mj_description"),
        ("h1_description", "the robot description 'h1_description' has no MJCF", "h1_mj_description"),
        ("baxter_description", "the robot description 'baxter_description' has no MJCF", "from elsewhere"),
    ],
)
def test_a_description_that_is_none_is_refused_with_its_line(tmp_path: Path, model: str, says: str, hint: str) -> None:
    pytest.importorskip("robot_descriptions", reason="pip install 'humanoid-bt[descriptions]'")
    path = _robot(tmp_path, f"robot_descriptions:{model}")
    with pytest.raises(UserError) as caught:
        load_robot_config(path)
    (problem,) = caught.value.problems
    assert says in problem.message
    assert hint in problem.hint
    assert problem.place is not None
    assert problem.place.line is not None


def test_without_the_package_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "robot_descriptions", None)  # as if it were not there
    with pytest.raises(UserError, match="not installed") as caught:
        load_robot_config(_robot(tmp_path, "robot_descriptions:g1_mj_description"))
    assert "pip install 'humanoid-bt[descriptions]'" in str(caught.value)
    with pytest.raises(UserError, match="not installed"):
        described_file("robot_descriptions:g1_mj_description")


def test_a_file_that_is_missing(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"the model file 'nothing\.xml' is missing"):
        model_file("nothing.xml", tmp_path)


@pytest.mark.parametrize(
    ("model", "name"),
    [
        ("robot_descriptions:g1_mj_description", "g1"),
        ("robot_descriptions:cassie_description", "cassie"),
        ("robot_descriptions:g1_mj_description/g1_with_hands.xml", "g1_with_hands"),
    ],
)
def test_what_its_robot_is_called(model: str, name: str) -> None:
    assert described_name(model) == name
