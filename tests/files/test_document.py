from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.files import document

BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{name}: &{name} [{', '.join(['*' + before] * 10)}]\n" for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)
MERGE_BOMB = "a: &a {x: 1}\n" + "".join(
    f"{name}: &{name} {{<<: [{', '.join(['*' + before] * 10)}]}}\n"
    for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)
KEYS = ", ".join(f"k{number}: 1" for number in range(300))


def refused(text: str) -> Problem:
    with pytest.raises(UserError) as caught:
        document.parse(text, "f.yaml")
    assert len(caught.value.problems) == 1
    return caught.value.problems[0]


@pytest.mark.parametrize(
    "text",
    [
        "{a: 1, b: [x, 2.5, true, null, 'y'], c: {d: }}",
        "- 1\n- - 2\n  - {a: b}\n",
        "base: &b {x: 1, y: 2}\nown: {<<: *b, y: 3}\n",
        "first: &f {x: 1}\nsecond: &s {x: 2, y: 2}\nboth: {<<: [*f, *s]}\n",
        "a: &a [1, 2]\nb: *a\n",
        "text: |\n  two\n  lines\n",
        "0x10: 1",
    ],
)
def test_values_are_those_of_safe_load_with_text_keys(text: str) -> None:
    def text_keys(value: object) -> object:
        if isinstance(value, dict):
            return {("0x10" if key == 16 else key): text_keys(child) for key, child in value.items()}
        return value

    assert document.parse(text, "f").plain() == text_keys(yaml.safe_load(text))


def test_dates_are_text() -> None:
    assert document.parse("[2024-01-01, =]", "f").plain() == ["2024-01-01", "="]


def test_every_value_and_key_has_its_place() -> None:
    item = document.parse("a: 1\nb:\n  - x\n  - {c: 2}\n", "f.yaml")
    assert str(item.key_places["b"]) == "f.yaml:2:1"
    second = item.value["b"].value[1]
    assert (str(second.place), str(second.value["c"].place)) == ("f.yaml:4:5", "f.yaml:4:9")


