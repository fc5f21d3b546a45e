"""Gateway files: what they say, and where what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import pytest

import humanoid_bt as hbt
from humanoid_bt.core.errors import UserError
from humanoid_bt.gateway.file import Qos, load_gateway

WHOLE = """
format: 1
node: robot_7
frames: {base: pelvis, odom: world, fixed: {camera: {parent: pelvis, position: [10 cm, 0, 0.5]}}}
percepts:
  target: {topic: /ball, confidence: 0.8, qos: {reliability: reliable}}
  cup: {topic: detections, type: vision_msgs/Detection3DArray, class: cup, solid: true}
  tag: {topic: /tag, type: std_msgs/Float64MultiArray, fields: {x: data.0, y: data.1, z: data.2}, stamp: arrival}
estop: {topic: /estop, timeout: 500 ms, reset: ~/reset}
publish: {joint_states: {rate: 20 Hz}, status: {topic: /tree}}
"""


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "gateways").mkdir()
    (tmp_path / "gateways/mine.yaml").write_text(WHOLE)
    return tmp_path


@pytest.mark.usefixtures("workspace")
def test_a_whole_file() -> None:
    assert not hbt.check("gateways/mine.yaml")
    file = load_gateway(Path("gateways/mine.yaml"))
    assert (file.node, file.network, file.frames.base) == ("robot_7", "loopback", "pelvis")
    assert file.frames.fixed["camera"].position == (0.1, 0, 0.5)
    assert file.percepts["cup"].class_ == "cup"
    assert file.estop is not None
    assert file.estop.timeout == 0.5
    assert file.publish.joint_states is not None
    assert file.publish.joint_states.rate == 20
    assert file.publish.tf is None


def test_what_a_topic_leaves_open_is_as_usual() -> None:
    usual = Qos(reliability="best_effort", durability="volatile", depth=5)
    assert Qos(depth=2).over(usual) == Qos(reliability="best_effort", durability="volatile", depth=2)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("publish:", "publsh:", "10:1: unknown key 'publsh' of the gateway"),
        ("topic: /ball,", "", "6:11: the key 'topic' of the percept 'target' is missing"),
        ("/ball", "ball/", "6:19: 'ball/' cannot be a topic"),
        ("vision_msgs/Detection3DArray", "Detections", "7:34: 'Detections' is no type of messages"),
        ("z: data.2", "zz: data.2", "8:28: where a 'std_msgs/Float64MultiArray' has its x, y and z is not said"),
        ("reliability: reliable", "reliability: sure", "6:62: 'reliability' cannot be 'sure'"),
        ("timeout: 500 ms", "timeout: 0", "9:33: 'timeout' must be > 0, not 0"),
        ("parent: pelvis", "parent: head", "4:45: nobody knows where the frame 'head' is"),
        ("odom: world", "odom: pelvis", "4:30: base and odom are both 'pelvis'"),
        (
            "position: [10 cm, 0, 0.5]",
            "orientation: [1, 1, 0, 0]",
            "4:83: an orientation is a unit quaternion wxyz, and this has the length 1.41421",
        ),
        ("joint_states: {rate: 20 Hz}", "joints: {}", "10:11: unknown key 'joints' of 'publish'"),
        ("rate: 20 Hz", "rate: 100 Hz", "10:32: 'rate' must be > 0 and <= 50, not '100 Hz'"),
        ("robot_7", "robot 7", "3:7: 'robot 7' cannot be a node"),
    ],
)
@pytest.mark.usefixtures("workspace")
def test_a_mistake_is_told_where_it_is(old: str, new: str, told: str) -> None:
    assert old in WHOLE
    Path("gateways/mine.yaml").write_text(WHOLE.replace(old, new, 1))
    problems = hbt.check("gateways/mine.yaml")
    assert f"gateways/mine.yaml:{told}" in [f"{problem.place}: {problem.message}" for problem in problems]


def test_a_name_is_looked_up_in_the_workspace(workspace: Path) -> None:
    with pytest.raises(UserError, match=r"no gateway named 'mien'(.|\n)*did you mean 'mine'"):
        hbt.Session("fetch", workspace=workspace, mode="realtime", gateway="mien")


def test_lockstep_has_no_ros_time() -> None:
    with pytest.raises(UserError, match="'gateway' does not go with the mode lockstep"):
        hbt.Session("fetch", gateway="mine")
