"""``check_skill``: skills broken on purpose are caught, each by its rule, and the built-in ones pass."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, cast

import pytest
from py_trees.common import Status

import humanoid_bt as hbt
from humanoid_bt.core.messages import State
from humanoid_bt.testing.check_skill_lives import Life, Moment
from humanoid_bt.testing.check_skill_result import RULES
from humanoid_bt.testing.check_skill_time import TooLong
from humanoid_bt.testing.check_skill_trial import LONGEST_TICK, Evidence, _some
from tests.testing.broken_skills import SKILLS

BALL = (0.4, -0.2, 1.0)


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> hbt.Rig:
    folder = tmp_path_factory.mktemp("workspace")
    (folder / "skills").mkdir()
    (folder / "skills" / "broken.py").write_text(SKILLS, encoding="utf-8")
    return hbt.Rig(folder)


BROKEN = {
    "exceptions": ("exceptions", "raised ZeroDivisionError", "1 // 0"),
    "blocking": ("blocking", "p99 of 6 updates 2", "time.sleep(0.02)"),
    "halting": ("halting", "halted in tick 1 (0.00 s) it still commanded right_hand", ""),
    "restarting": ("restarting", "it was SUCCESS ('8 ticks'), before RUNNING", ""),
    "ending": ("ending", "it declares ends = False, and succeeded after 0.10 s", ""),
    "commands": ("commands", "it commands gaze, and declares right_hand", ""),
    "percepts": ("percepts", "it asks for 'door', and declares 'target'", ""),
    "snapshot": ("snapshot", "it wrote over state.hands", ""),
    "reasons": ("reasons", "it failed with 'not possible'", ""),
    "sameness": ("sameness", "it throws the dice of random", ""),
    "estop": ("estop", "while the robot was stopped it raised RuntimeError", "the hand does not move"),
    "lost": ("lost", "when it had never seen anything it raised AttributeError", "self.bearing ="),
}
"""Skill -> the rule that it breaks, what is said of it, what its line there holds."""

FURTHER = {
    "unready": ("exceptions", "in setup it raised OSError: no such device", "no such device"),
    "clock": ("sameness", "reads time.monotonic()", "self._began = time.monotonic()"),
    "unseeded": ("sameness", "another instance, shown the same, did otherwise: in tick 1", ""),
    "remembering": ("restarting", "in its second life, in tick 1 (0.00 s) it commanded right_hand", ""),
    "unfinished": ("restarting", "after it was halted, in tick 1 (0.00 s) it was FAILURE", ""),
    "rested": ("restarting", "started again where it had ended it raised RuntimeError: the hand is up", "is up"),
    "instant": ("ending", "it declares runs = False, and was RUNNING", ""),
    "pushing": ("snapshot", "it wrote over track('target').position_world", ""),
    "undecided": ("commands", "'undecided' cannot tell what it commands: KeyError: 'target'", ""),
    "silent": ("reasons", "it failed without a word at 0.00 s", ""),
    "noted": ("reasons", "it failed with 'not possible': no value, no name of a thing", ""),
    "terse": ("lost", "after its percepts were lost it ran on without a word", ""),
}
"""The same of skills that break one in another way."""

LONG = {
    "stubborn": ("halting", "raised RuntimeError: not now", "not now"),
    "endless": ("halting", "halted after 25 ticks it raised RuntimeError: not now", "not now"),
    "resuming": ("estop", "while the robot was stopped it raised RuntimeError", "where is the hand?"),
    "tireless": ("ending", "it declares ends = False, and failed after 0.00 s", ""),
    "slow_start": ("blocking", "p99 of 25 updates 3", "time.sleep(0.03)"),
    "hanging": ("blocking", "tick 1 did not come back", "time.sleep(0.01)"),
}
"""The same of skills that take long to be caught."""


def caught(rig: hbt.Rig, skill: str, rule: str, said: str, line: str) -> hbt.SkillCheck:
    check = rig.check_skill(skill, target=BALL, timeout=0.5)
    assert check.failed == (rule,), str(check)
    result = check.rules[rule]
    assert said in result.evidence
    assert f"broken.py:{line_of(line)}:" in result.evidence if line else "broken.py" not in result.evidence
    assert result.advice in RULES[rule][1] and result.advice
    assert rule != "halting" or len(result.advice) < 100, "what to do about this cause, and not about others"
    assert not check.passed
    with pytest.raises(AssertionError) as raised:
        check.assert_passed()
    kept = len([one for one in check.rules.values() if one.verdict == "passed"])
    head, _, rest = str(raised.value).partition("\n  ✗ ")
    assert f"keeps {kept} of 12 rules" in " ".join(head.split())
    assert rest.startswith(result.title) and "✓" not in rest
    assert rest.count("○ not tried") <= 2, "each reason is said once"
    assert str(check).partition("\n  ✗ ")[2].startswith(result.title)
    return check


def not_tried(check: hbt.SkillCheck) -> set[str]:
    return {rule for rule, result in check.rules.items() if result.verdict == "not tried"}


def line_of(text: str) -> int:
    """Return the line of the skills' file that holds a text, counted from 1."""
    return next(number for number, line in enumerate(SKILLS.splitlines(), 1) if text in line)


