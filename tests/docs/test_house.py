"""The pictures of the house: every room is in them, as it is in the code, and every word can be read."""

from __future__ import annotations

import ast
import re
from itertools import combinations
from pathlib import Path

import blocks
import generate
import pytest
from house import arch, plan
from house.drawing import LOOKS, WIDTH
from house.rooms import PACKAGE, house, says
from house.ways import COMMAND, PERCEPT, Step

ROOT = blocks.ROOT / PACKAGE
ROOMS = sorted(str(file.parent.relative_to(blocks.ROOT)) for file in ROOT.rglob("__init__.py"))
PICTURES = {"house": plan.draw, "ways": arch.draw}
MARGIN = 8.0
PAGE = blocks.ROOT / "docs" / "development.md"


@pytest.mark.parametrize("room", ROOMS)
def test_every_room_says_in_one_short_line_what_it_is(room: str) -> None:
    source = (blocks.ROOT / room / "__init__.py").read_text(encoding="utf-8")
    first, _, rest = (ast.get_docstring(ast.parse(source)) or "").partition("\n")
    assert first.endswith("."), "its docstring begins with a sentence on one line"
    assert len(first) <= 90
    assert not rest or rest.startswith("\n")


@pytest.mark.parametrize("room", ROOMS[1:])
def test_every_room_is_in_the_picture(room: str) -> None:
    name = Path(room).name
    look, shown = ("part", f"{name}/") if room.count("/") > 1 else ("name", name)
    assert re.search(rf'class="{look}"[^>]*>{shown}<', plan.draw()), "it has no floor in pyproject.toml"


def test_rooms_import_only_from_floors_below_or_through_open_walls() -> None:
    above: set[str] = set()
    for floor in house():
        names = {room.name for room in floor}
        for room in floor:
            assert not above & set(room.imports)
            assert floor.open or not names & set(room.imports)
        above |= names


def test_a_room_is_described_by_the_first_sentence_of_its_docstring() -> None:
    described = {room.name: room.says for floor in house() for room in floor}
    assert described["testing"] == says(f"{PACKAGE}.testing")
    assert described["testing"].count(".") == 1


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_the_same_each_time(name: str) -> None:
    assert PICTURES[name]() == PICTURES[name]()


@pytest.mark.parametrize("name", PICTURES)
def test_no_text_leaves_a_picture_or_covers_another(name: str) -> None:
    texts = list(text_boxes(PICTURES[name]()))
    outside = [text for text, (left, _, right, _) in texts if left < MARGIN or right > WIDTH - MARGIN]
    assert not outside
    assert not [(one, other) for (one, a), (other, b) in combinations(texts, 2) if overlap(a, b)]


def test_overlaps_are_found() -> None:
    assert overlap((0, 0, 10, 10), (9, 9, 20, 20))
    assert not overlap((0, 0, 10, 10), (10, 0, 20, 10))


@pytest.mark.parametrize("step", PERCEPT + COMMAND, ids=lambda step: f"{step.file}:{step.name}")
def test_a_step_of_a_way_is_in_its_file(step: Step) -> None:
    assert step.name in defined(step.path)


def test_what_is_named_beside_a_link_is_in_the_linked_file() -> None:
    named = re.findall(r"\]\(([^)]+\.(?:py|yaml))\)((?:, `[\w.]+`)+)", PAGE.read_text(encoding="utf-8"))
    assert len(named) > 20
    for link, names in named:
        words = re.findall(r"\w+", names)
        text = (PAGE.parent / link).read_text(encoding="utf-8")
        assert not [word for word in words if not re.search(rf"\b{word}\b", text)], link


def test_every_file_that_is_named_is_there() -> None:
    names = set(re.findall(r"`([\w/]+\.(?:py|toml))`", PAGE.read_text(encoding="utf-8")))
    folders = [blocks.ROOT / folder for folder in (PACKAGE, "tests", "docs", "skills")]
    files = [str(file) for folder in folders for file in folder.rglob("*.*")] + [str(blocks.ROOT / "pyproject.toml")]
    assert not [name for name in names if not any(file.endswith(f"/{name}") for file in files)]


def test_the_page_shows_the_pictures_that_make_docs_draws() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert {f"{name}.svg" for name in PICTURES} <= {file.name for file in generate.pictures()}
    assert all(f"(images/{name}.svg)" in page for name in PICTURES)


def text_boxes(picture: str) -> list[tuple[str, tuple[float, float, float, float]]]:
    """Return the texts of a picture with the left, upper, right and lower side of each."""
    looks = {look.name: look for look in LOOKS}
    found = []
    for name, x, baseline, anchor, text in re.findall(
        r'<text class="(\w+)[^"]*" x="([\d.]+)" y="([\d.]+)"( text-anchor="middle")?>([^<]*)<', picture
    ):
        look = looks[name]
        left = float(x) - (look.width(text) / 2 if anchor else 0.0)
        found.append((text, (left, float(baseline) - 0.7 * look.size, left + look.width(text), float(baseline))))
    return found


def overlap(one: tuple[float, float, float, float], other: tuple[float, float, float, float]) -> bool:
    """Return whether two boxes have anything in common."""
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def defined(file: Path) -> set[str]:
    """Return the names that a file defines, and ``Class.method`` for methods."""
    names: set[str] = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        names |= {target.id for target in targets if isinstance(target, ast.Name)}
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            names |= {f"{node.name}.{inner.name}" for inner in node.body if isinstance(inner, ast.FunctionDef)}
    return names
