from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.campaign.conduct import Progress, conduct, summary
from humanoid_bt.campaign.plan import Plan, Setting
from humanoid_bt.campaign.result import Result
from humanoid_bt.campaign.store import Store
from humanoid_bt.campaign.summary import Summary
from humanoid_bt.campaign.table import Table
from humanoid_bt.campaign.variation import Factor
from humanoid_bt.campaign.workers import Workers
from humanoid_bt.testing.seeds import Seeds
from tests.campaign.stand_ins import make

Conduct = Callable[..., Summary]

GRID = Factor("set.stop_distance", "m", (0.35, 0.4))
DRAWN = Factor("condition.friction", ends=(0.5, 1.2))


def plan_of(seeds: str = "0-19", *factors: Factor, scene: str = "empty", **named: Any) -> Plan:
    return Plan("mine", (Setting("fetch", "humanoid", scene),), Seeds.parse(seeds), factors, **named)


def table_of(
    good: Callable[[int], bool], error: Callable[[int], float] = float, seeds: str = "0-99", *factors: Factor
) -> Table:
    plan = plan_of(seeds, *factors)
    results = {
        trial.number: Result(
            "success" if good(trial.seed) else "failure",
            "" if good(trial.seed) else "too far",
            time=10.0,
            values={"hand_error": error(trial.seed)},
            units={"hand_error": "m"},
        )
        for trial in plan.trials
    }
    return Table.of(plan, results)


@pytest.fixture
def begun(tmp_path: Path) -> Path:
    """Where the stand-in notes which trials were begun."""
    folder = tmp_path / "begun"
    folder.mkdir()
    return folder


@pytest.fixture
def campaign(tmp_path: Path, begun: Path) -> Conduct:
    """Conduct a campaign of trials without a robot, each of which ends at once."""

    def run(
        plan: Plan, out: str = "out", resume: bool = False, count: int = 1, progress: Progress | None = None
    ) -> Summary:
        with Store(tmp_path / out, plan, resume) as store:
            workers = Workers(make, (begun,), count=count, time_limit=1.0, memory=1 << 30, logs=store.logs)
            conduct(store, workers, 2, progress or Progress())
            return summary(store)

    return run