def test_every_rule_has_a_skill_that_breaks_it() -> None:
    assert list(RULES) == [rule for rule, *_ in BROKEN.values()]


def test_a_good_skill_keeps_all(rig: hbt.Rig) -> None:
    check = rig.check_skill("good", target=BALL)
    check.assert_passed()
    assert check.passed and not check.failed
    assert "6 updates" in check.rules["blocking"].evidence
    assert check.rules["halting"].evidence.startswith("halted in 5 of 5 ticks")
    assert check.rules["reasons"].evidence.startswith("\"'target' was never seen")
    assert rig.time < 0.2, "the robot stands at its start afterwards"


def test_a_key_has_no_value_as_each_life_begins(rig: hbt.Rig) -> None:
    rig.check_skill("tally", into="count").assert_passed()


@pytest.mark.parametrize("skill", BROKEN)
def test_a_broken_skill_is_caught_by_its_rule_alone(rig: hbt.Rig, skill: str) -> None:
    caught(rig, skill, *BROKEN[skill])


@pytest.mark.parametrize("skill", FURTHER)
def test_so_is_one_that_is_broken_in_another_way(rig: hbt.Rig, skill: str) -> None:
    caught(rig, skill, *FURTHER[skill])


@pytest.mark.trials
@pytest.mark.parametrize("skill", LONG)
def test_and_one_that_takes_long(rig: hbt.Rig, skill: str) -> None:
    caught(rig, skill, *LONG[skill])


@pytest.mark.parametrize("skill", ["counting", "naming", "obeying"])
def test_a_reason_is_a_number_a_name_or_why_the_robot_is_stopped(rig: hbt.Rig, skill: str) -> None:
    rig.check_skill(skill, target=BALL).assert_passed()
    if skill == "naming":
        assert not rig.check_skill(skill).failed, "it names what it was given by default"


def test_nothing_to_say_is_no_reason(rig: hbt.Rig) -> None:
    assert rig.check_skill("noted", target=BALL, note="").failed == ("reasons",)


@pytest.mark.parametrize(
    ("skill", "rules"),
    [("exceptions", {*RULES} - {"exceptions"}), ("clock", {"restarting"})],
)
def test_what_an_earlier_failure_hides_is_not_tried(rig: hbt.Rig, skill: str, rules: set[str]) -> None:
    assert not_tried(rig.check_skill(skill, target=BALL)) == rules


def test_nor_is_what_needs_the_skill_to_be_made_more_than_once(rig: hbt.Rig) -> None:
    check = caught(rig, "only_once", "sameness", "set up once more, it raised OSError", "the device is busy")
    assert not_tried(check) == {"blocking", "halting", "restarting", "estop", "lost"}


def test_a_tick_that_was_held_up_is_measured_again(rig: hbt.Rig) -> None:
    """By anything else on the machine, or because it was the first of the process."""
    rig.check_skill("warming", target=BALL).assert_passed()


@pytest.mark.parametrize(
    ("ticks", "slow"),
    [
        ([0.001] * 199 + [0.019], False),
        ([0.001] * 198 + [0.006] * 2, True),
        ([0.001] * 199 + [0.021], True),
        ([LONGEST_TICK] * 5, False),
        ([], False),
    ],
)
def test_one_tick_of_a_hundred_may_take_longer(ticks: list[float], slow: bool) -> None:
    assert Evidence(took=ticks).slow is slow


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({}, ""),
        ({"took": 1.0}, ""),
        ({"status": Status.FAILURE}, "it was FAILURE ('so'), before RUNNING ('so')"),
        ({"targets": {"gaze": {"x": 2.0}}}, "it commanded gaze to (2), before to (1)"),
        ({"targets": {}}, "it commanded gaze to nothing, before to (1)"),
        ({"feedback": "else"}, "it said 'else', before 'so'"),
        ({"results": {"left": 2}}, "its left was 2, before 1"),
    ],
)
def test_lives_differ_in_what_was_done(change: dict[str, Any], said: str) -> None:
    moment = Moment(0.0, cast(State, None), {}, Status.RUNNING, "so", {"gaze": {"x": 1.0}}, {"left": 1}, 0.0)
    assert Life([moment, replace(moment, **change)]).differs(Life([moment, moment])).endswith(said)
    assert bool(Life([replace(moment, **change)]).differs(Life([moment]))) is bool(said)


