"""Walking among solid things, in physics, with sensors and odometry as they are: no link touches any."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from humanoid_bt import Rig, TreeRun

WALLED = """
north: {shape: box, size: [1.6, 0.1, 1], solid: true, position: [2.5, 0.75, 0.5]}
south: {shape: box, size: [1.6, 0.1, 1], solid: true, position: [2.5, -0.75, 0.5]}
west: {shape: box, size: [0.1, 1.6, 1], solid: true, position: [1.75, 0, 0.5]}
east: {shape: box, size: [0.1, 1.6, 1], solid: true, position: [3.25, 0, 0.5]}
crate: {shape: box, size: [0.3, 0.3, 0.5], solid: true, position: [0.9, 0.9, 0.25]}
"""
CORRIDOR = """
north: {shape: box, size: [3, 0.1, 1], solid: true, position: [2.3, 0.6, 0.5]}
south: {shape: box, size: [3, 0.1, 1], solid: true, position: [2.3, -0.6, 0.5]}
left: {shape: box, size: [0.1, 1.4, 1], solid: true, position: [0.85, 1.3, 0.5]}
right: {shape: box, size: [0.1, 1.4, 1], solid: true, position: [0.85, -1.3, 0.5]}
west: {shape: box, size: [2, 0.1, 1], solid: true, position: [-0.1, 1.9, 0.5]}
east: {shape: box, size: [2, 0.1, 1], solid: true, position: [-0.1, -1.9, 0.5]}
back: {shape: box, size: [0.1, 4, 1], solid: true, position: [-1, 0, 0.5]}
cart: {shape: box, size: [0.4, 0.4, 0.8], color: red, solid: true, position: [5, 0, 0.4]}
"""
CROSSING = """
cart: {shape: box, size: [0.4, 0.4, 0.8], color: red, solid: true, position: [1.5, 1.6, 0.4]}
"""
TABLE = """
table: {shape: box, size: [0.6, 1.2, 0.7], color: grey, solid: true, position: [1.2, 0.0, 0.35]}
cup: {shape: cylinder, size: [7 cm, 10 cm], color: red, position: [1.4, 0.2, 0.75]}
"""
APPROACH = """
format: 1
name: to_the_cup
root:
  emergency_stop:
    watchdog:
      percept: cup
      max_age: 1 s
      timeout: {duration: 60 s, approach: {target: cup}}
"""
SAFE = ("never: fell", "never: touched")
BACK = """
format: 1
name: back
root:
  emergency_stop:
    step_back: {distance: 40 cm}
