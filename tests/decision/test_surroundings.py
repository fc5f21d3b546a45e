"""What is taken for an obstacle from tick to tick, and when a way must be planned anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.core.messages import Percept
from humanoid_bt.decision.robot import Robot
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.decision.surroundings import Surroundings
from tests.decision.watched import watched
from tests.tree.helpers import make_state


@pytest.mark.parametrize(("size", "named"), [([0.4, 0.4, 0.8], ()), (None, ("cart",))], ids=["solid", "named"])
def test_what_has_gone_is_a_change_and_no_obstacle(
    robot: Robot, size: list[float] | None, named: tuple[str, ...]
) -> None:
    around = Surroundings(RobotHandle(robot, "walk", ("base",)), named)
    cart = Percept("cart", 0.0, np.array([1.0, 0.0, -0.4]), 0.9, None if size is None else np.array(size))
    seen = []
    for tick, confidence in enumerate((0.9, 0.08, 0.0, 0.0, 0.9)):
        time = 0.02 * tick
        robot.begin_tick(make_state(time), {"cart": replace(cart, stamp=time, confidence=confidence)})
        seen.append((list(around.look().names), around.changes))
    assert seen == [(["cart"], 1), (["cart"], 1), ([], 2), ([], 2), (["cart"], 3)]


@pytest.mark.parametrize(("above", "stands"), [(0.2, True), (0.3, False)])
def test_what_hangs_well_above_the_eyes_is_no_obstacle(above: float, stands: bool) -> None:
    state = make_state(0.0)
    middle = state.gaze_position[2] - state.base_position[2] + above + 0.1
    lamp = Percept("lamp", 0.0, np.array([1.0, 0.0, middle]), 0.9, np.array([0.4, 0.4, 0.2]))
    assert bool(len(watched(lambda _time: [lamp], until=0.1).obstacles)) == stands


def cart(time: float, *, seen_at: float, confidence: float = 0.9) -> Percept:
    """Return a cart that comes from the left, where it was at a time."""
    place = np.array([2.0, 2.0 - 0.5 * seen_at, -0.4])
    return Percept("cart", time, place, confidence, np.array([0.4, 0.4, 0.8]))


@pytest.mark.parametrize("confidence", [0.08, 0.0, None], ids=["remembered", "gone", "not told any more"])
def test_what_moved_out_of_view_goes_on_for_a_while(confidence: float | None) -> None:
    def seen(time: float) -> list[Percept]:
        if time <= 1.5:
            return [cart(time, seen_at=time)]
        return [] if confidence is None else [cart(time, seen_at=1.5, confidence=confidence)]

    around = watched(seen, until=3.5)
    assert around.moving == [0]
    np.testing.assert_allclose(around.place("cart"), [2.0, 2.0 - 0.5 * 3.5], atol=0.02)
    np.testing.assert_allclose(around.velocities, [[0.0, -0.5]], atol=0.02)
    around = watched(seen, until=4.6)
    assert not around.moving
    if confidence == 0.0:
        assert not len(around.obstacles)
    else:
        np.testing.assert_allclose(around.place("cart"), [2.0, 2.0 - 0.5 * 1.5])


def test_what_stands_still_in_view_does_not_go_on() -> None:
    around = watched(lambda time: [cart(time, seen_at=min(time, 1.5))], until=2.6)
    assert not around.moving
    np.testing.assert_allclose(around.place("cart"), [2.0, 2.0 - 0.5 * 1.5], atol=0.01)


def test_what_is_seen_again_was_as_fast_on_average() -> None:
    def seen(time: float) -> list[Percept]:
        unseen = 1.5 < time < 4.0
        return [cart(time, seen_at=1.5 if unseen else time, confidence=0.08 if unseen else 0.9)]

    np.testing.assert_allclose(watched(seen, until=4.0).velocities, [[0.0, -0.5]], atol=0.02)


def test_noise_of_what_is_seen_does_not_say_that_it_goes_elsewhere() -> None:
    random = np.random.default_rng(5)
    places = [np.array([2.0, 2.0 - 0.5 * max(0.1 * look - 1.0, 0.0), -0.4]) for look in range(40)]
    noisy = [place + 0.015 * random.standard_normal(3) for place in places]

    def seen(time: float) -> list[Percept]:
        return [Percept("cart", time, noisy[round(10 * time)], 0.9, np.array([0.4, 0.4, 0.8]))]

    for until in np.arange(1.8, 3.9, 0.1):
        np.testing.assert_allclose(watched(seen, until).velocities, [[0.0, -0.5]], atol=0.07)


def test_what_was_put_elsewhere_is_not_thought_to_fly_on() -> None:
    def seen(time: float) -> list[Percept]:
        return [cart(time, seen_at=3.0 if time > 1.45 else 0.0)]  # 1.5 m in a moment

    for until in (1.5, 1.9, 2.3):
        around = watched(seen, until)
        assert np.linalg.norm(around.velocities) < 1.6
    np.testing.assert_allclose(around.velocities, [[0.0, 0.0]], atol=0.01)
    np.testing.assert_allclose(around.place("cart"), [2.0, 0.5], atol=0.01)


@pytest.mark.parametrize(("far", "moved"), [(1.0, {"cart"}), (6.0, set())])
def test_what_is_far_is_seen_less_exactly_and_has_not_moved(far: float, moved: set[str]) -> None:
    def seen(now: float) -> list[Percept]:
        return [Percept("cart", now, np.array([far, 0.15 * (now > 1.0), 0.0]), 0.9, np.array([0.4, 0.4, 0.7]))]

    assert watched(seen, 3.0).movers == moved


def test_what_is_told_to_be_gone_again_and_again_has_the_size_that_it_had(robot: Robot, clock: CycleClock) -> None:
    around = Surroundings(RobotHandle(robot, "walk", ("base",)))
    cart = Percept("cart", 0.0, np.array([2.0, -1.0, -0.4]), 0.9, np.array([1.6, 1.6, 0.7]))
    for tick in range(25):
        now = tick / 10
        clock.cycle = 100 * tick
        seen = replace(cart, stamp=now, position=np.array([2.0, -1.0 + 0.5 * min(now, 1.9), -0.4]))
        if tick >= 20:
            seen = replace(seen, confidence=0.0, size=None)
        robot.begin_tick(make_state(now), {"cart": seen})
        around.look()
    assert around.obstacles.halves.tolist() == [[0.8, 0.8]]  # it goes on, as large as it is


@pytest.mark.parametrize(
    ("rests", "until", "speed"),
    [
        pytest.param(0.0, 0.5, 0.5, id="since it was seen first"),
        pytest.param(0.0, 1.0, 0.5, id="since it moved last"),
        pytest.param(5.0, 5.5, 0.25 / 1.5, id="since a second before the last look in which it stood"),
    ],
)
def test_what_is_looked_at_rarely_is_as_fast_as_its_way_since_then(rests: float, until: float, speed: float) -> None:
    def seen(time: float) -> list[Percept]:
        looked = int(2 * time + 0.01) / 2
        return [cart(looked, seen_at=max(looked - rests, 0.0))]

    np.testing.assert_allclose(watched(seen, until).velocities, [[0.0, -speed]], atol=1e-9)
