"""``check_skill``: skills broken on purpose are caught, each by its rule, and the built-in ones pass."""

from __future__ import annotations

import pytest

import humanoid_bt as hbt
from humanoid_bt.testing.check_skill_result import RULES
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
    "stubborn": ("halting", "raised RuntimeError: not now", "not now"),
    "endless": ("halting", "halted after 25 ticks it raised RuntimeError: not now", "not now"),
    "unready": ("exceptions", "in setup it raised OSError: no such device", "no such device"),
    "only_once": ("sameness", "set up once more, it raised OSError", "the device is busy"),
    "slow_start": ("blocking", "p99 of 25 updates 3", "time.sleep(0.03)"),
    "remembering": ("restarting", "in its second life, in tick 1 (0.00 s) it commanded right_hand", ""),
    "unseeded": ("sameness", "another instance, shown the same, did otherwise: in tick 1", ""),
    "clock": ("sameness", "reads time.monotonic()", "self._began = time.monotonic()"),
    "hanging": ("blocking", "tick 1 did not come back", "time.sleep(0.01)"),
}
"""The same of skills that break one in another way."""


def caught(rig: hbt.Rig, skill: str, rule: str, said: str, line: str) -> None:
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
    head, first, *_ = str(raised.value).splitlines()
    assert f"keeps {len([one for one in check.rules.values() if one.verdict == 'passed'])} of 12 rules" in head
    assert first.startswith(f"  ✗ {result.title}") and "✓" not in str(raised.value)
    assert str(raised.value).count("○ not tried") <= 2, "each reason is said once"
    assert str(check).splitlines()[1] == first


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
    assert check.rules["reasons"].evidence.startswith("\"'target' was never seen")
    assert rig.time < 0.2, "the robot stands at its start afterwards"


@pytest.mark.parametrize("skill", BROKEN)
def test_a_broken_skill_is_caught_by_its_rule_alone(rig: hbt.Rig, skill: str) -> None:
    caught(rig, skill, *BROKEN[skill])


@pytest.mark.trials
@pytest.mark.parametrize("skill", FURTHER)
def test_so_is_one_that_is_broken_in_another_way(rig: hbt.Rig, skill: str) -> None:
    caught(rig, skill, *FURTHER[skill])


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


def test_a_narrow_terminal_wraps(rig: hbt.Rig) -> None:
    text = rig.check_skill("reasons", target=BALL).text(40)
    assert max(map(len, text.splitlines())) <= 40


@pytest.mark.trials
def test_one_call_makes_a_rig_of_its_own(rig: hbt.Rig) -> None:
    check = hbt.check_skill("commands", workspace=rig.workspace, target=BALL)
    assert check.failed == ("commands",)
