"""Expectations: what they mean, what is refused, and what is told where they are not met."""

from __future__ import annotations

import pytest

from humanoid_bt import Stage, TreeRun, UserError
from humanoid_bt.testing.expectation_text import expectation
from humanoid_bt.testing.expectations import Expectations, Failure

SKILL = '''
from humanoid_bt import Skill, Status, param, result


class Fill(Skill):
    """Fill a cup, 10 cm a second."""

    to: float = param(0.2, unit="m", doc="How far.")
    level: float = result(unit="m", doc="How full it is.")
    sort: str = result(doc="What is in it.")

    def initialise(self):
        self._since = self.robot.clock.now()

    def update(self):
        elapsed = self.robot.clock.now() - self._since
        if elapsed < 0.1:
            return self.running("looking for the cup")
        self.level, self.sort = 0.1 * elapsed, "tea"
        return self.succeed("the cup is full") if self.level >= self.to - 1e-9 else self.running("filling")
'''

TREE = """
format: 1
parameters: {limit: 20 cm}
blackboard: {count: 0}
root:
  emergency_stop:
    sequence:
      - wait: {name: first, duration: 1 s}
      - fill: {to: $limit}
      - set_blackboard: {key: count, expression: count + 2}
      - set_blackboard: {key: served, value: true}
      - force_success: {failure: {name: not that}}
      - timeout: {name: impatient, duration: 0.5 s, wait: {name: too long, duration: 9 s}}
"""
# first 0 to 1 s, fill 1 to 3 s (level from 1.1 s on), count 2 and served at 3 s, 'too long' 3 s to 3.5 s, then failure

AGAIN = """
format: 1
root:
  emergency_stop:
    sequence:
      - repeat:
          times: 2
          sequence:
            - wait: {name: again, duration: 0.2 s}
            - fill: {to: 2 cm}
      - parallel:
          success: one
          children:
            - fill: {name: more, to: 9 m}
            - wait: {name: for a while, duration: 0.3 s}
      - success: {name: bye}
"""
# again 0 to 0.2 s and 0.42 to 0.62 s, fill after each for 0.2 s, then more until it is halted at 1.12 s


SPILT = """
format: 1
blackboard: {cups: 0}
root:
  emergency_stop:
    on_error:
      sequence: [{fill: {to: 2 cm}}, {log: "{1 / cups}"}]
"""
# fill 0 to 0.2 s; an exception in that tick halts the sequence


@pytest.fixture(scope="module")
def kitchen(tmp_path_factory: pytest.TempPathFactory) -> Stage:
    folder = tmp_path_factory.mktemp("workspace")
    trees = {"trees/tea.yaml": TREE, "trees/again.yaml": AGAIN, "trees/spilt.yaml": SPILT}
    for name, text in {**trees, "skills/fill.py": SKILL}.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return Stage(folder, dry=True)


@pytest.fixture(scope="module")
def run(kitchen: Stage) -> TreeRun:
    found = kitchen.run("tea")
    assert (found.outcome, found.time) == ("failure", pytest.approx(3.5, abs=1e-6))
    return found


@pytest.fixture(scope="module")
def short(kitchen: Stage) -> TreeRun:
    return kitchen.run("tea", duration=0.1)


@pytest.fixture(scope="module")
def again(kitchen: Stage) -> TreeRun:
    return kitchen.run("again")


def failures(run: TreeRun, *texts: str) -> list[Failure]:
    return Expectations.of(texts).failures(run, ())


