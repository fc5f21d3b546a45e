"""What people read of a campaign: nothing in it can be more than text, and every failure has its command."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from humanoid_bt.campaign.compare import compare
from humanoid_bt.campaign.plan import Plan
from humanoid_bt.campaign.report_html import html
from humanoid_bt.campaign.report_markdown import comparison_markdown, markdown
from humanoid_bt.campaign.reproduce import command
from humanoid_bt.campaign.requirement import Verdict
from humanoid_bt.campaign.result import Explained, Result
from humanoid_bt.campaign.stage_trials import pushes
from humanoid_bt.campaign.summary import Summary
from humanoid_bt.campaign.table import Table
from humanoid_bt.campaign.variation import Factor
from humanoid_bt.campaign.words import chance, figures
from humanoid_bt.cli.overrides import overrides
from humanoid_bt.core.errors import Place
from humanoid_bt.core.params import Param
from humanoid_bt.core.reading import convert
from humanoid_bt.tree.source.given import written_item
from tests.campaign.conftest import plan_of, table_of

EVIL = "<script>alert('|')</script> | `x`\n\x1b[31m"


@pytest.fixture
def said() -> Summary:
    plan = plan_of("0-9", Factor("set.stop_distance", "m", (0.3, 0.4)), description=EVIL)
    results = {
        trial.number: Result("success", "", time=10.0 + trial.seed, values={"hand_error": 0.01})
        if trial.seed
        else Result("failure", f"{EVIL} {trial.number} cm", EVIL)
        for trial in plan.trials
    }
    return Summary(Table.of(plan, results), {0: Explained("timeout", EVIL, EVIL, "a b.rrd", same=False)})


def test_the_page_is_well_formed_and_holds_only_text(said: Summary) -> None:
    page = html(said, [Verdict("success > 95 %", False, EVIL)], Path("runs/mine"))
    assert "<script" not in page
    assert "\x1b" not in page
    for svg in re.findall(r"<svg.*?</svg>", page):
        ElementTree.fromstring(svg)
    assert "90 %" in page
    assert 'href="recordings/a%20b.rrd"' in page
    assert "Trial 0 went another way" in page


def test_levels_are_told_apart_and_those_without_success_are_no_good() -> None:
    plan = plan_of("0-7", Factor("set.reach", "m", (0.3, 0.4)), Factor("condition.friction", ends=(0.79, 0.791)))
    results = {
        trial.number: Result("success" if trial.given["set.reach"] < 0.35 else "failure", "") for trial in plan.trials
    }
    said = Summary(Table.of(plan, results), {})
    texts = [level.text for level in said.levels["condition.friction"]]
    assert all(re.fullmatch(r"0\.79\d+ to 0\.79\d+", text) for text in texts)
    assert all(len(set(text.split(" to "))) == 2 for text in texts)
    assert html(said, [], Path()).count('class="dot lost"') == 1


def test_what_is_reported_with_a_sign_has_two_ends() -> None:
    told = dict(figures(Summary(table_of(lambda _: True, lambda seed: (seed - 80) / 1000), {})))
    assert told["hand error"] == "median -3 cm, 90 % from -7.5 cm to 1.4 cm"
    told = dict(figures(Summary(table_of(lambda _: True, lambda seed: seed / 1000), {})))
    assert told["hand error"] == "median 5 cm, 95 % within 9.4 cm"


def test_the_page_tells_what_is_not_done(said: Summary) -> None:
    plan = plan_of("0-99")
    assert "Not done: 98 of 100 trials" in html(
        Summary(Table.of(plan, {0: Result("success", ""), 5: Result("failure", "x")}), {}), [], Path()
    )
    assert "Not done: 100 of 100 trials" in html(Summary(Table.of(plan, {}), {}), [], Path())


def test_markdown_keeps_its_tables(said: Summary) -> None:
    text = markdown(said, [Verdict("success > 95 %", False, "success is 90 %")], Path("runs/mine"))
    rows = [line for line in text.splitlines() if line.startswith("| 2 |")]
    assert len(rows) == 1
    assert len(re.findall(r"(?<!\\)\|", rows[0])) == 4
    assert "<script" not in text
    assert "✗ `success > 95 %`: success is 90 %" in text


def test_a_requirement_is_code_in_markdown() -> None:
    said = Summary(table_of(lambda _: True), {})
    text = markdown(said, [Verdict("time_p95 < 20 s", True, "time_p95 is 10 s")], Path("runs/a"))
    assert "✓ `time_p95 < 20 s`: time_p95 is 10 s" in text


def test_a_comparison_for_a_pull_request() -> None:
    text = comparison_markdown(compare(table_of(lambda seed: seed % 10 > 0), table_of(lambda seed: seed % 20 > 0)))
    assert text.startswith("### 100 pairs: nothing differs beyond chance")
    assert "| success | 90 % | 95 % | +5 −0, p = 0.062 |" in text


@pytest.mark.parametrize(
    ("p", "text"),
    [(1.0, "p = 1"), (0.0625, "p = 0.062"), (0.00149, "p = 0.0015"), (0.001, "p = 0.001"), (0.00099, "p < 0.001")],
)
def test_what_is_rarer_than_one_in_a_thousand_is_told_as_that(p: float, text: str) -> None:
    assert chance(p) == text


def _plan(*factors: Factor, **named: Any) -> Plan:
    return plan_of("7", *factors, scene="random_target", **named)


def test_a_plain_trial_is_run_by_run() -> None:
    plan = _plan(Factor("set.stop_distance", "m", (0.35,)), Factor("condition.friction", "", (1.0,)), duration=20.0)
    assert command(plan.trials[0], plan, Path("runs/mine")) == (
        "humanoid-bt run fetch --robot humanoid --scene random_target --seed 7 --set stop_distance=0.35 --duration 20"
    )


@pytest.mark.parametrize(
    "value",
    [0.1 + 0.2, 1e-7, True, "left: 2", [0.5, 1], ["one\ntwo", "\x85 🤖"], ["it's", 'a "b"', "yes", "5"], {"a": [2]}],
)
def test_a_value_is_run_again_as_it_is(value: Any) -> None:
    plan = _plan(Factor("set.value", "", (value,)), duration=1234.5678)
    words = shlex.split(command(plan.trials[0], plan, Path("runs/mine")))
    assert words[-2:] == ["--duration", "1234.5678"]
    given = overrides([words[words.index("--set") + 1]])
    spec = Param("value", str if isinstance(value, str) else Any)
    assert convert(spec, written_item(spec, given["value"], Place("--set"))) == value


@pytest.mark.parametrize(
    "plan",
    [
        _plan(Factor("condition.friction", "", (0.9,))),
        _plan(Factor("push.1.at", "s", (1.0,))),
        _plan(script=({"at": "2 s", "lose": "target"},)),
        _plan(dry=True),
    ],
)
def test_what_run_cannot_do_is_run_again_by_the_campaign(plan: Plan) -> None:
    assert command(plan.trials[0], plan, Path("runs/mine")) == "humanoid-bt campaign rerun runs/mine 0"


def test_pushes_become_events() -> None:
    numbers = {"at": 2.0, "force": 50.0, "direction": 1.5707963267948966, "duration": 0.2}
    plan = _plan(*(Factor(f"push.{n}.{name}", "", (value + n,)) for n in (0, 1) for name, value in numbers.items()))
    first, second = pushes(plan.trials[0])
    assert first["at"] == 2.0
    assert first["push"]["force"] == pytest.approx([0.0, 50.0, 0.0])
    assert (second["at"], second["push"]["duration"]) == (3.0, 1.2)