def test_kinds_in_words() -> None:
    item = document.parse("[{}, [], x, true, ~, 1]", "f")
    assert [child.kind for child in item.value] == ["a mapping", "a list", "text", "a boolean", "nothing", "a number"]


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("", "f.yaml:1:1", "the file is empty"),
        ("# only a comment\n", "f.yaml:1:1", "the file is empty"),
        ("a: 1\na: 2", "f.yaml:2:1", "the key 'a' stands twice"),
        ("a: [1, 2", "f.yaml:1:4", "the bracket [ is not closed"),
        ("a: {b: 1 c: 2}", "f.yaml:1:10", "a comma is missing before 'c'"),
        ("a: {b: c: 2, d: 3}", "f.yaml:1:8", "a mapping in a mapping needs braces of its own"),
        ("a: b: c", "f.yaml:1:5", "a second colon in one line"),
        ("a: \x00", "f.yaml:1:4", "not valid YAML: the character U+0000 is not allowed"),
        ("a: 1\nb: \x01", "f.yaml:2:4", "not valid YAML: the character U+0001 is not allowed"),
        ("[a]: 1", "f.yaml:1:1", "a key must be text"),
        ("a: &a [*a]", "f.yaml:1:4", "an alias refers to a value that contains it"),
        ("a: &a {<<: *a}", "f.yaml:1:4", "an alias refers to a value that contains it"),
        ("a: {<<: 3}", "f.yaml:1:9", "only mappings can be merged"),
        ("a: *nothing", "f.yaml:1:4", "plain text cannot begin with '*'"),
        ("a: {b: c, d\ufeff [1, 2]}", "f.yaml:1:13", "not valid YAML: while parsing a flow mapping"),
        ("a: !!python/object/apply:os.system [ls]", "f.yaml:1:4", "the tag '!!python/object/apply:os.system'"),
        ("a: !mine x", "f.yaml:1:4", "the tag '!mine' is not supported"),
        ("a: !!set {x}", "f.yaml:1:4", "the tag '!!set' is not supported"),
        ("a: !!int x", "f.yaml:1:4", "'x' is not a valid int"),
        ("a: !!bool x", "f.yaml:1:4", "'x' is not a valid bool"),
        ("a: 1\n---\nb: 2", "f.yaml:2:1", "not valid YAML"),
        (r'a: "\UFFFFFFFF"', "f.yaml:1:7", "not valid YAML: no character or version has this number"),
        ("%YAML " + "9" * 5000 + ".1\n--- a", "f.yaml:1:7", "not valid YAML: no character or version has this number"),
        (r'a: "\uD800"', "f.yaml:1:4", r"'\ud800' holds half a character"),
        (r'{"\uD800": 1}', "f.yaml:1:2", r"'\ud800' holds half a character"),
        ("a: " + "9" * 5000, "f.yaml:1:4", "is not a valid int"),
        (BOMB, "f.yaml", "more than 100000 values"),
        (f"a: &a {{{KEYS}}}\nb: {{<<: [{'*a, ' * 500}]}}", "f.yaml:2:5", "more than 100000 values"),
        (f"a: &a {{{KEYS}}}\nb: {{<<: [{'{<<: *a}, ' * 500}]}}", "f.yaml:2:", "more than 100000 values"),
        ("[" * 200 + "]" * 200, "f.yaml:1:100", "nested deeper than 100 levels"),
        ("[" * 100_000, "f.yaml:1:100", "nested deeper than 100 levels"),
        ("- " * 5000 + "x", "f.yaml", "nested deeper than 100 levels"),
        ("{a: " * 3000, "f.yaml", "nested deeper than 100 levels"),
    ],
)
def test_what_is_refused(text: str, place: str, message: str) -> None:
    problem = refused(text)
    assert str(problem.place).startswith(place)
    assert message in problem.message


@pytest.mark.parametrize(
    ("text", "place", "whole"),
    [
        ("expect:\n  - 'act on target' failed  # why\n", "f.yaml:2:21", '''"'act on target' failed"'''),
        ("never: 'act on target' failed", "f.yaml:1:24", '''"'act on target' failed"'''),
        ("expect: [fell, 'act on' failed]", "f.yaml:1:25", '''"'act on' failed"'''),
        ('- "act on" failed', "f.yaml:1:12", """'"act on" failed'"""),
    ],
)
def test_text_behind_a_quoted_one_is_put_in_quotes_with_it(text: str, place: str, whole: str) -> None:
    problem = refused(text)
    assert (str(problem.place), problem.hint) == (place, f"put all of it in quotes: {whole}")
    assert document.parse(text.replace(whole[1:-1], whole), "f")


def test_nesting_through_aliases_is_bounded() -> None:
    chain = "a0: &a0 [x]\n" + "".join(f"a{n}: &a{n} [*a{n - 1}]\n" for n in range(1, 300))
    assert "nested deeper than" in refused(chain).message


def test_merging_does_not_multiply() -> None:
    assert document.parse(MERGE_BOMB, "f").plain()["i"] == {"x": 1}


def test_duplicate_keys_can_be_collected_with_other_mistakes() -> None:
    problems: list[Problem] = []
    item = document.parse("a: 1\nb: {c: 1, c: 2}\na: 3", "f", problems)
    assert item.plain() == {"a": 1, "b": {"c": 1}}
    assert [str(problem.place) for problem in problems] == ["f:3:1", "f:2:11"]


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be read: No such file"):
        document.load(tmp_path / "none.yaml")
    with pytest.raises(UserError, match="cannot be read"):
        document.load(tmp_path)
    (tmp_path / "latin.yaml").write_bytes(b"a: \xe9")
    with pytest.raises(UserError, match="not UTF-8"):
        document.load(tmp_path / "latin.yaml")
