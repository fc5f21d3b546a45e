from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.gateway.nodes import Peer
from tests.projects import make_project
from tests.realtime.helpers import Live, until

GATEWAY = """
format: 1
percepts:
  target: {topic: /ball, confidence: 0.9}
estop: {topic: /estop, reset: /reset}
publish:
  joint_states: {}
  odometry: {topic: /odom}
  diagnostics: {rate: 5}
  status: {topic: /status}
  command: {topic: /command}
  nodes: {topic: /nodes}
  events: {topic: /events}
  robot_description: {topic: /robot_description}
"""

SILENCE = """
format: 1
estop: {topic: /estop, timeout: 1 s, reset: /reset}
"""
ACTION = """
format: 1
action: {name: /rest, type: test_msgs/action/Fibonacci, parameters: {duration: order}}
"""
REST = """
format: 1
parameters: {duration: 5 s}
root: {emergency_stop: {pause: {duration: $duration}}}
"""


@pytest.fixture(scope="session")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's project folder with a gateway."""
    project = make_project(tmp_path_factory.mktemp("user") / "project")
    (project / "trees/stand.yaml").write_text("format: 1\nroot: {emergency_stop: idle}\n")
    (project / "gateways").mkdir()
    (project / "trees/rest.yaml").write_text(REST)
    (project / "gateways/robot.yaml").write_text(GATEWAY)
    (project / "gateways/silence.yaml").write_text(SILENCE)
    (project / "gateways/action.yaml").write_text(ACTION)
    return project


@pytest.fixture
def live(project: Path, tmp_path: Path) -> Iterator[Callable[..., Live]]:
    """Start a run with a gateway as a process of its own; nothing of it outlives the test."""
    started: list[Live] = []

    def start(tree: str, *options: str, gateway: str = "robot") -> Live:
        folder = tmp_path / f"{len(started)}"
        run = Live(project, folder, tree, "--gateway", gateway, *options, record=False)
        started.append(run)
        run.ready()
        roles = {"gateway"} | ({"gateway_estop"} if gateway in ("robot", "silence") else set())
        until("the gateway's start", lambda: roles <= run.folder.info.processes.keys())
        run.pids = dict(run.folder.info.processes)
        return run

    yield start
    for run in started:
        run.destroy()


@pytest.fixture
def peer(monkeypatch: pytest.MonkeyPatch) -> Iterator[Peer]:
    """A node of ROS 2, which only nodes of this test find."""
    rclpy = pytest.importorskip("rclpy")
    from rclpy.context import Context

    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    context = Context()
    rclpy.init(args=[], context=context)
    node = Peer(context)
    yield node
    node.close()
    context.try_shutdown()
