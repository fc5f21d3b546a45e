"""Values written into fields of messages of ROS 2, and read from them, without it."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import pytest

from humanoid_bt.gateway.fields import FieldMistake, fill, type_at, value_of
from humanoid_bt.gateway.types import interface


class Point:
    TYPES: ClassVar = {"x": "double", "y": "float"}

    def __init__(self) -> None:
        self.x = self.y = 0.0

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        return cls.TYPES


class Lift(Point):
    TYPES: ClassVar = {
        "up": "boolean",
        "floor": "int8",
        "place": "some_msgs/Point",
        "words": "sequence<string<4>, 2>",
        "box": "double[2]",
        "raw": "octet",
        "note": "string",
    }

    def __init__(self) -> None:
        self.up, self.floor, self.place, self.note = False, 0, Point(), ""
        self.words, self.raw = list[str](), b"\0"
        self.box: Sequence[float] | np.ndarray[Any, Any] = [0.0, 0.0]


def test_values_are_written_as_the_fields_hold_them() -> None:
    fields = {"up": True, "floor": 2.0, "place": {"x": 1}, "words": ["a", "b"], "box": [1, 2.5], "raw": 3, "note": "x"}
    lift = fill(Lift(), fields)
    assert (lift.up, lift.floor, lift.place.x, lift.words, lift.box, lift.raw) == (
        True,
        2,
        1.0,
        ["a", "b"],
        [1, 2.5],
        b"\3",
    )
    assert (type(lift.floor), type(lift.place.x), type(lift.box[0])) == (int, float, float)
    read = [value_of(lift, path) for path in ("up", "floor", "place.x", "words.1", "box", "raw")]
    assert read == [True, 2, 1.0, "b", [1.0, 2.5], 3]


@pytest.mark.parametrize(
    ("values", "path", "message", "hint"),
    [
        ({"flor": 1}, "flor", "there is no field 'flor'", "did you mean 'floor'?"),
        ({"place": {"z": 1}}, "place.z", "there is no field 'place.z'", "valid: x, y"),
        ({"place": 1}, "place", "'place' cannot be a number: it is of type some_msgs/Point", "a mapping of its fields"),
        ({"up": 1}, "up", "'up' cannot be a number: it is of type boolean", ""),
        ({"floor": 1.5}, "floor", "'floor' cannot be a number: it is of type int8", ""),
        ({"floor": 200}, "floor", "'floor' cannot be 200: it is of type int8", ""),
        ({"floor": True}, "floor", "'floor' cannot be true or false: it is of type int8", ""),
        ({"box": ["1 m", 2]}, "box.0", "'box.0' cannot be text '1 m': it is of type double", 'an expression: "{1 m}"'),
        ({"box": [1]}, "box", "'box' cannot have 1 values: it is of type double[2]", ""),
        ({"words": ["a", "b", "c"]}, "words", "'words' cannot have 3 values", ""),
        ({"words": ["longer"]}, "words.0", "'words.0' cannot be text 'longer': it is of type string<4>", ""),
        ({"note": 3}, "note", "'note' cannot be a number: it is of type string", ""),
        ({"floor": 10**400}, "floor", "'floor' cannot be 10000", ""),
        ({"place": {"x": -(10**400)}}, "place.x", "'place.x' cannot be -10000", ""),
        ({"place": {"y": 1e39}}, "place.y", "'place.y' cannot be 1e+39: it is of type float", ""),
        ({"raw": 300}, "raw", "'raw' cannot be 300: it is of type octet", ""),
    ],
)
def test_what_a_field_does_not_hold_is_refused(values: dict[str, Any], path: str, message: str, hint: str) -> None:
    with pytest.raises(FieldMistake) as told:
        fill(Lift(), values)
    assert told.value.path == path
    assert message in told.value.message
    assert hint in told.value.hint


def test_infinity_and_nan_are_numbers() -> None:
    point = fill(Point(), {"x": math.inf, "y": -math.inf})
    assert (point.x, point.y) == (math.inf, -math.inf)
    assert math.isnan(fill(Point(), {"y": math.nan}).y)


@pytest.mark.parametrize("kind", [np.uint8, np.int64, np.float32, np.float64])
def test_arrays_are_read_as_plain_data(kind: type[np.generic]) -> None:
    lift = Lift()
    lift.box = np.array([1, 2], dtype=kind)
    assert json.dumps([value_of(lift, "box"), value_of(lift, "box.1")]) in ("[[1, 2], 2]", "[[1.0, 2.0], 2.0]")


def test_what_is_not_known_yet_is_left_out_and_its_field_must_be_there() -> None:
    assert fill(Lift(), {"floor": None, "box": [None, 1]}).floor == 0
    with pytest.raises(FieldMistake, match="no field 'flor'"):
        fill(Lift(), {"flor": None})


def test_types_are_found_by_paths() -> None:
    assert [type_at(Lift, path) for path in ("up", "words", "words.0", "box.1")] == [
        "boolean",
        "sequence<string<4>, 2>",
        "string<4>",
        "double",
    ]
    for path in ("down", "up.x", "words.0.x"):
        with pytest.raises(FieldMistake, match="there is no field"):
            type_at(Lift, path)
    with pytest.raises(FieldMistake, match=r"there is nothing at 'box\.7'"):
        value_of(Lift(), "box.7")


@pytest.mark.ros
def test_fields_of_real_messages() -> None:
    assert value_of(interface("unique_identifier_msgs/UUID")(), "uuid") == [0] * 16
    with pytest.raises(FieldMistake, match=r"list of messages, .*points\.0\.x, points\.0\.y"):
        type_at(interface("geometry_msgs/Polygon"), "points")