def test_lives_differ_in_what_was_raised() -> None:
    assert "device is busy" in Life([], OSError("the device is busy")).differs(Life())
    assert not Life([], TooLong("after 5 s")).differs(Life()), "another time it may take less"


def test_halting_must_come_to_an_end_too(rig: hbt.Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("humanoid_bt.testing.check_skill_lives.LONGEST", 0.2)
    check = rig.check_skill("clinging", target=BALL)
    assert check.failed == ("halting",)
    assert "halted in tick 1 (0.00 s) it raised TooLong" in check.rules["halting"].evidence


def test_of_many_ticks_the_first_and_the_last_are_tried() -> None:
    assert _some(list(range(9)), 3) == [0, 4, 8]
    assert _some([1, 2], 3) == [1, 2]


@pytest.mark.trials
def test_one_that_waits_without_a_word_does_so_whatever_it_waits_for(rig: hbt.Rig) -> None:
    check = rig.check_skill("wordless", target=BALL)
    assert check.failed == ("estop", "lost")
    assert all("it ran on without a word" in check.rules[rule].evidence for rule in check.failed)


@pytest.mark.trials
def test_a_thread_that_commands_on_is_noticed(rig: hbt.Rig) -> None:
    check = rig.check_skill("leaving", target=BALL)
    assert "halting" in check.failed
    assert "commanded right_hand in the tick after it" in check.rules["halting"].evidence


def test_what_is_declared_in_vain_is_told(rig: hbt.Rig) -> None:
    check = rig.check_skill("greedy", target=BALL)
    check.assert_passed()
    assert check.rules["commands"].evidence == "right_hand; declared and not commanded here: gaze"


def test_what_is_missing_or_unknown_is_one_message(rig: hbt.Rig) -> None:
    for skill, values, said in [
        ("reach", {}, "the skill 'reach' needs the parameter 'target'"),
        ("reach", {"targt": BALL}, "has no parameter 'targt'[^\0]*did you mean 'target'"),
        ("reech", {}, "no skill named 'reech'"),
        ("good", {"width": 1}, "has no parameter 'width'"),
    ]:
        with pytest.raises(hbt.UserError, match=said):
            rig.check_skill(skill, **values)


def test_what_was_shown_before_is_seen_in_every_life(rig: hbt.Rig) -> None:
    rig.reset()
    rig.see("ball", BALL)
    rig.check_skill("good", target="ball").assert_passed()


@pytest.mark.parametrize(("skill", "values"), [("good", {"target": "ball"}), ("tally", {"into": "count"})])
def test_afterwards_the_robot_stands_at_its_start_and_sees_what_it_was_shown(
    rig: hbt.Rig, skill: str, values: dict[str, str]
) -> None:
    rig.reset()
    rig.see("ball", BALL)
    rig.check_skill(skill, **values)
    assert rig.time < 0.1
    assert rig.run("good", target="ball").succeeded


def test_a_life_has_at_least_a_tick_and_comes_to_an_end(rig: hbt.Rig) -> None:
    check = rig.check_skill("good", target=BALL, timeout=0.005)
    assert check.rules["ending"].evidence.startswith("still ran after 0.00 s")
    with pytest.raises(hbt.UserError, match="'timeout' must be a number above 0, not inf"):
        rig.check_skill("good", target=BALL, timeout=math.inf)


def test_a_run_tells_of_the_stops_that_came_while_it_ran(rig: hbt.Rig) -> None:
    rig.reset()
    rig.at(0.04, rig.raise_estop)
    assert len(rig.run("good", target=BALL, timeout=0.2).stops) == 1
    assert not rig.run("good", target=BALL, timeout=0.2).stops


def test_a_narrow_terminal_wraps(rig: hbt.Rig) -> None:
    text = rig.check_skill("reasons", target=BALL).text(40)
    assert max(map(len, text.splitlines())) <= 40


@pytest.mark.trials
def test_one_call_makes_a_rig_of_its_own(rig: hbt.Rig) -> None:
    check = hbt.check_skill("commands", workspace=rig.workspace, target=BALL)
    assert check.failed == ("commands",)