MET = (
    "outcome == failure",
    "outcome != success and time < 4 s",
    "contains(reason, 'timed out')",
    "not fell and not stopped and not estop and stops == 0",
    "within 4 s: outcome == failure",
    "within 1 s: fill runs",
    "within 3.1 s: fill succeeded",
    "within 3100 ms: count == 2",
    "within 2.1 s after first succeeded: level >= 20 cm",
    "within 1 min after first succeeded: fill.sort == 'tea'",
    "never: fell",
    "never: level > $limit + 1 mm",
    "never: first runs while fill runs",
    "never: fill failed",
    "always: level < 25 cm while fill runs",  # before it has a value, nothing is judged
    "always: served",  # so of a key
    "always: 'too long' runs while time > 3.1 s and time < 3.4 s",
    "always: is_set(count)",
    "order: [first, fill]",
    "order: first, fill, 'too long'",
    "order: [tea/emergency_stop/sequence/first, fill runs and level > 10 cm, count == 2, too long]",
    "order: [fill runs, not fill runs]",  # true from the beginning on is not become so
    "order: [not fill runs, fill runs, not fill runs]",
    "order: [first, first succeeded, fill succeeded, impatient failed]",
    "first succeeded and fill succeeded and 'not that' failed",
    "'too long' halted",
    "'too long' ran and not first runs",
    "fill.feedback == 'the cup is full'",
    "fill.level == level",
    "abs(level - 20 cm) < 1 mm",
    "state.mode == 'run' and state.gait != 'step'",
    "failure == outcome",
    "reason != 'so: so'",
    "within 0.7 s: time >= 0.7 s",  # the sum of 35 periods is a bit more
    "within 0.2 s after time > 0.5 s: time < 0.6 s",  # that it is later than 0.5 s becomes true once
    "never: level > 1 m while first runs",  # what has no value has not become so
    "within 2 s: time > 1 s hysteresis 2 s",
    "order: [contains(fill.feedback, 'full'), 'too long']",
    "order: max(abs(level), 1 cm) > 2 cm, (((fill succeeded))), 'too long'",
    "order: [time > 0.5 s and time < 0.6 s or time > 0.8 s and time < 0.9 s or time > 1.5 s, fill, "
    "time > 0.5 s and time < 0.6 s or time > 0.8 s and time < 0.9 s or time > 1.5 s]",  # of three times two count
)


@pytest.mark.parametrize("text", MET)
def test_what_is_so_is_met(run: TreeRun, text: str) -> None:
    assert not failures(run, text)


def test_what_ends_and_is_reset_in_one_tick_has_ended_as_it_did(kitchen: Stage) -> None:
    spilt = kitchen.run("spilt")
    assert not failures(spilt, "fill succeeded", "level >= 2 cm", "fill.feedback == 'the cup is full'")
    told = [change["status"] for change in spilt.report.timeline if change["path"].endswith("/fill")]
    assert told == ["RUNNING", "SUCCESS", "INVALID"]


NOT_MET = (
    ("outcome == success", 3.5, "it was not so at the end", {"outcome": "failure"}),
    ("level > 30 cm", 3.5, "it was not so at the end", {"level": "0.2 m"}),
    ("within 2 s: fill succeeded", 2.0, "it had not become so by then", {"fill": "runs"}),
    ("within 2 s: served", 2.0, "it had not become so by then", {"served": "no value yet"}),
    ("within 1 s: time > 1.01 s", 1.0, "it had not become so by then", {"time": "1.02 s"}),
    ("within 0.99 s: time > 2 s", 0.99, "it had not become so by then", {"time": "1 s"}),
    (
        "within 0.2 s after time > 0.5 s and time < 0.6 s or time > 1.5 s: time > 0.6 s and time < 0.7 s",
        1.72,  # the second time
        "it had not become so by then",
        {},
    ),
    (
        "within 0.5 s after time > 0.5 s and time < 0.6 s or time > 0.9 s: time > 1.2 s",
        1.02,  # that it comes once more meanwhile gives no more time
        "it had not become so by then",
        {},
    ),
    ("order: [fill, fill]", 3.5, "'fill' did not come after that", {"fill": "came at 1.00 s"}),
    ("within 10 s: outcome == success", 3.5, "the run ended before it became so", {"outcome": "failure"}),
    (
        "within 1 s after first succeeded: fill succeeded",
        2.0,
        "it had not become so by then",
        {"fill": "runs", "first": "succeeded: waited 1 s"},
    ),
    (
        "within 1 s after fill failed: fell",
        3.5,
        "nothing was looked at: 'fill failed' was never so",
        {"fell": "false", "fill": "succeeded: the cup is full"},
    ),
    ("never: level > 15 cm", 2.5, "it became so", {"level": "0.15 m"}),
    ("never: level > 15 cm while first runs or fill runs", 2.5, "it became so", {"level": "0.15 m"}),
    ("always: level < 15 cm while fill runs", 2.5, "it was not so", {"level": "0.15 m", "fill": "runs"}),
    ("always: fell while estop", 3.5, "nothing was looked at: 'estop' was never so", {"estop": "false"}),
    ("always: level < 1 m while first runs", 3.5, "nothing was looked at: it never had a value", {}),
    (
        "order: [fill, first]",
        0.0,
        "'first' came before 'fill'",
        {"fill": "came at 1.00 s", "first": "came at 0.00 s"},
    ),
    (
        "order: [first, fill failed, impatient]",
        3.0,
        "'impatient' came before 'fill failed'",
        {"first": "came at 0.00 s", "fill failed": "did not come", "impatient": "came at 3.00 s"},
    ),
    ("order: [first, fill, first]", 3.5, "'first' did not come after that", {"first #2": "did not come"}),
    ("order: [first, fill succeeded, fill runs]", 1.0, "'fill runs' came before 'fill succeeded'", {}),
    ("never: 1 / stops > 0", 0.0, "it cannot be judged: ZeroDivisionError: in '1 / stops > 0': 'stops' is 0", {}),
)


