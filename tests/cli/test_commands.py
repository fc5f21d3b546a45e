"""Commands to a paused run, without a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import humanoid_bt as hbt
from humanoid_bt.cli.commands import HELP, answer

TREE = """\
format: 1
scene: ball_on_stand
parameters: {patience: {default: 2 s, unit: s}}
blackboard: {n: 0}
root:
  sequence:
    - wait: $patience
    - set_blackboard: {key: n, expression: n + 1}
    - set_blackboard: {key: found, value: 1}
    - condition: found == n
"""


@pytest.fixture
def session(project: Path) -> Iterator[hbt.Session]:
    (project / "trees" / "counts.yaml").write_text(TREE, encoding="utf-8")
    with hbt.Session("counts", workspace=project) as session:
        session.step()
        session.pause()
        session.wait(0.1)
        yield session


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("show", "├─ ▶ wait"),
        ("keys", "n = 0\nfound = (not set)"),
        ("percepts", "target: 1.9"),
        ("parameters", "patience = 2 s"),
        ("par wait", "duration = 2 s"),
        ("help", HELP),
        ("break n > 1", "n > 1"),
        ("clear", ""),
        ("set n = 5", ""),
        ("force wait success", ""),
    ],
)
def test_a_command_answers(session: hbt.Session, line: str, said: str) -> None:
    assert said in answer(session, line, "keyboard")
    session.wait(0.02)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("shw", "did you mean 'show'"),
        ("s", "unknown command 's'"),
        ("set n", "'set n' sets nothing"),
        ("set m = 1", "no key or parameter 'm'"),
        ("force wait", "'force wait' forces nothing"),
        ("force wait running", "valid: SUCCESS, FAILURE"),
        ("parameters wit", "did you mean 'wait'"),
        ("break", "a breakpoint is a node or an expression"),
    ],
)
def test_a_command_that_is_none_says_so(session: hbt.Session, line: str, said: str) -> None:
    with pytest.raises(hbt.UserError) as told:
        answer(session, line, "keyboard")
    assert said in str(told.value)


def test_what_was_set_counts(session: hbt.Session) -> None:
    answer(session, "set wait.duration = 40 ms", "keyboard")
    answer(session, "set n = 0", "keyboard")
    session.resume()
    report = session.run()
    assert report.outcome == "success"
    assert report.sim_time < 0.5


def test_parameters_are_shown_as_they_are_now_with_their_unit(session: hbt.Session) -> None:
    answer(session, "set patience = 5 s", "keyboard")
    assert answer(session, "parameters wait", "keyboard") == "duration = 5 s"
    assert answer(session, "parameters", "keyboard") == "patience = 5 s"
