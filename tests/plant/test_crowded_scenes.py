"""Scenes with more than physics copes with: refused, or told; nothing is left in the working directory."""

from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.plant.scene_config import MAX_THINGS, load_scene
from humanoid_bt.session.session import Session

BALL = "{{shape: ball, size: [2 m], position: [{}, 0, 0.9], solid: true}}"


def scene(folder: Path, names: list[str], percepts: int = 0) -> Path:
    """Write a scene with solid balls around the robot."""
    balls = "".join(f"  {name}: {BALL.format(number * 1e-3)}\n" for number, name in enumerate(names))
    seen = "percepts:\n" + "".join(f"  p{number}: {{object: {names[0]}}}\n" for number in range(percepts))
    file = folder / "crowd.yaml"
    file.write_text(f"format: 1\nname: crowd\nobjects:\n{balls}{seen if percepts else ''}", encoding="utf-8")
    return file


@pytest.mark.parametrize(("objects", "percepts"), [(MAX_THINGS + 1, 0), (1, MAX_THINGS + 1)])
def test_a_scene_with_too_much_in_it_is_refused(objects: int, percepts: int, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"this scene has 1,001 (objects|percepts), and simulation copes with 1,000"):
        load_scene(scene(tmp_path, [f"o{number}" for number in range(objects)], percepts))


@pytest.mark.parametrize("name", [r'"a\0b"', r'"\x1b[2J"', "' '", "x" * 201])
def test_what_cannot_be_a_name_is_told(name: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be a name") as caught:
        load_scene(scene(tmp_path, [name]))
    (problem,) = caught.value.problems
    assert (problem.code, problem.place and problem.place.line) == ("bad-name", 4)


@pytest.mark.trials
def test_what_mujoco_warns_of_is_an_event_and_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    file = scene(tmp_path, [f"o{number}" for number in range(500)])
    report = Session("stand", scene=file, duration=0.02).run()
    warnings = [event["text"] for event in report.events if event["text"].startswith("MuJoCo: ")]
    assert any("arena memory" in text for text in warnings), report.events
    assert [path.name for path in tmp_path.iterdir()] == ["crowd.yaml"]


def test_a_scene_in_which_physics_gives_up_is_told(tmp_path: Path) -> None:
    with pytest.raises(
        UserError, match="the simulated physics gave up, most likely because too many solid things touch"
    ):
        Session("stand", scene=scene(tmp_path, [f"o{number}" for number in range(300)]))


def test_physics_that_gives_up_later_ends_the_run_with_one_message(tmp_path: Path) -> None:
    names = [f"o{number}" for number in range(300)]
    file = scene(tmp_path, names)
    text = file.read_text(encoding="utf-8").replace(", 0, 0.9]", ", 50, 0.9]")  # far away, but not for long
    moves = "".join(
        f"  - {{at: 0.02, move: {name}, to: [{number * 1e-3}, 0, 0.9]}}\n" for number, name in enumerate(names)
    )
    file.write_text(f"{text}events:\n{moves}", encoding="utf-8")
    report = Session("stand", scene=file, duration=0.1).run()
    assert report.outcome == "error"
    assert report.reason.startswith("the simulated physics gave up, most likely because too many solid things touch")
    assert not report.traceback