@pytest.mark.parametrize(("text", "time", "why", "values"), NOT_MET)
def test_what_is_not_so_is_told_with_the_moment_and_the_values(
    run: TreeRun, text: str, time: float, why: str, values: dict[str, str]
) -> None:
    (failure,) = failures(run, text)
    assert failure.expectation == text
    assert failure.why == why
    assert failure.time == pytest.approx(time, abs=1e-6)
    assert values.items() <= dict(failure.values).items()


NAMED = """
format: 1
root:
  emergency_stop: {sequence: [{success: {name: look and wait}}, {wait: {name: step 1.5, duration: 0.1 s}}, success]}
"""


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("order: ['look and wait', 'step 1.5', success]", ""),
        ("order: [look and wait, 'step 1.5']", ""),
        ("order: [success, 'step 1.5']", "'step 1.5' came before 'success'"),
    ],
)
def test_a_step_is_any_name_of_a_node(kitchen: Stage, text: str, why: str) -> None:
    (kitchen.workspace.root / "trees" / "named.yaml").write_text(NAMED, encoding="utf-8")
    assert [failure.why for failure in failures(kitchen.run("named"), text)] == [why] * bool(why)


def test_the_time_of_a_run_goes_on_until_it_ends(short: TreeRun) -> None:
    assert not failures(short, "time >= 0.1 s")


def test_a_run_is_judged_as_if_it_were_the_first(run: TreeRun, short: TreeRun) -> None:
    for text in (*MET, *(text for text, *_ in NOT_MET)):
        used = Expectations.of([text])
        used.failures(run, ())
        assert used.failures(short, ()) == failures(short, text)
        assert used.failures(run, ()) == failures(run, text)


@pytest.mark.parametrize(
    "text",
    [
        "always: not again succeeded while again runs",
        "never: fill halted",  # that it succeeded is forgotten when its sequence begins again
        "order: [again, fill, again, fill, more, bye]",
        "order: [wait, fill, wait, fill, wait]",
        "within 0.1 s: wait runs",  # one of them
        "wait succeeded and not wait runs and more halted",
        "never: 'for a while' failed while 'for a while' runs",
        "always: level < 1.5 cm while time > 0.93 s and time < 0.96 s",  # what runs has it, not what ended
        "level > 2.5 cm",  # what ended last has it
        "order: [fill.feedback == 'looking for the cup', fill succeeded, fill.feedback == 'looking for the cup']",
        "never: contains(wait.feedback, '0.2 s') while 'for a while' runs",  # what runs says it, not what ended
        "contains(wait.feedback, '0.3 s')",  # what ended last said it
    ],
)
def test_what_begins_again_and_what_there_is_more_than_one_of(again: TreeRun, text: str) -> None:
    assert not failures(again, text)


BRIEF = """
format: 1
root:
  emergency_stop:
    sequence:
      - force_success: {parallel: [{fill: {name: gone, to: 9 m}}, {failure: {}}]}
      - wait: {name: after, duration: 0.1 s}
"""


@pytest.mark.parametrize(
    "text",
    [
        "gone ran and gone halted and not gone runs",
        "order: [gone, after]",
        "always: gone halted while after runs",
        "contains(gone.feedback, 'halted')",
    ],
)
def test_what_begins_and_is_halted_in_one_tick_was_there(kitchen: Stage, text: str) -> None:
    (kitchen.workspace.root / "trees" / "brief.yaml").write_text(BRIEF, encoding="utf-8")
    assert not failures(kitchen.run("brief"), text)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("order: [again, fill, fill, again]", "'again' did not come after that"),
        ("order: [bye, bye]", "'bye' did not come after that"),  # that the run ends is no tick
        ("order: [fill, again, fill]", "'again' came before 'fill'"),  # and they came in order later
        ("always: level < 1 mm while fill runs and time > 0.61 s and time < 0.7 s", "nothing was looked at: it never"),
    ],
)
def test_what_was_before_does_not_count_again(again: TreeRun, text: str, why: str) -> None:
    (failure,) = failures(again, text)
    assert failure.why.startswith(why)


