"""Declared results of skills: what they hold, when they are forgotten, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.decision.result import Reported, declared_results, reported, result
from humanoid_bt.decision.skill import Skill, Status
from humanoid_bt.decision.skill_files import load_skills
from humanoid_bt.files.workspace import Workspace


class Measure(Skill):
    """Measure things."""

    width: float = result(unit="m", doc="How wide.")
    count: int = result(doc="How many.")
    done: bool = result(doc="Whether all were measured.")
    color: str = result(doc="What colour.")

    def update(self) -> Status:
        return Status.SUCCESS


def test_what_is_not_set_is_no_result() -> None:
    skill = Measure()
    assert skill.results == {}
    with pytest.raises(AttributeError, match="the result 'width' is not set yet"):
        _ = skill.width
    skill.width = 0.25
    assert skill.width == 0.25
    assert skill.results == {"width": 0.25}
    del skill.width
    assert skill.results == {}


def test_each_instance_has_its_own() -> None:
    one, other = Measure(), Measure()
    one.count = 3
    assert other.results == {}
    assert reported(one) == (Reported("count", 3, ""),)


def test_a_skill_that_starts_anew_has_forgotten_them() -> None:
    skill = Measure()
    skill.width = 0.25
    skill.initialise()
    assert skill.results == {}


@pytest.mark.parametrize(
    ("name", "value", "held"),
    [
        ("width", np.float32(0.5), 0.5),
        ("width", 2, 2.0),
        ("width", np.int64(2), 2.0),
        ("count", np.int64(2), 2),
        ("done", np.bool_(True), True),
        ("color", "red", "red"),
    ],
)
def test_numbers_of_any_kind_become_plain_ones(name: str, value: Any, held: Any) -> None:
    skill = Measure()
    setattr(skill, name, value)
    assert (type(skill.results[name]), skill.results[name]) == (type(held), held)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("width", "wide", "the result 'width' must be a number, not 'wide'"),
        ("width", True, "the result 'width' must be a number, not True"),
        ("width", None, "the result 'width' must be a number, not None"),
        ("width", np.zeros(3), "the result 'width' must be a number"),
        ("width", float("nan"), "the result 'width' must be finite, not nan"),
        ("width", np.inf, "the result 'width' must be finite, not inf"),
        ("count", 10**400, "the result 'count' must be finite, not 1000"),
        ("count", 1.5, "the result 'count' must be a whole number, not 1.5"),
        ("done", 1, "the result 'done' must be true or false, not 1"),
        ("color", 3, "the result 'color' must be text, not 3"),
    ],
)
def test_a_value_of_another_type_is_refused(name: str, value: Any, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        setattr(Measure(), name, value)


def test_results_are_inherited() -> None:
    class Weigh(Measure):
        """Weigh things, too."""

        mass: float = result(unit="kg", doc="How heavy.")

    assert [*declared_results(Weigh)] == ["width", "count", "done", "color", "mass"]
    assert declared_results(Weigh)["mass"].type_name == "number [kg]"


HEAD = "from humanoid_bt import Skill, Status, param, result\n\n\nclass Weigh(Skill):\n    '''Weigh.'''\n\n"
UPDATE = "\n    def update(self):\n        return Status.SUCCESS\n"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("mass: float = result(unit='g', doc='')", "weigh.py:8:19: .*a result is in SI units: unit='kg', not 'g'"),
        ("mass = result(doc='')", ":5:1: error: in 'weigh': the result 'mass' is not annotated; valid: float, int"),
        ("mass: list[float] = result(doc='')", ":5:1: error: in 'weigh': the result 'mass' cannot be list of numbers"),
        ("mass: flaot = result(doc='')", ":5:1: error: in 'weigh': name 'flaot' is not defined"),
        ("status: str = result(doc='')", ":5:1: error: 'weigh' declares the result 'status', which every node has"),
    ],
)
def test_a_declaration_with_a_mistake_is_answered_with_its_place(tmp_path: Path, lines: str, message: str) -> None:
    (tmp_path / "skills").mkdir()
    future = "from __future__ import annotations\n"
    (tmp_path / "skills" / "weigh.py").write_text(future + HEAD + f"    {lines}\n" + UPDATE, encoding="utf-8")
    with pytest.raises(UserError, match=message):
        load_skills(Workspace(tmp_path))
