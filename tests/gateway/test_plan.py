"""What is refused before a run with a gateway begins, and told where it is written."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

import humanoid_bt as hbt
from humanoid_bt.core.errors import UserError
from humanoid_bt.gateway import plan

FILE = "format: 1\npercepts:\n  target: {topic: /ball}\n"


@pytest.fixture
def gateway(tmp_path: Path) -> Path:
    path = tmp_path / "gateway.yaml"
    path.write_text(FILE)
    return path


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if ROS 2 were there, with every type."""
    monkeypatch.setattr(plan, "check_types", lambda _config: None)


def session(gateway: Path, **more: Any) -> hbt.Session:
    return hbt.Session("fetch", mode="realtime", gateway=gateway, **more)


def test_without_ros_the_message_says_what_to_install(gateway: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *of: None if name == "rclpy" else find(name, *of))
    with pytest.raises(UserError, match=r"no 'rclpy'(.|\n)*pip install 'humanoid-bt\[ros\]'"):
        session(gateway)


@pytest.mark.usefixtures("installed")
def test_the_tracker_leaves_percepts_to_the_gateway_and_a_source_does_not(gateway: Path) -> None:
    engine = session(gateway).engine
    assert list(engine.publishes) == ["target"]
    with pytest.raises(UserError, match=r"source 'color_blob' and the gateway publish the percept 'target'"):
        session(gateway, perception="color_blob")


@pytest.mark.usefixtures("installed")
def test_a_percept_that_only_the_gateway_has_is_published(gateway: Path) -> None:
    gateway.write_text(FILE.replace("target", "door"))
    assert set(session(gateway).engine.publishes) == {"door", "target"}


@pytest.mark.usefixtures("installed")
def test_what_the_gateway_publishes_is_missed_by_no_check(gateway: Path, tmp_path: Path) -> None:
    tree = tmp_path / "look.yaml"
    watch = "watchdog: {percept: %s, max_age: 1 s, timeout: {duration: 9 s, emergency_stop: idle}}"
    tree.write_text(f"format: 1\nroot: {{sequence: [{{{watch % 'target'}}}, {{{watch % 'nobody'}}}]}}\n")
    run = hbt.Session(tree, mode="realtime", gateway=gateway, perception={"color_blob": {"target": "seen"}})
    missed = [one for one in run.tree.warnings if one.code == "unknown-percept"]
    assert ["'nobody'" in one.message for one in missed] == [True]