@pytest.mark.parametrize(
    ("text", "column", "message", "hint"),
    [
        ("withn 3 s: fell", 1, "'withn' is no kind of expectation", "did you mean 'within'?"),
        ("within: fell", 1, "'within' needs a time", "within 20 s"),
        ("within 3 m: fell", 8, "'3 m' is no time", "valid: s, ms, min"),
        ("within 1e999 s: fell", 8, "'1e999 s' is no time", "valid: s, ms, min"),
        ("within 3 s fill: fell", 12, "'fill' is not expected behind a time", "within 20 s"),
        ("never ever: fell", 7, "'ever' is not expected behind 'never'", "never: P while Q"),
        ("never fell", 7, "'never fell' is no expression: 'fell' is not expected there", 'did you mean "never: fell"?'),
        ("within 3 s fell", 8, "'within 3 s fell' is no expression", 'did you mean "within 3 s: fell"?'),
        ("order [first, fill]", 7, "'order [first, fill]' is no expression", 'did you mean "order: [first, fill]"?'),
        ("never: fel", 8, "in 'fel': unknown name 'fel'", "did you mean 'fell'?"),
        ("never: fell while", 18, "'' is no expression: a value is expected at the end", ""),
        ("always: fill", 9, "in 'fill': unknown name 'fill'", "of a node ask: fill runs, or ran"),
        ("always: fill rus", 14, "'fill rus' is no expression: 'rus' is not expected there", "did you mean 'runs'?"),
        ("never: fell or hot  tea runs", 21, "'tea' is not expected there", "in quotes: fell or 'hot  tea' runs"),
        ("hot tea.feedback == 'x'", 5, "'tea' is not expected there", "in quotes: 'hot tea'.feedback == 'x'"),
        ("hot tea and fill runs", 5, "'tea' is not expected there", "valid: failed, halted, ran, runs"),
        ("fil runs", 1, "the tree 'tea' has no node 'fil'", "did you mean 'fill'?"),
        ("that ran", 1, "the tree 'tea' has no node 'that'", "valid: "),  # of 'not that'
        ("outcome == sucess", 12, "no run ends with 'sucess'", "did you mean 'success'?"),
        ("outcome == 'sucess'", 9, "no run ends with 'sucess'", "did you mean 'success'?"),
        (
            "never: state.mode == 'protectivestop'",
            19,
            "state.mode is never 'protectivestop'",
            "mean 'protective_stop'?",
        ),
        ("never: 'walk' == state.gait", 15, "state.gait is never 'walk'", "valid: settle, stand, step"),
        ("true", 1, "'true' asks nothing of the run", "never: fell"),
        ("never: 1 > 2 while fell", 8, "'1 > 2' asks nothing of the run", "never: fell"),
        ("level < 3 s", 7, "a number in m and a number in s cannot be compared", ""),
        ("fill.levle < 3 m", 6, "the node 'fill' reports no 'levle'", "did you mean 'level'? valid: feedback"),
        ("time", 1, "it is a number in s, but must be true or false", ""),
        ("contains(reason)", 1, "contains() takes two texts", "contains(reason, 'never seen')"),
        ("distance(cup) < 1 m", 1, "there is no percept 'cup' in this run", "its scene publishes none"),
        ("order: [first]", 8, "an order has at least two steps", "order: [approach, reach]"),
        ("order: [first, , fill]", 16, "a step of the order is missing", "order: [approach, reach]"),
        ("order: [first, fil]", 16, "the tree 'tea' has no node 'fil'", "did you mean 'fill'?"),
        ("order: [first, 'fil and 1.5']", 16, "the tree 'tea' has no node 'fil and 1.5'", "valid: "),
        ("order: [first, level > 3 s]", 22, "a number in m and a number in s cannot be compared", ""),
    ],
)
def test_mistakes_are_told_with_their_place(run: TreeRun, text: str, column: int, message: str, hint: str) -> None:
    with pytest.raises(UserError) as raised:
        failures(run, text)
    (problem,) = raised.value.problems
    assert message in problem.message
    assert str(problem.place) == f"expectation:1:{column}"
    assert hint in problem.hint


