"""Comments that allow warnings: what they allow, and what is wrong with them."""

from __future__ import annotations

import pytest

from humanoid_bt.checking.allow import comments, remaining
from humanoid_bt.core.errors import Place, Problem


def warning(line: int, code: str = "no-time-limit", file: str = "f.yaml") -> Problem:
    return Problem("it may take for ever", Place(file, line, 3), code=code, severity="warning")


def codes(source: str, *problems: Problem, complete: bool = True) -> list[str]:
    """Return what remains, as codes with their lines."""
    left = remaining(source, "f.yaml", problems, complete=complete)
    return [f"{problem.code}:{problem.place.line}" for problem in left if problem.place]


@pytest.mark.parametrize(
    "source",
    [
        "- a  # allow no-time-limit: the operator ends it",
        "- a  #allow no-time-limit: why",
        "- a  #  allow   no-hysteresis ,no-time-limit : why",
        "- 'a # b'  # allow no-time-limit: why",
        "- |  # allow no-time-limit: why\n  a # b",
        "- {a: [1,  # allow no-time-limit: why\n  2]}",
    ],
)
def test_a_comment_allows_a_warning_of_its_line(source: str) -> None:
    assert codes(source, warning(1), complete=False) == []


@pytest.mark.parametrize(
    "source",
    [
        "# allow no-time-limit: why\n- a",
        "# allow no-time-limit: why\n# and more\n- a",
        "# what it does\n# allow no-time-limit: why\n# allow no-hysteresis: why\n- a",
        "   # allow no-time-limit: why\r\n- a",
    ],
)
def test_a_comment_alone_allows_a_warning_of_the_line_below(source: str) -> None:
    line = source.count("\n") + 1
    assert codes(source, warning(line), complete=False) == []


@pytest.mark.parametrize(
    ("source", "line"),
    [
        ("# allow no-time-limit: why\n\n- a", 3),
        ("- b  # allow no-time-limit: why\n- a", 2),
        ("- a\n# allow no-time-limit: why", 1),
        ("- 'x # allow no-time-limit: why'", 1),
        ('- "x\n  # allow no-time-limit: why"', 2),
        ("- |\n  # allow no-time-limit: why\n- a", 3),
        ("- a#allow no-time-limit: why", 1),
        ("# you may allow no-time-limit: why\n- a", 2),
    ],
)
def test_other_places_allow_nothing(source: str, line: int) -> None:
    assert f"no-time-limit:{line}" in codes(source, warning(line))


def test_a_comment_allows_what_it_names_in_its_own_file() -> None:
    source = "- a  # allow no-time-limit: why"
    assert codes(source, warning(1), warning(1, "no-hysteresis")) == ["no-hysteresis:1"]
    assert codes(source, warning(1), warning(1, file="other.yaml")) == ["no-time-limit:1"]


def test_one_comment_allows_every_such_warning_of_the_line() -> None:
    assert codes("- [a, b]  # allow no-time-limit: why", warning(1), warning(1)) == []


@pytest.mark.parametrize(
    "comment", ["# allow no-time-limit", "# allow no-time-limit:", "# allow no-time-limit it ends"]
)
def test_a_reason_is_required(comment: str) -> None:
    assert codes(f"- a  {comment}", warning(1)) == ["no-time-limit:1", "allow-without-reason:1"]


def test_an_unknown_code_is_told_with_the_nearest() -> None:
    (problem,) = remaining("- a  # allow no-time-limt: why", "f.yaml", [])
    assert (problem.code, problem.severity, str(problem.place)) == ("unknown-code", "warning", "f.yaml:1:6")
    assert problem.hint.startswith("did you mean 'no-time-limit'?")


def test_what_is_allowed_and_does_not_occur_is_told() -> None:
    source = "- a  # allow no-time-limit, no-hysteresis: why"
    (problem,) = remaining(source, "f.yaml", [warning(1)])
    assert problem.message == "'no-hysteresis' is allowed here and does not occur"
    assert remaining(source, "f.yaml", [warning(1)], complete=False) == []


def test_errors_cannot_be_allowed() -> None:
    error = Problem("unsafe", Place("f.yaml", 1, 3), code="outside-watchdog")
    left = remaining("- a  # allow outside-watchdog: it works", "f.yaml", [error])
    assert [problem.code for problem in left] == ["outside-watchdog", "cannot-allow"]
    assert "safety is not negotiable" in left[1].hint
    assert codes("- a  # allow unused-allow: it is old") == ["cannot-allow:1"]


@pytest.mark.parametrize(
    "sentence",
    [
        "# allow people to pass",
        "# allow",
        "# allow: it",
        "# allow the arm to rest: it is tired",
        "# allow it",
        "# allowed",
    ],
)
def test_a_sentence_is_no_allowance(sentence: str) -> None:
    assert codes(f"- a  {sentence}") == []


def test_a_skill_file_has_comments_of_python() -> None:
    source = 'x = "# allow no-time-limit: no"\nclass A:  # allow no-time-limit: why\n    pass\n'
    assert [comment.line for comment in comments(source, python=True)] == [2]
    left = remaining(source, "a.py", [warning(1, file="a.py"), warning(2, file="a.py")])
    assert [str(problem.place) for problem in left] == ["a.py:1:3"]


@pytest.mark.parametrize(
    ("source", "columns"),
    [
        ("", []),
        ("# a", [(1, 1)]),
        ("\ufeff# a\nb: 1", [(1, 2)]),
        ("%YAML 1.1 # a\n--- # b\nc: 1 # d\n... # e\n", [(1, 11), (2, 5), (3, 6), (4, 5)]),
        ("a: http://x#y # z", [(1, 15)]),
        ("a: 'it''s # b'  # c", [(1, 17)]),
        ("a: >-2  # b\n    c # d\n# e", [(1, 9), (3, 1)]),
        ("a: # b\n  - c # d", [(1, 4), (2, 7)]),
        ("a: 1\r# b\x85# c\u2028# d", [(2, 1), (3, 1), (4, 1)]),
        ("a: 1 # b\nc: [ # d\n}", [(1, 6), (2, 6)]),
        ('a: 1 # b\nc: "\\UFFFFFFFF"', [(1, 6)]),
        ("a: \x00 # b", []),
    ],
)
def test_comments_stand_where_yaml_has_them(source: str, columns: list[tuple[int, int]]) -> None:
    assert [(comment.line, comment.column) for comment in comments(source)] == columns
