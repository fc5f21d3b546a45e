"""From messages to percepts: frames, stamps, what is refused and how often that is told."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.messages import Percept
from humanoid_bt.gateway.clock import EngineClock
from humanoid_bt.gateway.file import FixedFrame, Frames, PerceptTopic
from humanoid_bt.gateway.frames import FrameTree
from humanoid_bt.gateway.inbox import Inbox
from humanoid_bt.gateway.transforms import transforms
from tests.gateway import messages

START = 1000.0  # ROS time at which the engine's clock stands at 5 s
HALF = math.sqrt(0.5)


class Desk:
    """An inbox on clocks that only tests turn."""

    def __init__(self, **topics: PerceptTopic) -> None:
        self.ros, self.mono, self.time = START, 50.0, 5.0
        self.clock = EngineClock(lambda: self.ros, lambda: self.mono)
        self.clock.look(self.time)
        fixed = {"camera": FixedFrame(parent="base_link", position=(0.1, 0.0, 0.5), orientation=(HALF, 0, 0, HALF))}
        self.frames = FrameTree(Frames(fixed=fixed))
        self.news: list[tuple[str, str]] = []
        told = lambda level, text: self.news.append((level, text))  # noqa: E731 (shorter than a function)
        self.inbox = Inbox(topics, self.frames, self.clock, "base_link", told)

    def passes(self, duration: float) -> None:
        self.ros, self.mono, self.time = self.ros + duration, self.mono + duration, self.time + duration
        self.clock.look(self.time)

    def percept(self, message: Any, name: str = "ball") -> Percept | None:
        self.inbox.take(name, message)
        found = self.inbox.flush()
        return found[0] if found else None


@pytest.fixture
def desk() -> Desk:
    return Desk(ball=PerceptTopic(topic="/ball", confidence=0.8))


def test_a_pose_in_the_base_frame(desk: Desk) -> None:
    percept = desk.percept(messages.pose_stamped(START - 0.2, (1, 2, 3)))
    assert percept is not None
    assert percept.position.tolist() == [1, 2, 3]
    assert (percept.stamp, percept.confidence) == (pytest.approx(4.8), 0.8)


def test_a_pose_in_a_fixed_frame(desk: Desk) -> None:
    percept = desk.percept(messages.pose_stamped(START, (1, 0, 0), "camera"))
    assert percept is not None
    assert percept.position == pytest.approx([0.1, 1, 0.5])  # the camera looks to the left
    assert percept.orientation == pytest.approx([HALF, 0, 0, HALF])


def test_a_pose_in_the_world_is_seen_from_where_the_base_was_then(desk: Desk) -> None:
    level = np.array([1.0, 0, 0, 0])
    desk.frames.base_at(4.0, np.array([1.0, 0, 0.8]), level)
    desk.frames.base_at(5.0, np.array([2.0, 0, 0.8]), level)
    percept = desk.percept(messages.pose_stamped(START - 1, (3, 0, 0.8), "odom"))
    assert percept is not None
    assert percept.position == pytest.approx([2, 0, 0])


def test_a_frame_that_moves_counts_as_long_as_it_is_told_of(desk: Desk) -> None:
    told = SimpleNamespace(transforms=[messages.transform("base_link", "head", START, (0, 0, 1))])
    for frame, transform in transforms(told, desk.clock, fixed=False):
        desk.frames.learn(frame, transform)
    percept = desk.percept(messages.pose_stamped(START, (1, 0, 0), "head"))
    assert percept is not None
    assert percept.position == pytest.approx([1, 0, 1])
    desk.passes(1.0)
    assert desk.percept(messages.pose_stamped(START + 1, (1, 0, 0), "head")) is None
    assert "where the frame 'head' is was last said 1.0 s before" in desk.news[0][1]


def test_a_frame_that_moves_counts_where_it_was_when_something_was_seen(desk: Desk) -> None:
    told = [
        messages.transform("base_link", "head", START - 1, (0, 0, 1)),
        messages.transform("base_link", "head", START, (0, 0, 2)),
    ]
    told[1].transform.rotation = messages.turn(-HALF, 0, 0, -HALF)  # a quarter to the left
    for frame, transform in transforms(SimpleNamespace(transforms=told), desk.clock, fixed=False):
        desk.frames.learn(frame, transform)
    halfway = desk.percept(messages.pose_stamped(START - 0.5, (HALF, -HALF, 0), "head"))
    assert halfway is not None
    assert halfway.position == pytest.approx([1, 0, 1.5])
    percept = desk.percept(messages.pose_stamped(START, (1, 0, 0), "head"))
    assert percept is not None
    assert percept.position == pytest.approx([0, 1, 2])


def test_transforms_of_a_clock_that_was_set_back_count(desk: Desk) -> None:
    for stamp, height in ((START + 3600, 9.0), (START, 1.0)):
        told = SimpleNamespace(transforms=[messages.transform("base_link", "head", stamp, (0, 0, height))])
        for frame, transform in transforms(told, desk.clock, fixed=False):
            desk.frames.learn(frame, transform)
    percept = desk.percept(messages.pose_stamped(START, (1, 0, 0), "head"))
    assert percept is not None
    assert percept.position == pytest.approx([1, 0, 1])


def test_a_map_in_which_the_odometry_hangs(desk: Desk) -> None:
    desk.frames.base_at(5.0, np.array([2.0, 0, 0]), np.array([1.0, 0, 0, 0]))
    assert desk.percept(messages.pose_stamped(START, (5, 0, 0), "map")) is None
    assert "nobody says where the frame 'map' is" in desk.news[0][1]
    told = SimpleNamespace(transforms=[messages.transform("map", "odom", START, (1, 0, 0))])
    for frame, transform in transforms(told, desk.clock, fixed=False):
        desk.frames.learn(frame, transform)
    percept = desk.percept(messages.pose_stamped(START, (5, 0, 0), "map"))
    assert percept is not None
    assert percept.position == pytest.approx([2, 0, 0])


def test_before_the_robot_says_where_it_is_no_message_is_a_mistake(desk: Desk) -> None:
    assert desk.percept(messages.pose_stamped(START, (1, 0, 0), "odom")) is None
    assert "cannot be used yet: the robot has not said yet where it is" in desk.inbox.unseen["ball"]
    desk.frames.base_at(5.0, np.zeros(3), np.array([1.0, 0, 0, 0]))
    assert desk.percept(messages.pose_stamped(START, (1, 0, 0), "odom")) is not None
    assert desk.news == []


def test_where_the_base_is_control_knows_better(desk: Desk) -> None:
    desk.frames.base_at(5.0, np.zeros(3), np.array([1.0, 0, 0, 0]))
    told = SimpleNamespace(transforms=[messages.transform("odom", "base_link", START, (9, 9, 9))])
    for frame, transform in transforms(told, desk.clock, fixed=False):
        desk.frames.learn(frame, transform)
    percept = desk.percept(messages.pose_stamped(START, (1, 0, 0), "odom"))
    assert percept is not None
    assert percept.position == pytest.approx([1, 0, 0])


@pytest.mark.parametrize(
    ("message", "why"),
    [
        (messages.pose_stamped(START, (math.nan, 0, 0)), "no (3,) finite numbers"),
        (messages.pose_stamped(START, (1, 0, 0), "moon"), "nobody says where the frame 'moon' is"),
        (messages.pose_stamped(START + 2, (1, 0, 0)), "stamped 2.0 s in the future: the clocks are not synchronised"),
        (messages.pose_stamped(START - 90, (1, 0, 0)), "stamped 90 s ago"),
        (messages.pose_stamped(0, (1, 0, 0)), "it has no stamp; the file may say stamp: arrival"),
        (messages.pose_stamped(START, (1, 0, 0), orientation=messages.turn(2.0)), "the length 2"),
        (
            messages.pose_stamped(START, (1, 0, 0), orientation=messages.turn(math.nan)),
            "the length nan",
        ),
    ],
)
def test_what_cannot_be_used_is_told_once_until_something_can(desk: Desk, message: Any, why: str) -> None:
    assert desk.percept(message) is None
    assert desk.percept(message) is None
    ((level, text),) = desk.news
    assert level == "error"
    assert text.startswith("a message on /ball is refused: ")
    assert why in text
    assert why in desk.inbox.unseen["ball"]
    assert desk.percept(messages.pose_stamped(START, (1, 0, 0))) is not None
    assert desk.news[1:] == [("info", "messages on /ball are understood again")]
    assert not desk.inbox.unseen


def test_a_percept_never_gets_older(desk: Desk) -> None:
    assert desk.percept(messages.pose_stamped(START - 0.1, (1, 0, 0))) is not None
    assert desk.percept(messages.pose_stamped(START - 0.3, (2, 0, 0))) is None


def test_messages_that_come_again_are_as_old_as_their_stamp(desk: Desk) -> None:
    first = desk.percept(messages.pose_stamped(START, (1, 0, 0)))
    desk.passes(3.0)
    again = desk.percept(messages.pose_stamped(START, (1, 0, 0)))
    assert first is not None
    assert again is not None
    assert again.stamp == pytest.approx(first.stamp)


def test_the_surest_detection_of_a_class() -> None:
    topic = PerceptTopic(topic="/seen", type="vision_msgs/Detection3DArray", class_="cup", solid=True)
    desk = Desk(cup=topic)
    seen = [
        messages.detection("cup", 0.4, (1, 0, 0)),
        messages.detection("plate", 0.9, (2, 0, 0)),
        messages.detection("cup", 0.7, (3, 0, 0), size=0.1),
    ]
    message = SimpleNamespace(header=messages.header(START), detections=seen)
    percept = desk.percept(message, "cup")
    assert percept is not None
    assert (percept.position.tolist(), percept.confidence, percept.class_name) == ([3, 0, 0], 0.7, "cup")
    assert percept.size is not None
    assert percept.size.tolist() == [0.1, 0.1, 0.1]
    message.detections = seen[1:2]
    assert desk.percept(message, "cup") is None
    assert not desk.news


def test_any_type_with_named_fields() -> None:
    fields = {"x": "data.0", "y": "data.1", "z": "data.2", "confidence": "data.3"}
    desk = Desk(tag=PerceptTopic(topic="/tag", type="std_msgs/Float64MultiArray", fields=fields, stamp="arrival"))
    percept = desk.percept(SimpleNamespace(data=[1.0, 2.0, 3.0, 0.6]), "tag")
    assert percept is not None
    assert (percept.position.tolist(), percept.confidence, percept.stamp) == ([1, 2, 3], 0.6, 5.0)
    assert desk.percept(SimpleNamespace(data=[1.0]), "tag") is None
    assert "it has nothing at 'data.1'" in desk.news[0][1]
    assert desk.percept(SimpleNamespace(data=[1.0, 2.0, 3.0, 7.0]), "tag") is None
    assert len(desk.news) == 1


def test_a_topic_that_falls_silent_is_told_once(desk: Desk) -> None:
    desk.inbox.flush()
    desk.passes(5.0)
    desk.inbox.flush()
    assert not desk.news  # what never came is no news: it is told as unseen
    assert desk.percept(messages.pose_stamped(desk.ros, (1, 0, 0))) is not None
    for _ in range(3):
        desk.passes(0.6)
        desk.inbox.flush()
    assert desk.news == [("warning", "no message on /ball for 1 s")]
    assert desk.percept(messages.pose_stamped(desk.ros, (1, 0, 0))) is not None
    desk.inbox.flush()
    assert desk.news[1:] == [("info", "messages on /ball come again")]


def test_a_topic_of_two_percepts_falls_silent_once() -> None:
    desk = Desk(ball=PerceptTopic(topic="/seen"), cup=PerceptTopic(topic="/seen"))
    for name in ("ball", "cup"):
        assert desk.percept(messages.pose_stamped(desk.ros, (1, 0, 0)), name) is not None
    desk.passes(1.5)
    desk.inbox.flush()
    assert desk.news == [("warning", "no message on /seen for 1 s")]