"""


def scene(folder: Path, objects: str, more: str = "") -> Path:
    path = folder / "scene.yaml"
    indented = objects.strip().replace("\n", "\n  ")
    path.write_text(f"format: 1\nname: scene\nobjects:\n  {indented}\n{more}\n")
    return path


def tree(folder: Path, text: str) -> Path:
    path = folder / "tree.yaml"
    path.write_text(text)
    return path


def stance(run: TreeRun) -> tuple[float, float]:
    x, y, _ = run.states[-1].stance.tolist()
    return x, y


def test_a_place_behind_walls_has_no_way_and_the_walls_are_named(rig: Rig, tmp_path: Path) -> None:
    run = rig.run_tree("go", scene=scene(tmp_path, WALLED), x=2.5, y=0)
    assert run.failed
    assert run.time < 2
    assert run.reason == "walk_to: no way to (2.5, 0): west, south, north and east are in the way"


def test_nobody_stands_in_a_crate(rig: Rig, tmp_path: Path) -> None:
    run = rig.run_tree("go", scene=scene(tmp_path, WALLED), x=0.9, y=0.8)
    assert run.failed
    assert run.time < 2
    assert run.reason == "walk_to: no way to (0.9, 0.8): crate stands there, or too near to it"


@pytest.mark.trials
def test_goes_round_what_comes_into_its_way(rig: Rig, tmp_path: Path) -> None:
    crosses = "events:\n  - {at: 1 s, move: cart, to: [1.5, 0, 0.4], over: 2 s}"
    run = rig.run_tree("go", scene=scene(tmp_path, CROSSING, crosses), x=2.6, y=0)
    run.expect("outcome == success", *SAFE)
    aside = [abs(float(state.stance[1])) for state in run.states]
    assert max(aside) > 0.4


@pytest.mark.trials
def test_lets_pass_what_walks_into_its_way(rig: Rig, tmp_path: Path) -> None:
    crosses = "events:\n  - {at: 0.6 s, move: cart, to: [1.5, -3, 0.4], over: 9 s}"
    run = rig.run_tree("go", scene=scene(tmp_path, CROSSING, crosses), x=2.6, y=0)
    run.expect("outcome == success", *SAFE)


FROM_THE_SIDE = """
cart: {shape: box, size: [0.4, 0.4, 0.8], color: red, solid: true, position: [2, 2, 0.4]}
"""


@pytest.mark.trials
@pytest.mark.parametrize("begins", [1.0, 1.2])
def test_lets_pass_what_comes_from_the_side_and_leaves_its_view(rig: Rig, tmp_path: Path, begins: float) -> None:
    crosses = f"events:\n  - {{at: {begins} s, move: cart, to: [2, -3.5, 0.4], over: 11 s}}"
    run = rig.run_tree("go", scene=scene(tmp_path, FROM_THE_SIDE, crosses), x=3, y=0)
    run.expect("outcome == success", *SAFE)


@pytest.mark.trials
def test_waits_for_what_has_closed_the_only_way_and_names_it(rig: Rig, tmp_path: Path) -> None:
    comes = "events:\n  - {at: 1 s, move: cart, to: [2.2, 0, 0.4], over: 3 s}"
    run = rig.run_tree("go", scene=scene(tmp_path, CORRIDOR, comes), x=4.5, y=0)
    assert run.failed
    assert run.reason == "walk_to: no way to (4.5, 0): cart is in the way"
    assert 5 < run.time < 25
    run.expect(*SAFE)


@pytest.mark.trials
@pytest.mark.parametrize("to", ["[4.0, 1.2, 0.4]", "[4.5, 2.5, 0.4]"], ids=["in sight", "out of sight"])
def test_goes_on_when_the_way_is_free_again(rig: Rig, tmp_path: Path, to: str) -> None:
    leaves = f"\n  - {{at: 6 s, move: cart, to: {to}, over: 3 s}}"
    comes = "events:\n  - {at: 1 s, move: cart, to: [2.2, 0, 0.4], over: 3 s}" + leaves
    run = rig.run_tree("go", scene=scene(tmp_path, CORRIDOR, comes), x=4.5, y=0)
    run.expect("outcome == success", *SAFE)


@pytest.mark.trials
def test_approaches_from_the_side_of_a_table_on_which_the_cup_is(rig: Rig, tmp_path: Path) -> None:
    cup = "percepts: {cup: {object: cup}}"
    run = rig.run_tree(tree(tmp_path, APPROACH), scene=scene(tmp_path, TABLE, cup))
    run.expect("outcome == success", *SAFE)
    x, y = stance(run)
    assert math.dist((x, y), (1.4, 0.2)) < 0.65
    assert x > 1.5 or abs(y) > 0.9  # not across the whole table


def test_what_a_link_bumps_into_is_told(rig: Rig, tmp_path: Path) -> None:
    behind = "wall: {shape: box, size: [0.1, 2, 1], solid: true, position: [-0.45, 0, 0.5]}"
    run = rig.run_tree(tree(tmp_path, BACK), scene=scene(tmp_path, behind), duration=3)
    assert run.samples[-1].touched == run.samples[-1].bumped == ("wall",)
    assert run.report.bumps
    assert "bumped" in repr(run.report)
    with pytest.raises(AssertionError, match="touched"):
        run.expect("never: touched")
    run.expect("contains(touched_objects, 'wall')")


BEHIND = """
wall: {shape: box, size: [0.1, 2, 1], solid: true, position: [1.2, 0, 0.5]}
"""
ROUND_AND_BACK = """
format: 1
name: round_and_back
parameters: {distance: 0.6}
root:
  emergency_stop:
    sequence:
      - turn: {angle: 180 deg}
      - step_back: {distance: $distance}
"""
BESIDE = """
post: {shape: box, size: [0.1, 0.1, 1.4], solid: true, position: [0.3, 0.25, 0.7]}
"""
TURN = """
format: 1
name: turn
root:
  emergency_stop:
    turn: {angle: -90 deg}
"""


def test_does_not_turn_against_what_stands_beside_it_and_names_it(rig: Rig, tmp_path: Path) -> None:
    run = rig.run_tree(tree(tmp_path, TURN), scene=scene(tmp_path, BESIDE))
    assert run.failed
    assert run.reason == "turn: no room to turn: post would be knocked against"
    assert run.time < 1
    run.expect(*SAFE)


@pytest.mark.parametrize(
    ("distance", "outcome"), [pytest.param(0.6, "success", marks=pytest.mark.trials), (0.9, "failure")]
)
def test_remembers_the_wall_behind_it_when_it_steps_back(
    rig: Rig, tmp_path: Path, distance: float, outcome: str
) -> None:
    run = rig.run_tree(tree(tmp_path, ROUND_AND_BACK), scene=scene(tmp_path, BEHIND), distance=distance)
    run.expect(f"outcome == {outcome}", *SAFE)
    if outcome == "failure":
        assert run.reason == "step_back: no room to step back 0.90 m: wall would be stepped into"
