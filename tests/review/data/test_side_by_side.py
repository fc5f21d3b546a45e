"""Two recordings in one: all of both is there, by other names, and one is told from the other by its colour."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.record.rrd import RrdFile
from humanoid_bt.record.side_by_side import write_side_by_side

Cells = dict[tuple[str, str], list[Any]]

COLORS = ("colors", "vertex_colors", "albedo_factor")


def cells(file: Path) -> Cells:
    """Return what a recording shows, by entity and column."""
    found: Cells = {}
    for entity, batch in RrdFile(file).batches_of(lambda entity: True):
        for name in batch.schema.names:
            if name.partition(":")[2]:
                found.setdefault((entity, name), []).extend(batch.column(name).to_pylist())
    return found


@pytest.fixture(scope="module")
def source(file: Path) -> Cells:
    return cells(file)


@pytest.fixture(scope="module")
def both(file: Path, tmp_path_factory: pytest.TempPathFactory) -> Cells:
    path = tmp_path_factory.mktemp("shown") / "both.rrd"
    write_side_by_side(path, ([file], [file]))
    return cells(path)


def shown(both: Cells, name: str) -> Cells:
    return {(entity[2:], column): rows for (entity, column), rows in both.items() if entity.startswith(f"/{name}/")}


def test_all_is_shown_twice_but_what_stands_around(both: Cells, source: Cells) -> None:
    first, second = shown(both, "A"), shown(both, "B")
    assert {entity.split("/")[1] for entity, _ in first} == {
        *("actions", "body", "conditions", "eye", "events", "flow", "joints", "percepts", "poses", "robot", "world")
    }
    assert {entity for entity, _ in first.keys() - second.keys()} == {
        entity for entity, _ in source if entity.startswith("/world/scene/")
    }
    assert second.keys() < first.keys() <= source.keys()


def test_frames_of_the_second_have_names_of_their_own_in_the_same_world(both: Cells, source: Cells) -> None:
    first, second = shown(both, "A"), shown(both, "B")
    frames = [key for key in second if key[1].endswith("frame")]
    assert ("/poses", "Transform3D:parent_frame") in frames and ("/world/path", "CoordinateFrame:frame") in frames
    for key in frames:
        assert first[key] == source[key]
        assert second[key] == [
            row and ["world" if frame == "world" else f"B {frame}" for frame in row] for row in source[key]
        ]


def test_every_curve_says_whose_it_is(both: Cells, source: Cells) -> None:
    key = "/robot/foot_force", "SeriesLines:names"
    for name in "AB":
        assert shown(both, name)[key] == [row and [f"{name} {curve}" for curve in row] for row in source[key]]


def test_the_second_is_tinted_but_not_what_its_colours_say(both: Cells, source: Cells) -> None:
    for name in "AB":
        for key, rows in shown(both, name).items():
            if key[1].partition(":")[2] not in COLORS:
                continue
            meant = name == "B" and not key[1].startswith("StateConfiguration")
            assert rows == ([row and list(map(tinted, row)) for row in source[key]] if meant else source[key]), key


def tinted(color: int) -> int:
    red, green, blue, alpha = color.to_bytes(4, "big")
    mixed = (int(0.4 * part + 0.6 * 255 * tint) for part, tint in ((red, 0.85), (green, 0.2), (blue, 0.75)))
    return int.from_bytes([*mixed, alpha], "big")


def test_a_file_that_cannot_be_written_is_told(file: Path, tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file"):
        write_side_by_side(tmp_path / "none" / "both.rrd", ([file], [file]))
