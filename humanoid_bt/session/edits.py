"""Edits of a tree that runs: found by looking at its files, loaded, checked and set up before anybody swaps anything.

Looking costs a fraction of a millisecond for the few small files of a workspace, works on every file system and needs
no library. It reads them whole each time: sizes and times of files do not tell every change.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from humanoid_bt.core.errors import Problem, UserError, relative, resolved
from humanoid_bt.files.reading import read_bytes
from humanoid_bt.session.loader import TreeLoader, used_files
from humanoid_bt.tree.ticking.executor import Executor, NodeError
from humanoid_bt.tree.tree import Tree

_PATIENCE = 5  # looks that a file may be missing or empty: editors and other programs write in many ways

_Contents = Mapping[Path, bytes]


@dataclass(frozen=True)
class Edit:
    """Files were edited, and this is what came of it: a new tree, mistakes, or nothing to do.

    Attributes:
        files: those that changed, as people read them.
        executor: of the edited tree, set up; None if it has mistakes or is what runs already.
        problems: the mistakes.
    """

    files: tuple[str, ...]
    executor: Executor | None = None
    problems: tuple[Problem, ...] = ()


class EditSource(Protocol):
    """Where a run gets edits from."""

    def poll(self) -> Edit | None:
        """Return the next edit, None if there is none."""


class Edits:
    """Finds edits by looking at files, one look per :meth:`poll`.

    An edit counts once its files have been the same in two looks. One that is written while it is loaded counts when
    it has been written.

    Args:
        loader: loads the tree.
        prepare: sets a tree up on the robot.
    """

    def __init__(self, loader: TreeLoader, prepare: Callable[[Tree], Executor]) -> None:
        self._loader, self._prepare = loader, prepare
        self._tree = loader.first
        self._runs: _Contents = self._look()  # what the tree that runs was made of
        self._told = self._last = self._runs  # at the last edit, at the last look
        self._looks = 0  # since the files changed
        self._problems: tuple[Problem, ...] = ()

    def poll(self) -> Edit | None:
        """Look once; return an edit when it is complete."""
        now = self._look()
        self._looks = self._looks + 1 if now == self._last else 0
        self._last = now
        changed = _changes(self._told, now)
        if not changed or self._looks < (1 if all(map(now.get, changed)) else _PATIENCE):
            return None
        edit = self._load(changed)
        if self._look() != now:
            return None  # what was loaded may be half of it
        self._told = now
        if edit.executor is not None:
            self._tree = edit.executor.tree
            self._runs = self._told = self._last = {**self._look(), **now}  # it may be made of further files
        news = edit.executor is not None or edit.problems != self._problems
        self._problems = edit.problems
        return edit if news else None

    def _load(self, changed: Iterable[Path]) -> Edit:
        files = tuple(sorted(map(relative, changed)))
        try:
            tree = self._loader.reload()
            if not _changes(self._runs, self._last) & (used_files(self._tree) | used_files(tree)):
                return Edit(files)
            return Edit(files, self._prepare(tree))
        except UserError as error:
            return Edit(files, problems=tuple(p for p in error.problems if p.severity == "error"))
        except NodeError as error:
            return Edit(files, problems=(Problem(str(error)),))

    def _look(self) -> dict[Path, bytes]:
        """Return what every file holds; a missing one is not there."""
        found: dict[Path, bytes] = {}
        for path in self._loader.files(self._tree):
            with contextlib.suppress(UserError):
                found[resolved(path)] = read_bytes(path)
        return found


def _changes(before: _Contents, after: _Contents) -> set[Path]:
    return {path for path in before.keys() | after.keys() if before.get(path) != after.get(path)}
