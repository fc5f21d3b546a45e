"""Campaigns on a Ray cluster of two nodes, of which one is lost."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.campaign.conduct import Progress, conduct, summary
from humanoid_bt.campaign.ray_cluster import RayCluster, Ways
from humanoid_bt.campaign.stage_trials import Setup, make
from humanoid_bt.campaign.store import RESULTS, Store
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.variation import Factor
from humanoid_bt.campaign.workers import Done, Workers
from humanoid_bt.core.errors import UserError
from tests.campaign.conftest import plan_of

pytestmark = pytest.mark.ray

PLAN = plan_of("0-39", Factor("set.look", "s", ends=(4.0, 9.0)), dry=True)


@pytest.fixture
def cluster() -> Iterator[Any]:
    """Two nodes with a processor each, on this machine."""
    utils = pytest.importorskip("ray.cluster_utils")
    cluster = utils.Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    cluster.second = cluster.add_node(num_cpus=1)
    cluster.wait_for_nodes()
    yield cluster
    cluster.shutdown()


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """A folder with what is shipped: a skill of its own, and a tree that uses it."""
    root = tmp_path / "mine"
    (root / "skills").mkdir(parents=True)
    (root / "trees").mkdir()
    (root / "skills" / "ponder.py").write_text(_SKILL)
    (root / "trees" / "fetch.yaml").write_text(_TREE)
    return root


def _conduct(store: Store, runners: Any, progress: Progress | None = None) -> bytes:
    with store:
        conduct(store, runners, 1, progress or Progress())
        summary(store)
        return (store.folder / RESULTS).read_bytes()


def test_a_node_that_is_lost_loses_nothing(cluster: Any, workspace: Path, tmp_path: Path) -> None:
    class Lose(Progress):
        def __init__(self) -> None:
            super().__init__()
            self.done: list[int] = []

        def trial(self, done: Done) -> None:
            self.done.append(done.task.trial.number)
            if len(self.done) == 8:
                cluster.remove_node(cluster.second)

    runners = RayCluster(cluster.address, workspace, Ways(make, (Setup("."),), 60.0))
    try:
        table = _conduct(Store(tmp_path / "ray", PLAN, False), runners, progress := Lose())
    finally:
        runners.close()
    assert sorted(progress.done) == list(range(40))  # none lost, none twice
    here = Store(tmp_path / "here", PLAN, False)
    local = Workers(make, (Setup(str(workspace)),), count=1, time_limit=60.0, memory=None, logs=here.logs)
    assert table == _conduct(here, local)
    assert list((tmp_path / "ray" / "recordings").glob("*.rrd"))  # of a failure, come back from the cluster


def test_a_mistake_is_told_from_there(cluster: Any, workspace: Path, tmp_path: Path) -> None:
    (workspace / "trees" / "fetch.yaml").write_text(_TREE.replace("ponder", "pander"))
    runners = RayCluster(cluster.address, workspace, Ways(make, (Setup("."),), 60.0))
    try:
        with pytest.raises(UserError, match=r"trees/fetch\.yaml:10:31: error: 'pander' is neither"):
            list(runners.run([Task(trial) for trial in PLAN.trials]))
    finally:
        runners.close()


def test_a_cluster_that_is_not_there_is_told(workspace: Path) -> None:
    pytest.importorskip("ray")
    with pytest.raises(UserError, match="no trials can be run on the Ray cluster"):
        RayCluster("127.0.0.1:1", workspace, Ways(make, (Setup("."),), 60.0))


_SKILL = '''
"""Ponder."""

from humanoid_bt import Skill, Status, param


class Ponder(Skill):
    """Ponder, and give up where that takes long."""

    time: float = param(1.0, unit="s", doc="How long.")

    def update(self) -> Status:
        """Wait."""
        if self.robot.clock.now() > 8.0:
            return self.fail("it took longer than 8 s")
        return self.succeed("found it") if self.robot.clock.now() > self.time else self.running("hm")
'''
_TREE = """
format: 1
name: fetch
robot: humanoid
scene: empty
parameters:
  look: 5 s
root:
  emergency_stop:
    timeout: {duration: 20 s, ponder: {time: $look}}
"""
