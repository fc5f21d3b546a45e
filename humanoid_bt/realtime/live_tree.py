"""The tree of a run as others see it while it runs: told by decision, drawn by ``humanoid-bt show --live``."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from py_trees.common import Status

from humanoid_bt.core.texts import shortened
from humanoid_bt.link.ring import RingReader, RingWriter
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.link.segment import LinkError
from humanoid_bt.realtime import channels
from humanoid_bt.tree.show.outline import Outline
from humanoid_bt.tree.tree import Tree

_OUTLINE = "tree.json"
_LETTERS = {Status.INVALID: "-", Status.RUNNING: "R", Status.SUCCESS: "S", Status.FAILURE: "F"}
_STATUSES = {letter: status for status, letter in _LETTERS.items()}
_TELLING = (Status.RUNNING, Status.FAILURE)  # what these nodes say explains what the robot does
_LONGEST = 200  # characters of what a node says
_OPTIONAL = {"feedback_of", "statuses", "unseen", "percepts"}  # left out of what would not fit, the longest first


class TreeTeller:
    """Tells what a tree does. Decision's end.

    Args:
        folder: of the run; its status channel is there.
    """

    def __init__(self, folder: RunFolder) -> None:
        self._folder = folder
        self._ring: RingWriter = channels.writer(folder, "status")
        self._outlined: Tree | None = None
        self._number = 0  # of the outline

    def tell(self, status: Mapping[str, object], tree: Tree) -> None:
        """Tell what goes on.

        Args:
            status: what is known besides, plain data.
            tree: whose nodes' statuses are told, and what the running and the failed ones say.
        """
        if self._outlined is not tree:
            self._outlined = tree
            self._number += 1
            with contextlib.suppress(OSError):  # no room in memory: nobody can draw it, and the robot goes on
                self._write_outline(tree)
        found = [node.behaviour.status for node in tree.nodes]
        said = {
            index: shortened(tree.nodes[index].behaviour.feedback_message, _LONGEST)
            for index, status in enumerate(found)
            if status in _TELLING and tree.nodes[index].behaviour.feedback_message
        }
        told = {"statuses": "".join(map(_LETTERS.__getitem__, found)), "feedback_of": said}
        message = {**status, "outline": self._number, **told}
        data = json.dumps(message).encode()
        while len(data) > self._ring.slot_size and (there := message.keys() & _OPTIONAL):
            del message[max(there, key=lambda key: len(json.dumps(message[key])))]
            data = json.dumps(message).encode()
        self._ring.write(data[: self._ring.slot_size])

    def _write_outline(self, tree: Tree) -> None:
        draft = self._folder.path(f"{_OUTLINE}.draft")
        draft.write_text(Outline.of(tree).to_json(), encoding="utf-8")
        draft.rename(self._folder.path(_OUTLINE))

    def close(self) -> None:
        """Let go of the channel."""
        self._ring.close()


@dataclass(frozen=True)
class Moment:
    """What a tree does at one time.

    Attributes:
        outline: what is drawn of it.
        time: engine time [s].
        statuses: node path -> status.
        feedback: node path -> what the node says.
    """

    outline: Outline
    time: float
    statuses: Mapping[str, Status]
    feedback: Mapping[str, str]


class TreeWatch:
    """Sees what a tree does. Anybody's end.

    Args:
        folder: of the run.
    """

    def __init__(self, folder: RunFolder) -> None:
        self._folder = folder
        self._outline: Outline | None = None
        self._number = 0  # of the outline
        self._ring: RingReader | None = None

    def latest(self) -> Moment | None:
        """Return what was told last; None before anything was told."""
        try:
            self._ring = self._ring or channels.reader(self._folder, "status")
            entry = self._ring.latest()
            told: dict[str, Any] = json.loads(entry[1]) if entry else {}
            number = told.get("outline", 0)
            if self._outline is None or self._number != number:  # another tree may have taken its place
                self._outline = Outline.from_json(self._folder.path(_OUTLINE).read_text(encoding="utf-8"))
                self._number = number
        except (LinkError, OSError, ValueError):  # it is just starting, or just over
            return None
        nodes, letters = self._outline.nodes, told.get("statuses", "")
        if len(letters) != len(nodes):
            return None
        return Moment(
            self._outline,
            float(told.get("time", 0.0)),
            {node.path: _STATUSES.get(letter, Status.INVALID) for node, letter in zip(nodes, letters, strict=True)},
            {nodes[int(index)].path: text for index, text in told.get("feedback_of", {}).items()},
        )

    @property
    def over(self) -> bool:
        """Whether the run has ended, or every process of it died."""
        with contextlib.suppress(LinkError):
            return not self._folder.info.alive
        return True

    @property
    def abandoned(self) -> bool:
        """Whether decision died, and others of the run's processes live."""
        with contextlib.suppress(LinkError):
            return not self._folder.info.owner_alive
        return False

    def close(self) -> None:
        """Let go of the channel."""
        if self._ring is not None:
            self._ring.close()
