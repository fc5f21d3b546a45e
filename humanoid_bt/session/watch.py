"""Looking for edits beside the run, so that no tick waits for a file."""

from __future__ import annotations

import gc
import logging
import threading
from collections import deque
from typing import Self

from humanoid_bt.session.edits import Edit, EditSource

_log = logging.getLogger(__name__)

_INTERVAL = 0.2  # s between two looks
_FAREWELL = 1.0  # s that the end of a run waits for a tree that is being loaded


class Watch:
    """Polls another source of edits in a thread of its own.

    Loading and setting up a tree happens in that thread. It shares the interpreter with the ticks, which wait for it
    a few milliseconds at most, unless a skill's file holds the interpreter for longer when it is imported.

    Use it as a context manager.

    Args:
        edits: what is polled.
    """

    def __init__(self, edits: EditSource) -> None:
        self._edits = edits
        self._found: deque[Edit] = deque()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="watch", daemon=True)

    def poll(self) -> Edit | None:
        """Return the next edit that was found."""
        return self._found.popleft() if self._found else None

    def __enter__(self) -> Self:
        # Loading makes enough objects for Python to look for cycles among all there are, with MuJoCo and the viewer
        # 50 ms of silence. What is there now stays: only what comes later is looked through.
        gc.collect()
        gc.freeze()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join(_FAREWELL)
        gc.unfreeze()

    def _run(self) -> None:
        while not self._over.wait(_INTERVAL):
            try:
                edit = self._edits.poll()
            except Exception:
                _log.exception("internal error: edits are looked for no more")
                return
            if edit is not None:
                self._found.append(edit)
