"""Counting what the nodes of trees do while they run.

A process counts while the environment names a folder for it (:data:`FOLDER`), and writes a file of its own there: so
do all processes that it starts.
"""

from __future__ import annotations

import json
import logging
import os
import uuid
from contextlib import suppress
from pathlib import Path

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.errors import resolved
from humanoid_bt.files.whole import write_whole
from humanoid_bt.tree.coverage import DEED_OF, Coverage
from humanoid_bt.tree.tree import Tree

FOLDER = "HUMANOID_BT_TREE_COVERAGE"
"""Name of the environment variable: the folder into which what was counted is written."""

_log = logging.getLogger(__name__)


class Tally:
    """Counts what the nodes of one tree do.

    Args:
        recorder: whom it counts for.
        tree: the tree.
    """

    def __init__(self, recorder: Recorder, tree: Tree) -> None:
        self._recorder, self._root = recorder, tree.root
        at = recorder.coverage.add(tree)
        self._nodes = {node.behaviour: at[node.path] for node in tree.nodes if node.path in at}
        self._before: dict[Behaviour, Status] = {}

    def touched(self, behaviour: Behaviour) -> None:
        """Count what a node has just done: it was ticked, or halted."""
        node, status = self._nodes.get(behaviour), behaviour.status
        before = self._before.get(behaviour)
        if node is not None and before is not status:
            self._before[behaviour] = status
            deed = DEED_OF.get(status) or _halted(behaviour, before)
            if not node.ticked or (deed and deed not in node.seen):
                node.ticked = self._recorder.changed = True
                if deed:
                    node.seen.add(deed)
        if behaviour is self._root and status is not Status.RUNNING:
            self._recorder.save()


class Recorder:
    """Counts for one process, and writes it down whenever a tree has ended that did something new.

    Args:
        name: the folder that takes its file.

    Attributes:
        folder: the same, wherever the process goes.
        process: whom it counts for.
        coverage: what was counted so far.
        changed: whether there is something to write.
    """

    def __init__(self, name: str) -> None:
        self.name, self.process = name, os.getpid()
        self.folder = folder = resolved(Path(name))
        self.coverage, self.changed = Coverage(), True
        with suppress(OSError):  # it shows when something is written
            folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / f"{self.process}-{uuid.uuid4().hex[:8]}.json"

    def save(self) -> None:
        """Write what was counted, if it is more than before."""
        if not self.changed:
            return
        self.changed = False
        try:
            write_whole(self._file, json.dumps(self.coverage.to_dict(str)).encode())
        except OSError as error:
            _log.warning("tree coverage is not written: %s", error)


_recorder: Recorder | None = None


def recorder() -> Recorder | None:
    """Return who counts in this process, None if nobody is to."""
    global _recorder  # noqa: PLW0603 (one for the whole process, as the environment is)
    folder, process = os.environ.get(FOLDER, ""), os.getpid()
    if _recorder is not None and (_recorder.name, _recorder.process) != (folder, process):
        if _recorder.process == process and _recorder.folder.is_dir():
            _recorder.save()
        _recorder = None
    if _recorder is None and folder:
        _recorder = Recorder(folder)
    return _recorder


def tally(tree: Tree) -> Tally | None:
    """Return what counts the nodes of a tree that is about to run, None if nobody is to."""
    found = recorder()
    return None if found is None else Tally(found, tree)


def _halted(behaviour: Behaviour, before: Status | None) -> str:
    """Return the deed of a node that runs no more: what raised has not been halted."""
    return "halted" if before is Status.RUNNING and str(behaviour.feedback_message).startswith("halted: ") else ""
