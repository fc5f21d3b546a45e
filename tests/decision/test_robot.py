"""The robot as decision sees it: what a tick sees of percepts, and what leaves at its end."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.core.errors import HumanoidBtError, ResourceConflict
from humanoid_bt.core.messages import RESOURCES, SIGHT, Percept, State
from humanoid_bt.decision.robot import Robot
from humanoid_bt.decision.robot_handle import RobotHandle
from tests.tree.helpers import make_robot, make_state, seen


def standing(x: float, y: float, yaw: float, time: float = 0.0) -> State:
    turn = np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])
    base = np.array([x, y, 0.8])
    return dataclasses.replace(make_state(time), base_position=base, base_quaternion=turn, stance=np.array([x, y, yaw]))


def test_a_track_is_of_the_start_of_the_tick_however_late_it_is_read(robot: Robot, clock: CycleClock) -> None:
    clock.cycle = 300
    robot.begin_tick(make_state(0.3), seen(0.1, distance=1.0))
    clock.cycle = 340
    track = robot.track("target")
    assert track is not None and track.age == pytest.approx(0.2)
    assert robot.track("target") is track and robot.tracks == {"target": track}
    robot.begin_tick(standing(0.5, 0.0, 0.0, time=0.34), {})
    assert (track.age, track.distance) == pytest.approx((0.2, 1.0))
    later = robot.track("target")
    assert later is not None and (later.age, later.distance) == pytest.approx((0.24, 0.5))


@pytest.mark.parametrize("name", ["age", "position_world", "heading_world", "confidence"])
def test_no_node_changes_a_track_for_others(robot: Robot, name: str) -> None:
    robot.begin_tick(make_state(0.3), seen(0.1, distance=1.0))
    with pytest.raises(AttributeError):
        setattr(robot.track("target"), name, 1.0)


def test_a_track_says_where_the_thing_is(robot: Robot) -> None:
    state = standing(1.0, 2.0, math.pi / 2)
    robot.begin_tick(state, {"ball": Percept("ball", 0.0, np.array([2.0, 2.0, -0.3]), 0.7)})
    track = robot.track("ball")
    assert track is not None
    np.testing.assert_allclose(track.position_world, [-1.0, 4.0, 0.5], atol=1e-12)
    np.testing.assert_allclose(track.position_base, [2.0, 2.0, -0.3], atol=1e-12)
    assert (track.distance, track.bearing) == pytest.approx((math.sqrt(8), math.pi / 4))
    assert (track.name, track.stamp, track.confidence) == ("ball", 0.0, 0.7)


def test_a_box_points_within_half_a_turn(robot: Robot) -> None:
    turned = dataclasses.replace(make_state(), base_quaternion=np.array([math.cos(1.5), 0.0, 0.0, math.sin(1.5)]))
    robot.begin_tick(turned, {"box": Percept("box", 0.0, np.ones(3), 0.9, np.ones(3), heading=1.0)})
    box = robot.track("box")
    assert box is not None
    assert box.heading_world == pytest.approx(4.0 - math.tau)


@pytest.mark.parametrize("late", [0.059, 1.9, 8.0])
def test_a_late_percept_is_placed_from_where_the_robot_stood_when_it_was_seen(robot: Robot, late: float) -> None:
    for step in range(500):
        robot.begin_tick(standing(0.01 * step, 0.0, 0.0, time=0.02 * step), {})
    robot.begin_tick(standing(5.0, 0.0, 0.0, time=10.0), seen(10.0 - late, distance=1.0))
    track = robot.track("target")
    assert track is not None
    np.testing.assert_allclose(track.position_world, [1.0 + 0.5 * (10.0 - late), 0.0, 0.8], atol=0.005)


def test_that_a_thing_is_gone_may_be_told_with_the_time_at_which_it_was_seen_last(robot: Robot) -> None:
    cup = Percept("cup", 0.2, np.array([1.0, 0.0, 0.0]), 0.9)
    for confidence in (0.9, 0.0, 0.9):
        robot.begin_tick(make_state(0.3), {"cup": dataclasses.replace(cup, confidence=confidence)})
    track = robot.track("cup")
    assert track is not None and track.gone


def test_an_older_percept_does_not_replace_a_newer_one(robot: Robot) -> None:
    robot.begin_tick(make_state(0.2), seen(0.2, distance=1.0))
    robot.begin_tick(make_state(0.3), seen(0.1, distance=3.0))
    track = robot.track("target")
    assert track is not None and track.stamp == 0.2
    assert robot.track("nothing") is None


def test_the_view_of_the_next_tree_goes_on_where_that_of_the_last_one_ends(robot: Robot, clock: CycleClock) -> None:
    robot.begin_tick(standing(1.0, 0.0, 0.0), {})
    robot.commit()
    clock.cycle = 500
    robot.stand_still(standing(3.0, 0.0, 0.0, time=0.5), {})
    after = make_robot(clock)
    after.take_over(robot)
    assert after.clock.now() == robot.clock.now() == 0.0
    after.begin_tick(standing(3.0, 0.0, 0.0, time=0.6), seen(0.0, distance=1.0))
    track = after.track("target")
    assert track is not None and track.position_world[0] == pytest.approx(2.0)  # seen before, and from there
    assert after.commit().sequence == 1


def test_a_target_holds_for_one_tick(robot: Robot) -> None:
    handle = RobotHandle(robot, "t/idle", ("gaze", "posture"))
    robot.begin_tick(make_state(), {})
    handle.look_at([1, 0, 1])
    handle.set_height(0.01)
    assert dict(robot.commit().sources) == {"gaze": "t/idle", "posture": "t/idle"}
    robot.begin_tick(make_state(0.02), {})
    assert robot.commit().targets == {}


def test_what_was_released_can_be_taken_again_in_the_same_tick(robot: Robot) -> None:
    first, second = RobotHandle(robot, "t/first", ("gaze",)), RobotHandle(robot, "t/second", ("gaze",))
    robot.begin_tick(make_state(), {})
    first.look_at([1, 0, 1])
    first.release()
    second.look_at([2, 0, 1])
    second.release()
    first.look_at([3, 0, 1])
    command = robot.commit()
    assert dict(command.sources) == {"gaze": "t/first"}
    second.look_at([4, 0, 1])
    with pytest.raises(ResourceConflict, match=r"'gaze' .* 't/first' and 't/second'"):
        robot.commit()
    assert robot.release_all().targets == {}


@pytest.mark.parametrize("point", [[1, 2], [1, 2, math.nan], [1, math.inf, 0], [math.inf, -math.inf, 0]])
def test_a_target_must_have_its_shape_and_be_finite(robot: Robot, point: list[float]) -> None:
    robot.begin_tick(make_state(), {})
    with pytest.raises(ValueError, match=r"must have shape \(3,\)|must be finite"):
        RobotHandle(robot, "t/look", ("gaze",)).look_at(point)


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda handle: handle.set_height(-1), "a target's height must be from -0.5 to 0.5 m, not -1"),
        (lambda handle: handle.look_at((1e300, 0, 0)), "a target's position must be within 2000 m of the origin"),
        (lambda handle: handle.walk_to((0, -2001), 0.0), "a target's position must be within 2000 m of the origin"),
        (lambda handle: handle.walk_to((0, 0), math.inf), "a target's heading must be finite, not inf"),
        (lambda handle: handle.walk_to((0, 0), "north"), r"a target's heading must be a number \[rad\], not 'north'"),
        (lambda handle: handle.walk_to((1, 2, 3), 0.0), r"a target's position must have shape \(2,\), not \(3,\)"),
        (lambda handle: handle.walk_to(None, 0.0), r"a target's position must be numbers, shape \(2,\), not None"),
        (lambda handle: handle.look_at(("a", 1, 2)), r"position must be numbers, shape \(3,\), not \('a', 1, 2\)"),
        (lambda handle: handle.show_route("home"), r"the points of a way must be numbers, shape \(n, 2\), not 'home'"),
        (lambda handle: handle.set_height(None), r"a target's height must be a number \[m\], not None"),
        (lambda handle: handle.move_arm("left", (0.1, 0.2)), r"must be angles \[rad\] by name, not \(0.1, 0.2\)"),
        (
            lambda handle: handle.move_arm("left", {"left_elbow": None}),
            r"angle of 'left_elbow' must be a number \[rad\]",
        ),
        (lambda handle: handle.nearest_hand("left"), r"a bearing must be a number \[rad\], not 'left'"),
        (lambda handle: handle.why_no_nearer("left", None), r"a distance must be a number \[m\], not None"),
        (lambda handle: handle.move_hand("left", (0, 0, 1e4)), "must be within 2000 m of the origin"),
        (lambda handle: handle.move_hand("left", (0, 0, 1), press=60), "press must be from 0 to 50 N, not 60"),
        (lambda handle: handle.move_hand("left", (0, 0, 1), press=-1), "press must be from 0 to 50 N, not -1"),
    ],
)
def test_what_control_would_refuse_is_refused_where_it_is_asked_for(
    robot: Robot, ask: Callable[[RobotHandle], None], said: str
) -> None:
    robot.begin_tick(make_state(), {})
    handle = RobotHandle(robot, "t/all", RESOURCES)
    with pytest.raises(ValueError, match=said):
        ask(handle)
    assert not robot.commit().targets


def test_an_emergency_stop_is_raised_whatever_its_reason_is(clock: CycleClock) -> None:
    raised: list[tuple[str, str]] = []
    robot = Robot(make_robot(clock).config, clock, lambda source, reason: raised.append((source, reason)))
    RobotHandle(robot, "t/careful", ()).raise_estop(ValueError("too hot"))  # type: ignore[arg-type]  # as a skill does
    assert raised == [("t/careful", "too hot")]


def test_what_can_be_seen_can_be_looked_at_from_wherever_the_robot_stands(robot: Robot) -> None:
    robot.begin_tick(standing(900.0, 0.0, 0.0), {"ball": Percept("ball", 0.0, np.array([SIGHT, 0.0, 0.0]), 0.5)})
    track = robot.track("ball")
    assert track is not None
    RobotHandle(robot, "t/look", ("gaze",)).look_at(track.position_world)
    assert robot.commit().targets


def test_a_hand_that_the_robot_lacks_is_not_commanded(clock: CycleClock) -> None:
    handle = RobotHandle(make_robot(clock, hands=["left"]), "t/all", RESOURCES)
    with pytest.raises(HumanoidBtError, match="'right_hand': the robot has none, only base, left_hand, gaze and post"):
        handle.move_hand("right", (0, 0, 1))
    assert not handle.targets


@pytest.mark.parametrize("turns", [-1, 1, 200])
def test_a_heading_is_the_same_after_full_turns(robot: Robot, turns: int) -> None:
    robot.begin_tick(make_state(), {})
    RobotHandle(robot, "t/walk", ("base",)).walk_to((0, 0), 0.5 + turns * math.tau)
    assert robot.commit().targets["base"].heading == pytest.approx(0.5)


def test_there_is_no_state_before_the_first_tick(robot: Robot) -> None:
    with pytest.raises(HumanoidBtError, match="before the first tick"):
        _ = robot.state


def test_what_has_a_size_is_an_obstacle_that_stays_turned_as_it_was_seen(robot: Robot) -> None:
    size = np.array([0.6, 0.4, 0.7])
    table = Percept("table", 0.0, np.array([1.0, 0.0, -0.3]), 0.9, size, 0.2)
    ball = Percept("ball", 0.0, np.array([2.0, 0.0, 0.1]), 0.9)
    robot.begin_tick(standing(0.0, 0.0, math.pi / 2), {"table": table, "ball": ball})
    robot.begin_tick(standing(0.0, 0.0, 0.0, time=0.02), {})
    (obstacle,) = robot.obstacles
    assert obstacle.name == "table"
    assert obstacle.size is size
    assert obstacle.heading_world == pytest.approx(math.pi / 2 + 0.2)


def test_what_is_known_to_be_gone_is_no_obstacle_until_it_is_seen_again(robot: Robot) -> None:
    cart = Percept("cart", 0.0, np.array([1.0, 0.0, -0.3]), 0.08, np.array([0.4, 0.4, 0.8]))
    robot.begin_tick(standing(0.0, 0.0, 0.0), {"cart": cart})
    assert [track.name for track in robot.obstacles] == ["cart"]
    robot.begin_tick(
        standing(0.0, 0.0, 0.0, time=0.02), {"cart": dataclasses.replace(cart, stamp=0.02, confidence=0.0)}
    )
    track = robot.track("cart")
    assert track is not None and track.gone
    assert robot.obstacles == []
    robot.begin_tick(standing(0.0, 0.0, 0.0, time=0.04), {"cart": dataclasses.replace(cart, stamp=0.04)})
    assert [track.name for track in robot.obstacles] == ["cart"]


def test_what_is_solid_stays_so_where_a_percept_has_no_size_until_it_is_gone(robot: Robot) -> None:
    cart = Percept("cart", 0.0, np.array([1.0, 0.0, -0.3]), 0.9, np.array([0.4, 0.6, 0.8]), 0.2)
    robot.begin_tick(standing(0.0, 0.0, math.pi / 2), {"cart": cart})
    bare = dataclasses.replace(cart, stamp=0.02, position=np.array([1.5, 0.0, -0.3]), size=None, heading=0.0)
    robot.begin_tick(standing(0.0, 0.0, 0.0, time=0.02), {"cart": bare})
    (obstacle,) = robot.obstacles
    assert obstacle.size is cart.size
    assert obstacle.heading_world == pytest.approx(math.pi / 2 + 0.2)
    assert obstacle.position_world[0] == pytest.approx(1.5)
    for stamp, confidence in ((0.04, 0.0), (0.06, 0.9)):
        again = dataclasses.replace(bare, stamp=stamp, confidence=confidence)
        robot.begin_tick(standing(0.0, 0.0, 0.0, time=stamp), {"cart": again})
        assert robot.obstacles == []


def test_a_way_is_shown_as_long_as_its_node_commands(robot: Robot) -> None:
    robot.begin_tick(standing(0.0, 0.0, 0.0), {})
    handle = RobotHandle(robot, "walk", ("base",))
    handle.walk_to([1.0, 0.0], 0.0)
    handle.show_route([[0.0, 0.0], [1.0, 0.0]])
    assert [route.tolist() for route in robot.routes] == [[[0.0, 0.0], [1.0, 0.0]]]
    handle.show_route([])
    assert robot.routes == []
    handle.show_route([[0.0, 0.0]])
    robot.begin_tick(standing(0.0, 0.0, 0.0, time=0.02), {})
    assert robot.routes == []


def test_a_way_that_is_not_shown_again_is_none(robot: Robot) -> None:
    handle = RobotHandle(robot, "walk", ("base",))
    robot.begin_tick(make_state(), {})
    handle.walk_to([1.0, 0.0], 0.0)
    handle.show_route([[0.0, 0.0], [1.0, 0.0]])
    assert len(robot.routes) == 1
    robot.begin_tick(make_state(0.02), {})
    handle.walk_to([1.0, 0.0], 0.0)
    assert robot.routes == []


@pytest.mark.parametrize(
    ("points", "why"),
    [
        ([1, 2], r"must have shape \(n, 2\), not \(2,\)"),
        ([[0, 0, 0], [1, 1, 0]], r"must have shape \(n, 2\), not \(2, 3\)"),
        ([[0, 0], [math.nan, 1]], "must be within 2000 m of the origin, not .*nan"),
        ([[0, 0], [2001, 1]], "must be within 2000 m of the origin, not .*2001"),
    ],
)
def test_what_is_no_way_is_refused(robot: Robot, points: list[object], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        RobotHandle(robot, "walk", ("base",)).show_route(points)