def test_a_number_of_thousands_of_digits_is_no_time() -> None:
    with pytest.raises(UserError, match="9' is no time"):
        expectation(f"within {'9' * 5000}: fell")


SEEN = """
format: 1
name: seen
objects:
  ball: {shape: ball, size: [8 cm], position: [1, 0, 0.9]}
  far: {shape: ball, size: [8 cm], position: [9, 0, 0.9]}
percepts: {ball: {object: ball}, far: {object: far}}
"""


@pytest.mark.parametrize(
    ("claim", "why"),
    [
        ("ball.deviation > 1 cm", "nothing was looked at: nobody tells the deviation of 'ball'"),
        ("ball.class == 'cup' while time > 0.1 s", "nothing was looked at: nobody tells the class of 'ball'"),
        ("distance(far) < 1 m", ""),  # it may be seen in another run
    ],
)
def test_what_nobody_tells_of_a_percept_that_is_seen_cannot_fail(
    tmp_path_factory: pytest.TempPathFactory, claim: str, why: str
) -> None:
    folder = tmp_path_factory.mktemp("user")
    (folder / "seen.yaml").write_text(SEEN, encoding="utf-8")
    seen = Stage(scene=folder / "seen.yaml", dry=True).run("stand", duration=0.4)
    if not why:
        seen.expect(f"never: {claim}")
        return
    with pytest.raises(AssertionError, match=why):
        seen.expect(f"never: {claim}")


@pytest.mark.parametrize("text", ["", "  ", 5, None])
def test_what_is_no_text_is_no_expectation(run: TreeRun, text: object) -> None:
    with pytest.raises(UserError, match="an expectation is text, not"):
        run.expect(text)  # type: ignore[arg-type]  # the mistake that is tried


def test_a_test_in_python_uses_the_same_language(run: TreeRun) -> None:
    run.expect("within 4 s: outcome == failure", "never: fell")
    with pytest.raises(AssertionError) as raised:
        run.expect("never: fell", "never: level > 15 cm")
    told = str(raised.value)
    assert told.startswith("never: level > 15 cm\n    at 2.50 s it became so\n    level: 0.15 m")
    assert "failure: " in told
    assert "never: fell" not in told


def test_an_exception_of_a_skill_fails_whatever_does_not_ask_for_it() -> None:
    found = Stage(dry=True).run("stand", duration=1.0, script=[{"at": 0.1, "raise": "idle"}])
    assert found.outcome == "error"
    assert [failure.why[:27] for failure in failures(found, "never: fell")] == ["the run ended with an error"]
    assert not failures(found, "never: fell", "outcome == error")
    assert len(failures(found, "outcome == success")) == 1


def test_stops_and_emergency_stops_can_be_asked() -> None:
    script = [{"at": 0.2, "silence": "0.3 s"}, {"at": 1.0, "estop": "a hand at the button"}]
    found = Stage(dry=True).run("stand", duration=3.0, script=script)
    met = [
        "order: [not stopped, stopped and not estop, estop]",
        "stops == 2",
        "within 1.1 s: estop",
        "outcome == stopped",
        "estop",
    ]
    assert not failures(
        found,
        *met,
        "contains(reason, 'a hand at the button')",
        "always: stops == 1 while time > 0.4 s and time < 0.9 s",
    )


def test_a_fall_is_known_when_the_supervisor_lets_go_of_the_joints(stage: Stage) -> None:
    push = {"at": 0.1, "push": {"force": [600, 0, 0], "duration": "0.2 s"}}
    found = stage.run("stand", duration=1.0, script=[push])
    assert not failures(found, "order: [not fell, fell]", "fell and stopped", "stops == 1", "outcome == stopped")
    assert [failure.moment for failure in failures(found, "never: fell")] == [f"at {found.time:.2f} s it became so"]
    assert failures(found, "always: not stopped")
    ended = stage.run("stand", duration=0.3, script=[push])  # while it falls
    assert not failures(ended, "outcome == stopped", "fell", "stops == 1", "time < 0.31 s")
    assert failures(ended, "never: fell")
