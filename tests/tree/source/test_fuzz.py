"""Whatever a tree file holds, checking it answers with findings that have a place, and does not take long.

``HUMANOID_BT_MUTATIONS=20000 pytest tests/tree/source/test_fuzz.py`` tries more files than usual.
"""

from __future__ import annotations

import os
import random
import re
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import pytest

from humanoid_bt.checking.check import checked
from humanoid_bt.core.errors import relative
from humanoid_bt.files.workspace import Workspace, builtin_root
from tests.tree.mutations import Mutator

MUTATIONS = int(os.environ.get("HUMANOID_BT_MUTATIONS", "300"))
BATCHES = 10
LIMIT = 2  # s of processor time for one file: it detects what hangs and measures nothing
_DOCS = Path(__file__).resolve().parents[3]


def _seeds() -> list[str]:
    """Return whole trees: the built-in ones and those in the docs, with an allowing comment in some."""
    trees = [path.read_text(encoding="utf-8") for path in sorted(builtin_root().glob("trees/*.yaml"))] * 4
    for page in [_DOCS / "README.md", *sorted((_DOCS / "docs").glob("*.md"))]:
        text = page.read_text(encoding="utf-8")
        blocks = re.findall(r"^<!-- tree -->\n```yaml\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
        trees += [block if block.startswith(("format:", "#")) else _around(block) for block in blocks]
    return trees


def _around(part: str) -> str:
    indented = "".join(f"      {line}" for line in part.splitlines(keepends=True))
    head = "format: 1\nroot:\n  emergency_stop:\n    watchdog:\n      percept: target\n      max_age: 0.5 s\n"
    return f"{head}{indented}      # allow no-time-limit: an operator ends it\n"


class _Hangs(BaseException):
    """Checking a file took too long; no handler of exceptions takes it for one."""


@contextmanager
def _guard(seconds: int) -> Iterator[None]:
    def ring(number: int, frame: FrameType | None) -> None:
        raise _Hangs

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


@pytest.mark.parametrize("batch", range(BATCHES))
def test_a_broken_tree_file_is_answered_with_places(batch: int, tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    path = tmp_path / "trees" / "broken.yaml"
    path.parent.mkdir()
    library = [relative(file) for file in Workspace(builtin_root()).trees().values()]  # used as sub-trees
    seeds, choose, mutator = _seeds(), random.Random(batch), Mutator(batch)
    for number in range(MUTATIONS // BATCHES):
        path.write_bytes(mutator.mutate(choose.choice(seeds), choose.choice(seeds)))
        try:
            with _guard(LIMIT):
                problems = checked(path, workspace)
        except BaseException as error:
            error.add_note(f"batch {batch}, file {number}:\n{path.read_bytes()!r}")
            raise
        for problem in problems:
            told = f"batch {batch}, file {number}: {problem}\n{path.read_bytes()!r}"
            assert problem.place is not None, told
            assert problem.place.file in {relative(path), *library}, told
            assert problem.place.line >= 1 and problem.place.column >= 1, told
            f"{problem}".encode()  # it can be written to a file


def test_the_mutations_break_most_files_and_not_all(tmp_path: Path) -> None:
    path = tmp_path / "broken.yaml"
    seeds, choose, mutator = _seeds(), random.Random(0), Mutator(0)
    clean = 0
    for _ in range(100):
        path.write_bytes(mutator.mutate(choose.choice(seeds), choose.choice(seeds)))
        clean += not any(problem.severity == "error" for problem in checked(path, Workspace(tmp_path)))
    assert 1 <= clean <= 60


def test_what_is_mutated_are_many_trees_and_sound(tmp_path: Path) -> None:
    seeds = _seeds()
    assert len(seeds) > 15
    path = tmp_path / "sound.yaml"
    for text in seeds:
        path.write_text(text, encoding="utf-8")
        errors = [problem for problem in checked(path, Workspace(tmp_path)) if problem.severity == "error"]
        assert not [problem for problem in errors if "unknown node" not in problem.message]  # the docs' own skills


def test_the_same_seed_breaks_in_the_same_way() -> None:
    assert [Mutator(3).mutate("a: 1\nb: 2\n", "") for _ in range(3)] == [Mutator(3).mutate("a: 1\nb: 2\n", "")] * 3
