"""Percepts from messages of ROS 2: placed, stamped, checked, kept until the engine takes them."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping
from typing import Any

from humanoid_bt.core.geometry import heading_of, quaternion, rotation_matrix
from humanoid_bt.core.messages import Level, Percept
from humanoid_bt.gateway.clock import EngineClock
from humanoid_bt.gateway.file import PerceptTopic
from humanoid_bt.gateway.frames import FrameTree, NotYetKnown, UnknownFrame
from humanoid_bt.gateway.percepts import Malformed, Sighting, sighting
from humanoid_bt.perception.worker import PerceptError, checked

_AHEAD = 0.1
"""How far in the future a stamp may be [s]: as far as the engine's clock can be told between two states."""

_OLDEST = 60.0  # s: older than any tree believes
_SILENCE = 1.0  # s

News = Callable[[Level, str], None]


class Inbox:
    """Takes messages, in the thread that hears them; gives percepts, in the thread that passes them on.

    A message that cannot be used is told once, until one can be used again.

    Args:
        topics: percept -> where it comes from.
        frames: where the frames of messages are.
        clock: for their stamps.
        base: name of the robot's base frame.
        news: is told what is wrong with messages, from any thread.
    """

    def __init__(
        self, topics: Mapping[str, PerceptTopic], frames: FrameTree, clock: EngineClock, base: str, news: News
    ) -> None:
        self._topics, self._frames, self._clock, self._base, self._news = topics, frames, clock, base, news
        self._lock = threading.Lock()
        self._latest: dict[str, Percept] = {}
        self._stamps: dict[str, float] = {}
        self._refused: set[str] = set()
        self._heard: dict[str, float] = {}  # topic -> when its last message came, engine time [s]
        self._silent: set[str] = set()
        self.unseen: dict[str, str] = {
            name: f"no message on {topic.topic} yet, of type {topic.type}" for name, topic in topics.items()
        }

    def take(self, name: str, message: Any) -> None:
        """Take a message for a percept."""
        topic = self._topics[name]
        self._heard[self._topics[name].topic] = self._clock.now()
        try:
            if (seen := sighting(message, topic.type, topic.class_, topic.fields)) is None:
                self._why(name, f"the messages on {topic.topic} have no {topic.class_ or 'detection'}")
                return
            percept = self._percept(name, topic, seen)
        except NotYetKnown as error:  # of the first moments of every run: no mistake
            self._why(name, f"a message on {topic.topic} cannot be used yet: {error}")
            return
        except (Malformed, UnknownFrame, PerceptError) as error:
            self._refuse(name, f"a message on {topic.topic} is refused: {error}")
            return
        with self._lock:
            if percept.stamp < self._stamps.get(name, -math.inf):
                return  # it came late
            self._stamps[name] = percept.stamp
            self._latest[name] = percept
            self.unseen.pop(name, None)
            again = name in self._refused
            self._refused.discard(name)
        if again:
            self._news("info", f"messages on {topic.topic} are understood again")

    def flush(self) -> list[Percept]:
        """Return what has come since the last time, the latest of each name."""
        with self._lock:
            percepts, self._latest = list(self._latest.values()), {}
        self._tell_silence()
        return percepts

    def _tell_silence(self) -> None:
        """Tell which topics have fallen silent, or are not any more: ROS 2 itself takes 20 s to miss a node."""
        for topic, heard in list(self._heard.items()):
            silent = self._clock.now() - heard > _SILENCE
            if silent and topic not in self._silent:
                self._silent.add(topic)
                self._news("warning", f"no message on {topic} for {_SILENCE:g} s")
            elif not silent and topic in self._silent:
                self._silent.discard(topic)
                self._news("info", f"messages on {topic} come again")

    def forget_stamps(self) -> None:
        """Take messages again that seem older than the last one: ROS time has jumped."""
        with self._lock:
            self._stamps.clear()
            self._heard.clear()

    def _refuse(self, name: str, text: str) -> None:
        self._why(name, text)
        if name not in self._refused:
            self._refused.add(name)
            self._news("error", text)

    def _why(self, name: str, text: str) -> None:
        if name in self.unseen:
            self.unseen[name] = text

    def _percept(self, name: str, topic: PerceptTopic, seen: Sighting) -> Percept:
        """Return what a message says as a percept: engine time, base frame.

        Raises:
            Malformed: its stamp cannot be.
            UnknownFrame: nobody knows where its frame is.
            NotYetKnown: nobody knows yet where the robot is.
            PerceptError: it is no percept.
        """
        now = self._clock.now()
        stamp = self._stamp(topic, seen, now)
        pose = self._frames.in_base(seen.frame or topic.frame or self._base, stamp)
        turn = rotation_matrix(pose[3:])
        orientation = None if seen.orientation is None else quaternion(turn @ rotation_matrix(seen.orientation))
        percept = Percept(
            name,
            stamp,
            turn @ seen.position + pose[:3],
            topic.confidence if seen.confidence is None else seen.confidence,
            seen.size if topic.solid else None,
            0.0 if orientation is None else heading_of(rotation_matrix(orientation)),
            orientation,
            seen.class_name,
            None if seen.covariance is None else turn @ seen.covariance @ turn.T,
        )
        return checked([percept], [name], now)[0]

    def _stamp(self, topic: PerceptTopic, seen: Sighting, now: float) -> float:
        if topic.stamp == "arrival":
            return min(now, self._clock.engine_time)
        if seen.stamp is None:
            raise Malformed("it has no stamp; the file may say stamp: arrival")
        stamp = self._clock.engine(seen.stamp)
        if not stamp < now + _AHEAD:
            raise Malformed(f"it is stamped {stamp - now:.1f} s in the future: the clocks are not synchronised")
        if stamp < now - _OLDEST:
            raise Malformed(f"it is stamped {now - stamp:.0f} s ago: latched, or of another clock")
        return min(stamp, now, self._clock.engine_time)  # a tick sees nothing from after its state
