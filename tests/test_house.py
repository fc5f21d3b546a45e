"""The rooms of the package: who may import whom, and that nothing goes in circles."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).resolve().parents[1]


def circle(imports: Mapping[str, set[str]]) -> list[str]:
    """Return files that import each other in a circle, none if there is no circle."""
    done: set[str] = set()
    way: list[str] = []

    def visit(file: str) -> list[str]:
        if file in way:
            return way[way.index(file) :]
        if file in done:
            return []
        way.append(file)
        for other in sorted(imports.get(file, ())):
            if found := visit(other):
                return found
        done.add(way.pop())
        return []

    return next((found for file in sorted(imports) if (found := visit(file))), [])


def test_the_contracts_of_the_rooms_hold() -> None:
    command = [Path(sys.executable).with_name("lint-imports"), "--no-cache"]  # here it would switch off all loggers
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_no_file_imports_itself_through_others() -> None:
    graph = grimp.build_graph("humanoid_bt", cache_dir=None)
    assert not circle({file: graph.find_modules_directly_imported_by(file) for file in graph.modules})


@pytest.mark.parametrize(
    ("imports", "found"),
    [
        ({"a": {"b"}, "b": {"c"}, "c": set()}, []),
        ({"a": {"b", "c"}, "b": {"c"}, "c": set()}, []),
        ({"a": {"b"}, "b": {"a"}}, ["a", "b"]),
        ({"a": {"b"}, "b": {"c"}, "c": {"d"}, "d": {"b"}}, ["b", "c", "d"]),
    ],
)
def test_circles_are_found(imports: Mapping[str, set[str]], found: list[str]) -> None:
    assert circle(imports) == found


_SILENCED = re.compile(r"# (?:type: ignore(?:\[[^\]]*\])?|noqa(?:: [A-Z\d, ]+)?)(?P<why>.*)")


def unexplained(text: str) -> list[int]:
    """Return the lines in which a checker is silenced and no reason stands behind it, nor in a line above."""
    lines = text.splitlines()
    found = []
    for number, line in enumerate(lines, 1):
        silenced = _SILENCED.search(line)
        if silenced and not silenced["why"].strip() and not lines[max(number - 2, 0)].lstrip().startswith("# "):
            found.append(number)
    return found


def test_whoever_silences_a_checker_says_why() -> None:
    files = [file for folder in ("humanoid_bt", "tests", "docs") for file in (ROOT / folder).rglob("*.py")]
    silent = {str(file.relative_to(ROOT)): unexplained(file.read_text(encoding="utf-8")) for file in files}
    assert not {file: lines for file, lines in silent.items() if lines}


def test_silence_without_a_reason_is_found() -> None:
    assert not unexplained("a = b  # type: ignore[misc, arg-type]  # no types\nc = 1  # noqa: E731 (shorter)\n")
    assert not unexplained("# it has no types\na = b  # type: ignore[misc]\n")
    assert unexplained("a = b  # type: ignore[misc, arg-type]\nc = 1  # noqa: E731\n") == [1, 2]
