"""Ways between obstacles: free, and the shortest."""

import itertools

import numpy as np
import pytest

from humanoid_bt.core.messages import Array
from humanoid_bt.decision.obstacles import Obstacles, clear
from humanoid_bt.decision.route_planner import plan

ROOM = 0.4
START, GOAL = np.array([0.0, 0.0]), np.array([4.0, 0.0])


def boxes(*places: tuple[float, float], half: float = 0.2, heading: float = 0.0) -> Obstacles:
    count = len(places)
    names = [f"box_{i}" for i in range(count)]
    return Obstacles(names, np.array(places).reshape(-1, 2), np.full((count, 2), half), np.full(count, heading))


def random_boxes(numbers: np.random.Generator, count: int) -> Obstacles:
    names = [f"box_{i}" for i in range(count)]
    middles, halves = numbers.uniform([1, -1.5], [3, 1.5], (count, 2)), numbers.uniform(0.1, 0.3, (count, 2))
    return Obstacles(names, middles, halves, numbers.uniform(-3, 3, count))


def nearest_distance(obstacles: Obstacles, points: Array) -> float:
    """How near a way comes to any obstacle, from places a centimetre apart."""
    shares = np.linspace(0, 1, 400)[:, None]
    sides = itertools.pairwise(points)
    places = np.concatenate([one + shares * (other - one) for one, other in sides])
    return float(obstacles.distances(places).min())


def length(points: Array) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def test_distance_from_a_turned_rectangle() -> None:
    one = Obstacles(["table"], np.array([[1.0, 0.0]]), np.array([[0.5, 0.1]]), np.array([np.pi / 2]))
    points = np.array([[0.5, 0.0], [1.0, 1.0], [1.0, 0.0]])
    assert one.distances(points)[:, 0] == pytest.approx([0.4, 0.5, -0.1])


def test_clear_agrees_with_looking_at_every_place() -> None:
    numbers = np.random.default_rng(1)
    obstacles = random_boxes(numbers, 3)
    starts, ends = numbers.uniform(-1, 5, (2, 500, 2))
    shares = np.linspace(0, 1, 400)
    looked = np.stack([obstacles.distances(starts + share * (ends - starts)) for share in shares]).min(axis=0)
    told = clear(obstacles.beyond(starts), obstacles.beyond(ends), 0.3)
    doubtful = np.abs(looked - 0.3) < 1e-3
    assert (told == (looked >= 0.3))[~doubtful].all()
    assert told.any()
    assert not told.all()


def test_nothing_in_the_way_is_straight() -> None:
    found = plan(boxes((2.0, 1.0)), START, GOAL[None], ROOM)
    assert found.points is not None
    assert found.points.tolist() == [START.tolist(), GOAL.tolist()]


def test_goes_round_on_the_shorter_side() -> None:
    for aside in (0.1, -0.1):
        found = plan(boxes((2.0, aside)), START, GOAL[None], ROOM)
        assert found.points is not None
        assert found.points[1, 1] * aside < 0
        assert 4.0 < length(found.points) < 4.2


def test_random_ways_keep_their_room_and_with_less_of_it_are_no_longer() -> None:
    numbers = np.random.default_rng(2)
    ways = 0
    for _ in range(50):
        obstacles = random_boxes(numbers, 6)
        found = plan(obstacles, START, GOAL[None], ROOM)
        if found.points is None:
            continue
        ways += len(found.points) > 2
        assert nearest_distance(obstacles, found.points) > ROOM - 1e-3
        nearer = plan(obstacles, START, GOAL[None], ROOM / 2)
        assert nearer.points is not None
        assert length(nearer.points) <= length(found.points) + 1e-6
    assert ways > 20


def test_a_walled_goal_has_no_way_and_the_walls_are_told() -> None:
    walls = boxes((4.0, 0.7), (4.7, 0.0), (4.0, -0.7), (3.3, 0.0), (1.0, 0.2))
    found = plan(walls, START, GOAL[None], 0.3)
    assert found.points is None
    assert {0, 1, 2, 3} <= set(found.blocking)


def test_what_it_begins_beside_is_not_in_its_way() -> None:
    walls = boxes((4.0, 0.7), (4.7, 0.0), (4.0, -0.7), (3.3, 0.0), (-0.5, 0.0))  # the last nearer than the room
    found = plan(walls, START, GOAL[None], ROOM)
    assert found.points is None
    assert 4 not in found.blocking


def test_leaves_a_place_beside_an_obstacle_without_coming_nearer() -> None:
    obstacles = boxes((0.5, 0.0))  # 0.3 m away, nearer than the room
    found = plan(obstacles, START, GOAL[None], ROOM)
    assert found.points is not None
    assert nearest_distance(obstacles, found.points[:2]) >= 0.3 - 2e-3
    assert nearest_distance(obstacles, found.points[1:]) > ROOM - 1e-3


def test_takes_the_goal_with_the_shortest_way_and_what_it_costs() -> None:
    goals = np.array([[4.0, 0.0], [-1.0, 0.0]])
    near = plan(boxes((2.0, 0.0)), START, goals, ROOM)
    dear = plan(boxes((2.0, 0.0)), START, goals, ROOM, np.array([0.0, 9.0]))
    assert (near.goal, dear.goal) == (1, 0)


def test_does_the_same_again() -> None:
    obstacles = random_boxes(np.random.default_rng(3), 6)
    one, other = (plan(obstacles, START, GOAL[None], ROOM).points for _ in range(2))
    assert one is not None
    assert np.array_equal(one, other)
