"""Plans: which trials a campaign has, and in which order."""

from __future__ import annotations

from dataclasses import replace

from humanoid_bt.campaign.variation import Factor
from tests.campaign.conftest import DRAWN, GRID, plan_of


def test_all_of_a_seed_come_together() -> None:
    plan = plan_of("0-2", Factor("set.x", "", (1.0, 2.0)))
    (setting,) = plan.settings
    plan = replace(plan, settings=(setting, setting._replace(scene="random_target")))
    assert [trial.seed for trial in plan.trials] == [0] * 4 + [1] * 4 + [2] * 4


def test_every_combination_is_a_trial() -> None:
    plan = plan_of("0-2", GRID, DRAWN)
    assert len(plan) == len(plan.trials) == 6
    assert [trial.seed for trial in plan.trials] == [0, 0, 1, 1, 2, 2]
    assert len({trial.id for trial in plan.trials}) == 6
    first, second = plan.trials[:2]
    assert first.part("set") == {"stop_distance": 0.35}
    assert first.part("condition") == second.part("condition")  # what is drawn follows from the seed


def test_a_trial_is_called_the_same_in_another_campaign() -> None:
    ids = {(trial.seed, trial.given["set.stop_distance"]): trial.id for trial in plan_of("0-9", GRID).trials}
    other = Factor("set.stop_distance", "m", (0.4,))
    assert {ids[7, 0.4]} == {trial.id for trial in plan_of("7", other).trials}
