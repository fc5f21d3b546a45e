"""The one form of YAML files: what changes, and that nothing but blanks ever does."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from humanoid_bt.core.errors import UserError
from humanoid_bt.files import formatting
from humanoid_bt.files.document import parse
from humanoid_bt.files.formatting import comments, formatted
from humanoid_bt.files.workspace import builtin_root

BUILTIN = sorted(path for part in ("trees", "sim") for path in (builtin_root() / part).rglob("*.yaml"))


@pytest.mark.parametrize("path", BUILTIN, ids=lambda path: path.name)
def test_the_built_in_files_have_the_form(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert formatted(text, path.name) == text


CHANGES = {
    "levels": (
        "root:\n    sequence:\n        - idle\n        -   reach:\n                target: ball\n",
        "root:\n  sequence:\n    - idle\n    - reach:\n        target: ball\n",
    ),
    "lists in the column of their key": (
        "a:\n- b\n- c:\n  - d\n- - e\n  - f\ng: 1\n",
        "a:\n  - b\n  - c:\n      - d\n  - - e\n    - f\ng: 1\n",
    ),
    "blanks around signs": (
        "a :   {  b : 1,c: [ 1,2 , 3 ] , d: { } }\n",
        "a: {b: 1, c: [1, 2, 3], d: {}}\n",
    ),
    "blanks that are signs of a name's or a tag's end": (
        "a: &x  1\n*x :  2\nb: [!!str , *x ]\n",
        "a: &x 1\n*x : 2\nb: [!!str , *x]\n",
    ),
    "empty lines and the end": ("\n\na: 1   \n\n\n\nb:\n\n  c: 2\n\n\n", "a: 1\n\nb:\n\n  c: 2\n"),
    "no line break at the end": ("a: 1\n# end", "a: 1\n# end\n"),
    "comments in a column": (
        "a: 1 # one\nlonger: 2   # two\nb:  # three\n    c: 1# no comment\n",
        "a: 1       # one\nlonger: 2  # two\nb:         # three\n  c: 1# no comment\n",
    ),
    "comments that stood in a column keep their distance": (
        "a:\n    b:   1      # one\n    cc:  2      # two\n",
        "a:\n  b: 1       # one\n  cc: 2      # two\n",
    ),
    "a comment that goes on below": (
        "a: 1 # one\n     # more\nlonger: 2    # two\n",
        "a: 1       # one\n           # more\nlonger: 2  # two\n",
    ),
    "comments of wide characters": ("a: 目标 # one\nb: abcd # two\n", "a: 目标  # one\nb: abcd  # two\n"),
    "no column where a line would grow too long": (
        f"a: 1 # {'x' * 60}\nb: {'y' * 60} # two\n",
        f"a: 1  # {'x' * 60}\nb: {'y' * 60}  # two\n",
    ),
    "comments before what they are about": (
        "a:\n# about b\n    b:\n      # about the list\n    - 1\n      # about 2\n    - 2\n",
        "a:\n  # about b\n  b:\n    # about the list\n    - 1\n    # about 2\n    - 2\n",
    ),
    "comments at the end of blocks": (
        "a:\n    b:\n        c: 1\n        # of c\n    # of b\n# of d\nd: 1\n",
        "a:\n  b:\n    c: 1\n    # of c\n  # of b\n# of d\nd: 1\n",
    ),
    "comments below a key without value": ("a:\n    b:\n        # later\nc: 1\n", "a:\n  b:\n    # later\nc: 1\n"),
    "code that was taken out": (
        "a:\n    # - b:\n      #   - c\n    - d\n",
        "a:\n  # - b:\n    #   - c\n  - d\n",
    ),
    "flow lists over lines, broken up": (
        "a:\n    b: [ # c\n     1,\n           # own\n     {x: 1,\n y: 2} ]\n",
        "a:\n  b: [  # c\n    1,\n    # own\n    {x: 1,\n     y: 2}]\n",
    ),
    "flow lists over lines, closed on their own": ("a: [\n1,\n   ]\n", "a: [\n  1,\n]\n"),
    "a value below its key in a flow mapping": (
        "a: {b:  # one\n # two\n  # three\n1}\n",
        "a: {b:  # one\n      # two\n       # three\n      1}\n",
    ),
    "text over lines": (
        "a:\n    b: one\n         two\n    c: 'three  \n\n      four'\n    d:\n        five\n",
        "a:\n  b: one\n    two\n  c: 'three\n\n    four'\n  d:\n    five\n",
    ),
    "literal text moves as a whole": (
        "a:\n    b: |   # why\n           one\n             two\n\n\n    c: 1\n",
        "a:\n  b: |   # why\n    one\n      two\n\n  c: 1\n",
    ),
    "literal text that says its indentation": ("a:\n    b: |2\n         one\n", "a:\n  b: |2\n       one\n"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_normalises(name: str) -> None:
    before, after = CHANGES[name]
    assert formatted(before, "") == after
    assert formatted(after, "") == after


KEPT = {
    "scalars of YAML 1.1": "a: [yes, Off, 012, 0x1F, 1e-3, 1:30, 1_000, +1.50, ~, Null, 2001-01-01, .nan, =]\nb:\n",
    "quotes and escapes": "a: \"\\u00e9 \\\n  more\"\n'b': \"c\"\nd: 'it''s'\n",
    "anchors, aliases, merges": "a: &x {b: 1}\nc:\n  <<: *x\n  d: *x\n",
    "an escaped blank before a line break": 'a: "b\\ \n  c"\n',
    "the end of literal text": "a: |+\n  one\n\n\nb: >-\n  two\n  three\n",
    "literal text without a line break": "a: |\n  one",
    "blanks in literal text": "a: |\n  one  \n     \n  two\n",
    "markers": "# head\n%YAML 1.1  # version\n---\na: 1\n...\n",
    "explicit keys": "? a\n: 1\n",
    "order": "b: 1\na: 2\n",
    "comments everywhere": (
        "# first\n\n# second\na:  # third\n  # fourth\n  - {b: 1,  # fifth\n     # sixth\n     c: 2}\n\n"
        "  # seventh\n# last\n"
    ),
}


@pytest.mark.parametrize("name", KEPT)
def test_keeps(name: str) -> None:
    assert formatted(KEPT[name], "") == KEPT[name]


def test_reads_any_line_breaks_and_a_byte_order_mark() -> None:
    assert formatted("\ufeffa:\r\n    - 1\r    - 2\n", "") == "a:\n  - 1\n  - 2\n"


def test_refuses_line_breaks_that_no_editor_shows() -> None:
    with pytest.raises(
        UserError, match=r"x\.yaml:2:7: error: cannot be formatted: the character U\+2028 breaks a line here"
    ):
        formatted('a: 1\nb: "c \u2028 d"\n', "x.yaml")


@pytest.mark.parametrize("text", ["", "# only\n", "a: [\n", "a: 1\na: 2\n", "a: !x 1\n", "a:\n\t- b\n"])
def test_a_mistake_is_told_as_check_tells_it(text: str) -> None:
    with pytest.raises(UserError) as told:
        formatted(text, "x.yaml")
    with pytest.raises(UserError) as checked:
        parse(text, "x.yaml")
    assert str(told.value) == str(checked.value)


@pytest.mark.parametrize(
    "result", ["a: true # c\n", "a: 1\n", "a: 1 # d\n", "a: 1 #  c\nb: 2\n", "a: 1# c\n", "a: 1 #c\n", "a: ["]
)
def test_refuses_a_result_that_says_something_else(result: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(formatting, "write", lambda text: result)
    with pytest.raises(UserError, match=r"x\.yaml: error: it cannot be formatted without changing what it says"):
        formatted("a: 1 # c\n", "x.yaml")


def test_lists_comments() -> None:
    assert comments("# a \nb: 1 # c\nd: |  # e\n  # text\nf: '# text'\n") == ["# a", "# c", "# e"]


# What holds for every file.

SCALARS = st.sampled_from(
    [
        "a",
        "1",
        "1e-3",
        "yes",
        "012",
        "~",
        "'q  r'",
        '"d\\" \\\n   e"',
        "two words",
        "$x",
        '"#"',
        "-1",
        "a#b",
        "'x\n\n   y'",
    ]
)
BLANKS = st.sampled_from(["", "", " ", "   "])
COMMENTS = st.sampled_from(["", "", "", "# c", "#c", "#  - code:"])


@st.composite
def flows(draw: st.DrawFn, depth: int, margin: str) -> str:
    """Return a value in flow form, with blanks, line breaks and comments where they may stand."""
    kind = draw(st.integers(0, 3 if depth else 0))
    if kind == 0:
        return draw(SCALARS.filter(lambda text: "\n" not in text))

    def gap() -> str:
        comment = draw(COMMENTS)
        line = f" {comment}\n{margin}{draw(BLANKS)} " if comment or draw(st.integers(0, 5)) == 0 else ""
        return draw(BLANKS) + line

    items = [draw(flows(depth - 1, margin)) for _ in range(draw(st.integers(0, 3)))]
    if kind == 1:
        return "[" + ",".join(f"{gap()}{item}{gap()}" for item in items) + "]"
    pairs = (f"{gap()}k{number}{draw(BLANKS)}: {item}{gap()}" for number, item in enumerate(items))
    return "{" + ",".join(pairs) + "}"


@st.composite
def blocks(draw: st.DrawFn, depth: int, column: int) -> list[str]:
    """Return the lines of a mapping or list that stands at a column."""
    is_list, margin = draw(st.booleans()), " " * column
    lines: list[str] = []
    for number in range(draw(st.integers(1, 3))):
        head = f"{margin}-" if is_list else f"{margin}k{number}{draw(BLANKS)}:"
        end = draw(COMMENTS)
        kind = draw(st.integers(0, 5 if depth else 2))
        inner = column + draw(st.integers(1, 5))
        if kind == 0:
            lines.append(f"{head} {draw(SCALARS)}".replace("\n", f"\n{margin}   "))
        elif kind == 1:
            lines.append(f"{head} {draw(BLANKS)}{draw(flows(2, margin))}")
        elif kind == 2:
            lines.append(f"{head} {draw(st.sampled_from(['|', '>-', '|+']))}")
            text = [" " * inner + "one", " " * inner + "  # two", ""]
            lines[-1] += f" {end}"
            lines += text
            end = ""
        else:
            children = draw(blocks(depth - 1, inner))
            lines.append(f"{head} {end}".rstrip())
            end = ""
            lines += children
        if end:
            lines[-1] += f"{draw(BLANKS)} {end}"
        for _ in range(draw(st.integers(0, 2)) if kind != 2 else 0):
            comment = draw(COMMENTS)
            lines.append(" " * draw(st.integers(0, column + 4)) + comment if comment else draw(BLANKS))
    return lines


@settings(max_examples=100, deadline=None, derandomize=True, database=None)
@given(blocks(3, 0))
def test_any_file_keeps_values_and_comments_and_is_formatted_once(lines: list[str]) -> None:
    text = "\n".join(lines) + "\n"
    before = parse(text, "before")
    result = formatted(text, "x.yaml")
    assert parse(result, "after").plain() == before.plain()
    assert comments(result) == comments(text)
    assert "".join(result.split()) == "".join(text.split())
    assert formatted(result, "x.yaml") == result
