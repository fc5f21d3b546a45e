"""The fenced blocks of the docs, and running them as a reader would.

Every fenced block says in an HTML comment on the line above it what becomes of it:

    <!-- file: trees/mine.yaml -->      it is written to this file
    <!-- run -->                        it is run by the shell and must succeed
    <!-- run: exit 2 -->                ... or end with this exit code
    <!-- output -->                     it is what the block run before printed
    <!-- output: COMMAND -->            ... or what this command prints
    <!-- tree -->                       it is loaded: a tree file, or a part of one below an emergency stop and a
                                        watchdog on the percept "target"
    <!-- skip: why -->                  it is not run

A page's blocks run in its order, in one folder that is empty at first. Numbers in an output are not compared:
they differ from one machine to the next. A page whose examples need pictures says so in its first line,
``<!-- needs: opengl -->``; on a machine that cannot render they are not run.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.tree import Tree

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
TIMEOUT = 60  # s for one block

_AROUND = """\
format: 1
root:
  emergency_stop:
    watchdog:
      percept: target
      max_age: 0.5 s
"""

_FENCE = re.compile(r"^(`{3,})(.*)$")
_NEEDS_PICTURES = "<!-- needs: opengl -->"
_MARK = re.compile(r"^<!-- (file|run|output|tree|skip)(?:: (.*?))? -->$")
_NUMBER = re.compile(r"\b[0-9a-f]{16}\b|\d+(?:\.\d+)?(?:-\d{6})?")


@dataclass(frozen=True)
class Block:
    """One fenced block.

    Attributes:
        page: its file.
        first, last: index of its first line and of the one after its last, fences left out.
        mark: what becomes of it, "" if it does not say so.
        detail: what stands behind the mark.
        text: what it holds.
    """

    page: Path
    first: int
    last: int
    mark: str
    detail: str
    text: str

    def __str__(self) -> str:
        return f"{self.page.name}:{self.first}"


def pages() -> list[Path]:
    """Return every page of the docs."""
    docs = ROOT / "docs"
    return [ROOT / "README.md", *sorted(docs.glob("*.md")), *sorted((docs / "trees").glob("*.md"))]


def read(page: Path) -> list[Block]:
    """Return a page's fenced blocks in their order."""
    blocks: list[Block] = []
    lines = page.read_text(encoding="utf-8").splitlines()
    begin, fence = -1, ""
    for number, line in enumerate(lines):
        found = _FENCE.match(line)
        if not found:
            continue
        if not fence:
            begin, fence = number, found[1]
        elif found[1] == fence and not found[2]:
            mark = _MARK.match(lines[begin - 1]) if begin else None
            what, detail = (mark[1], mark[2] or "") if mark else ("", "")
            text = "\n".join(lines[begin + 1 : number]) + "\n"
            blocks.append(Block(page, begin + 1, number, what, detail, text))
            fence = ""
    return blocks


class Shell:
    """Runs the blocks of one page in a folder; ``cd`` lasts from one block to the next."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._note = folder, folder.parent / f"{folder.name}.cwd"
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
        quiet = {"PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "COLUMNS": "100"}
        self._environment = os.environ | quiet | {"PATH": path, "PYTHONPATH": str(ROOT)}
        for display in ("DISPLAY", "WAYLAND_DISPLAY"):
            self._environment.pop(display, None)

    def run(self, script: str) -> tuple[int, str]:
        """Run a script; return its exit code and what it printed."""
        done = subprocess.run(
            ["/bin/sh", "-ec", f"trap 'pwd > \"{self._note}\"' EXIT\n{script}"],
            cwd=self._folder,
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            encoding="utf-8",
            timeout=TIMEOUT,
            check=False,
        )
        self._folder = Path(self._note.read_text(encoding="utf-8").strip())
        return done.returncode, tidy(done.stdout)

    def write(self, name: str, text: str) -> None:
        """Write a file."""
        path = self._folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def needs_pictures(page: Path) -> bool:
    """Return whether the examples of a page need a machine that can render."""
    return page.read_text().startswith(_NEEDS_PICTURES)


def play(blocks: list[Block], folder: Path) -> dict[Block, str]:
    """Do with a page's blocks what they say; return what was printed where a block shows another output.

    Args:
        blocks: of one page.
        folder: an empty folder.

    Raises:
        RuntimeError: a block ended with another exit code than it says.
        UserError: a tree cannot be loaded.
    """
    shell, printed = Shell(folder), ""
    changed: dict[Block, str] = {}
    for block in blocks:
        if block.mark == "file":
            shell.write(block.detail, block.text)
        elif block.mark == "run" or (block.mark == "output" and block.detail):
            wanted = int(block.detail.removeprefix("exit ")) if block.detail and block.mark == "run" else 0
            code, printed = shell.run(block.text if block.mark == "run" else block.detail)
            if code != wanted:
                raise RuntimeError(f"{block} ended with exit code {code}, not {wanted}:\n{block.text}\n{printed}")
        elif block.mark == "tree":
            load(block.text, folder)
        if block.mark == "output" and not same(printed, block.text):
            changed[block] = printed
    return changed


def load(text: str, folder: Path) -> Tree:
    """Load a tree file's text, or a part of one.

    Args:
        text: the YAML text.
        folder: where a file may be written.

    Raises:
        UserError: it has mistakes.
    """
    path = folder / "example.yaml"
    whole = text.startswith(("format:", "#"))
    path.write_text(text if whole else _AROUND + textwrap.indent(text, "      "), encoding="utf-8")
    return load_tree(path, Workspace(folder))


def tidy(text: str) -> str:
    """Return an output without empty lines at its ends and without spaces at its lines' ends."""
    return "\n".join(line.rstrip() for line in text.strip("\n").splitlines()) + "\n"


def same(one: str, other: str) -> bool:
    """Return whether two outputs differ in nothing but numbers and spaces."""
    return _comparable(one) == _comparable(other)


def _comparable(text: str) -> str:
    return re.sub(r"[ ]+", " ", _NUMBER.sub("#", tidy(text)))


def rewrite(page: Path, changed: dict[Block, str]) -> None:
    """Put the outputs into a page that its commands print now."""
    lines = page.read_text(encoding="utf-8").splitlines()
    for block in sorted(changed, key=lambda block: block.first, reverse=True):
        lines[block.first : block.last] = changed[block].splitlines()
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")
