from __future__ import annotations

import pytest

from humanoid_bt.campaign.requirement import Requirement
from humanoid_bt.campaign.result import Result
from humanoid_bt.campaign.summary import Summary
from humanoid_bt.campaign.table import Table
from humanoid_bt.core.errors import UserError
from humanoid_bt.tree.expressions.expression import Truth
from tests.campaign.conftest import plan_of, table_of

_SAID = Summary(table_of(lambda seed: seed % 10 != 3, lambda seed: seed / 1000, "0-39"), {})


def _requirement(text: str) -> Requirement:
    return Requirement(Truth.parse(text), {"hand_error": "m"})


@pytest.mark.parametrize(
    ("text", "met", "why"),
    [
        ("success >= 90 %", True, "success is 90 %"),
        ("success > 90%", False, "success is 90 %"),
        ("success_low > 0.7 and success_high < 1", True, "success_low is 76.9 %, success_high is 96 %"),
        ("success >= 1 or success > 0", True, "success is 90 %"),
        ("time_median < 10.1 s", True, "time_median is 10 s"),
        ("hand_error_max < 3.8 cm", False, "hand_error_max is 3.9 cm"),
        ("failures == 4 and fell + crashed + hung == 0", True, "failures is 4, fell is 0, crashed is 0, hung is 0"),
    ],
)
def test_a_campaign_is_judged(text: str, met: bool, why: str) -> None:
    verdict = _requirement(text).judge(_SAID)
    assert (verdict.met, verdict.why) == (met, why)


def test_every_way_to_fail_is_counted_apart() -> None:
    outcomes = ["success"] * 2 + ["failure"] * 3 + ["stopped"] * 4 + ["error"] * 5 + ["hung"] * 6 + ["crashed"] * 7
    results = {number: Result(outcome, "") for number, outcome in enumerate(outcomes)}
    said = Summary(Table.of(plan_of("0-29"), results), {})
    for name, count in {"stopped": 4, "errors": 5, "hung": 6, "crashed": 7, "failures": 25, "trials": 27}.items():
        assert _requirement(f"{name} == {count}").judge(said).met, name


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sucess > 0.9", "unknown name 'sucess'.*\n.*did you mean 'success'"),
        ("hand_error_p95 < 1 s", "cannot be compared"),
        ("time_p95", "must be true or false"),
        ("distance(target) < 1 m", "unknown name 'target'|no percept 'target'"),
        ("state.standing", "not about a robot"),
        ("success >=", "no expression"),
        ("success >= 95 %%", "no expression"),
        ("success >= 95", "'success' is a share, from 0 to 1, and never 95.*\\n.*did you mean 95 %"),
        ("fell == 0 and not 3 > success_low", "'success_low' is a share.*\\n.*did you mean 3 %"),
        ("success_high > -0.5", "'success_high' is a share.*\\n.*valid: 0 % to 100 %"),
    ],
)
def test_what_no_campaign_can_tell_is_refused_before_it_runs(text: str, message: str) -> None:
    with pytest.raises(UserError, match=message):
        _requirement(text)


def test_what_cannot_be_computed_is_not_met() -> None:
    verdict = _requirement("failures / fell < 2").judge(_SAID)
    assert (verdict.met, verdict.why) == (
        False,
        "failures is 4, fell is 0: it cannot be computed (in 'failures / fell < 2': 'fell' is 0)",
    )
    assert _requirement("1 / (trials - failures) < 1").judge(_SAID).met, "with numbers of a campaign it can"


def test_what_nobody_reported_meets_nothing() -> None:
    for text in ("grip_force_max < 5", "not grip_force_max < 5", "grip_force_max != 5"):
        verdict = Requirement(Truth.parse(text), {"grip_force": ""}).judge(_SAID)
        assert (verdict.met, verdict.why) == (False, "grip_force_max is not known: no trial that succeeded has it")


@pytest.mark.parametrize(
    ("text", "met", "why"),
    [
        ("not time_p95 > 3 s", False, "time_p95 is not known: no trial that succeeded has it"),
        ("time_median != 5 s", False, "time_median is not known: no trial that succeeded has it"),
        ("fell == 0 or time_p95 < 3 s", True, "fell is 0, time_p95 is not known: no trial that succeeded has it"),
    ],
)
def test_what_only_successes_have_meets_nothing_without_any(text: str, met: bool, why: str) -> None:
    verdict = _requirement(text).judge(Summary(table_of(lambda _: False), {}))
    assert (verdict.met, verdict.why) == (met, why)


def test_no_trial_meets_nothing() -> None:
    verdict = _requirement("success != 1").judge(Summary(Table.of(plan_of(), {}), {}))
    assert (verdict.met, verdict.why) == (False, "success is not known: no trial is done")


def test_a_share_is_refused_on_either_side_of_and() -> None:
    for text in ("success >= 95 and fell == 0", "fell == 0 and success >= 95", "fell == 0 or success >= 95"):
        with pytest.raises(UserError, match="'success' is a share"):
            Requirement(Truth.parse(text), {})
    with pytest.raises(UserError, match=r"did you mean 100 %"):
        Requirement(Truth.parse("success >= 100"), {})
