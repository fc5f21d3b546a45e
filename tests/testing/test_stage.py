"""The stage: a robot loaded once, trees run on it one after the other, each as if nothing had been before."""

from __future__ import annotations

import pytest
from py_trees.common import Status

import humanoid_bt as hbt
from humanoid_bt import Stage

SHORT = {"duration": 1.0}


@pytest.fixture(scope="module")
def stage() -> Stage:
    return Stage()


def test_runs_a_tree_to_the_bit_as_the_command_line_does(stage):
    for _ in range(2):
        assert stage.run("fetch", **SHORT).trace == hbt.run("fetch", **SHORT).trace_hash


def test_things_placed_by_chance_stand_where_the_seed_says():
    stage = Stage(scene="random_target")
    for seed in (1, 2, 1):
        run = stage.run("fetch", seed=seed, duration=0.3)
        assert run.trace == hbt.run("fetch", scene="random_target", seed=seed, duration=0.3).trace_hash


def test_what_one_run_leaves_the_next_does_not_find(stage):
    alone = stage.run("stand", **SHORT).trace
    stage.run("fetch", seed=7, conditions={"friction": 0.5, "payload": "3 kg", "drives": 0.9}, **SHORT)
    assert stage.run("stand", **SHORT).trace == alone


class Looker:
    def __init__(self):
        self.times, self.statuses, self.distances, self.ended = [], [], [], None

    def tick(self, view):
        self.times.append(view.time)
        self.statuses.append(view.status("approach"))
        self.distances.append(view.tracks["target"].distance if "target" in view.tracks else None)

    def end(self, run):
        self.ended = run


def test_a_watcher_sees_every_tick_and_can_look_again_later(stage):
    live, later = Looker(), Looker()
    run = stage.run("fetch", watchers=[live], duration=0.5)
    assert live.ended is run
    assert len(live.times) == len(run.samples) == 26
    assert live.statuses[-1] is Status.RUNNING
    for view in run.views():
        later.tick(view)
    assert (later.times, later.statuses, later.distances) == (live.times, live.statuses, live.distances)
