"""Scenario files: what is read, and what is wrong with one, each with its place."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from humanoid_bt import UserError, Workspace, check
from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.testing.scenario_check import checked_scenario
from humanoid_bt.testing.seeds import Seeds

WHOLE = """\
format: 1
description: Everything that there is.
tree: fetch
robot: humanoid
scene: ball_on_stand
seeds: 0-2, 7
duration: 1 min
parameters: {stop_distance: 35 cm}
conditions: {friction: 0.8, payload: 2 kg}
script:
  - {at: 2 s, push: {force: [0, 60, 0]}}
  - {when: distance(target) < 1 m, lose: target}
replace:
  approach: [{status: failure, after: 2 s}, success]
expect:
  - within 20 s: outcome == success
  - never: [fell, estop]
  - order: [idle, approach]
  - hand_error < 2 cm
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "scenarios").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(folder: Path, text: str) -> Path:
    path = folder / "scenarios" / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_whole_file_is_read(folder: Path) -> None:
    scenario = checked_scenario(write(folder, WHOLE), Workspace(folder))
    assert scenario.name == "mine"
    assert list(scenario.seeds) == [0, 1, 2, 7]
    assert scenario.duration == 60
    assert [event.name for event in scenario.script] == ["push", "lose"]
    assert scenario.conditions.payload == 2
    assert [one.text for one in scenario.expect] == [
        "within 20 s: outcome == success",
        "never: fell",
        "never: estop",
        "order: [idle, approach]",
        "hand_error < 2 cm",
    ]
    assert [str(one.place) for one in scenario.expect][:3] == [
        f"scenarios/mine.yaml:{at}" for at in ("16:5", "17:5", "17:5")
    ]


@pytest.mark.parametrize(
    "expect", ["fell", "[fell]", "{never: fell}", "['never: fell']", "[never: fell, order: 'idle, approach']"]
)
def test_what_is_expected_may_be_one_thing_or_more(folder: Path, expect: str) -> None:
    checked_scenario(write(folder, f"format: 1\ntree: fetch\nexpect: {expect}\n"), Workspace(folder))


MISTAKES = {
    "no tree": ("tree: fetch", "tre: fetch", "3:1: error: unknown key 'tre' of the scenario", "did you mean 'tree'?"),
    "another tree": ("tree: fetch", "tree: fetsch", "3:7: error: no tree named 'fetsch'", "did you mean 'fetch'?"),
    "another robot": ("robot: humanoid", "robot: humanoit", "4:8: error: no robot named 'humanoit'", "'humanoid'"),
    "another scene": ("scene: ball_on_stand", "scene: ball", "5:8: error: no scene named 'ball'", "ball_on_stand"),
    "no seeds": ("seeds: 0-2, 7", "seeds: 9-2", "6:8: error: '9-2' are no seeds", "like 3, 0-9"),
    "seeds of another kind": ("seeds: 0-2, 7", "seeds: [1.5]", "6:9: error: 'seeds' cannot be a number", "like 3"),
    "a duration in kg": ("1 min", "1 kg", "7:11: error: 'duration' has the unit 'kg'", "valid: s, ms, min"),
    "a parameter": (
        "stop_distance",
        "stop_distanc",
        "8:28: error: the tree has no parameter",
        "did you mean 'stop_dist",
    ),
    "a parameter's unit": ("35 cm", "35 s", "8:29: error: 'stop_distance' has the unit 's'", "valid: m, cm, mm"),
    "a condition": ("friction: 0.8", "frition: 0.8", "9:14: error: unknown key 'frition'", "did you mean 'friction'?"),
    "a fault": ("push:", "pusch:", "11:15: error: unknown key 'pusch' of the event", "did you mean 'push'?"),
    "a late event": ("at: 2 s,", "at: 61 s,", "11:10: error: the event at 61 s never happens", "an earlier moment"),
    "no moment": ("at: 2 s, ", "", "11:5: error: an event happens at a time or when", "write at: 2 s, or when:"),
    "a percept of a fault": ("lose: target", "lose: taget", "12:42: error: no percept source publishes", "'target'"),
    "a body of a fault": (
        "{force: [0, 60, 0]}}",
        "{force: [0, 60, 0], body: trso}}",
        "11:47: error: there is no body 'trso' to push [unknown-body]",
        "'torso'",
    ),
    "a node of a fault": (
        "lose: target",
        "raise: reech",
        "12:43: error: the tree 'fetch' has no node 'reech' [unknown-node]",
        "'reach'",
    ),
    "a name to set": (
        "lose: target",
        "set: {lok: 2}",
        "12:42: error: the tree has no key or parameter 'lok' [unknown-parameter]",
        "'look'",
    ),
    "a value to set": ("lose: target", "set: {reach.hold: x}", "12:54: error: 'hold' must be a number", ""),
    "a moment": ("(target) < 1", "(taget) < 1", "12:12: error: in 'distance(taget) < 1 m': there is no", "'target'"),
    "physics in a dry run": ("seeds: 0-2, 7", "dry: true", "11:5: error: 'push' needs a body", "run it without dry"),
    "a node to replace": (
        "  approach:",
        "  approch:",
        "14:3: error: the tree 'fetch' has no node 'approch'",
        "did you mean 'approach'?",
    ),
    "a stand-in": (", success]", ", sucess]", "14:45: error: 'status' cannot be 'sucess'", "did you mean 'success'?"),
    "a recording": (
        "[{status: failure, after: 2 s}, success]",
        "{recorded: none.rrd}",
        "14:24: error: 'scenarios/none.rrd' is no recording that can be read: No such file",
        "",
    ),
    "another stand-in": (
        "[{status: failure, after: 2 s}, success]",
        "sucess",
        "14:13: error: nothing can stand in for 'approach' like this",
        "did you mean 'success'?",
    ),
    "nothing expected": (
        WHOLE[WHOLE.index("expect:") :],
        "expect: []",
        "15:9: error: 'expect' expects nothing",
        "like",
    ),
    "no expectation": (
        WHOLE[WHOLE.index("expect:") :],
        "",
        "1:1: error: the key 'expect' of the scenario is missing",
        "",
    ),
    "a kind": (
        "within 20 s:",
        "withn 20 s:",
        "16:5: error: 'withn' is no kind of expectation",
        "did you mean 'within'?",
    ),
    "a time": ("within 20 s:", "within 20 cm:", "16:12: error: '20 cm' is no time", "valid: s, ms, min"),
    "a time that is too long": ("20 s:", "70 s:", "16:5: error: a run ends after 60 s", "duration: 70 s"),
    "a word": ("[fell,", "[fel,", "17:13: error: in 'fel': unknown name 'fel'", "did you mean 'fell'?"),
    "a step": ("[idle, approach]", "[idle, aproach]", "18:19: error: the tree 'fetch' has no node", "'approach'?"),
    "a unit": ("hand_error < 2 cm", "hand_error < 2 s", "19:16: error: in 'hand_error < 2 s': a number in m", ""),
    "a claim": ("- hand_error < 2 cm", "- hand_error << 2 cm", "19:17: error: 'hand_error << 2 cm' is no", ""),
    "a list as a claim": ("- hand_error < 2 cm", "- [hand_error]", "19:5: error: 'expect' must be an expression", ""),
    "a list of claims": ("[fell, estop]", "[fell, {a: 1}]", "17:19: error: 'never' must be an expression", ""),
    "no claims": ("[fell, estop]", "[]", "17:12: error: 'never' expects nothing", "like within 20 s"),
    "no YAML": ("expect:", "expect: {", "", ""),
}


@pytest.mark.parametrize(("old", "new", "message", "hint"), MISTAKES.values(), ids=list(MISTAKES))
def test_a_mistake_is_told_where_it_is_and_what_would_be_valid(
    folder: Path, old: str, new: str, message: str, hint: str
) -> None:
    assert WHOLE.count(old) == 1
    path = write(folder, WHOLE.replace(old, new))
    with pytest.raises(UserError) as raised:
        checked_scenario(path, Workspace(folder))
    told = str(raised.value)
    assert f"scenarios/mine.yaml:{message}" in told
    assert hint in told
    assert [str(problem) for problem in check("scenarios/mine.yaml")] == [*map(str, raised.value.problems)]


def test_a_sub_tree_does_not_run_alone(folder: Path) -> None:
    with pytest.raises(UserError, match=r"mine\.yaml:2:7: error: the tree 'greet' does not run alone"):
        checked_scenario(write(folder, "format: 1\ntree: greet\nexpect: fell\n"), Workspace(folder))


def test_all_mistakes_are_told_in_one_round(folder: Path) -> None:
    text = (
        WHOLE.replace("ball_on_stand", "ball").replace("stop_distance", "stop_distanc").replace("friction", "frition")
    )
    text = text.replace("push:", "pusch:").replace("lose: target", "set: {lok: 2}").replace("approach:", "approch:")
    text = text.replace("[fell,", "[fel,").replace("idle,", "idel,").replace("2 cm", "2 s")
    problems = check(str(write(folder, text)))
    assert [problem.place.line for problem in problems if problem.place] == [5, 8, 9, 11, 12, 14, 17, 18, 19]


def test_no_percept_is_missed_where_it_is_not_known_which_there_are(folder: Path) -> None:
    broken = WHOLE.replace("lose: target", "see: {percept: cup, position: [1]}").replace(
        "hand_error < 2 cm", "cup.age < 1 s"
    )
    for text in (WHOLE.replace("ball_on_stand", "ball").replace("distance(target)", "distance(cup)"), broken):
        (problem,) = check(str(write(folder, text)))
        assert "no scene named 'ball'" in problem.message or "'position' must have 3 values" in problem.message


def test_a_fault_without_parameters_has_its_defaults(folder: Path) -> None:
    text = "format: 1\ntree: stand\nexpect: fell\nscript:\n  - {at: 1 s, estop: }\n  - {at: 2 s, reset: {}}\n"
    scenario = checked_scenario(write(folder, text), Workspace(folder))
    assert [event.name for event in scenario.script] == ["estop", "reset"]


@pytest.mark.parametrize(
    ("event", "message"),
    [
        ("{at: 1 s, lose: }", "4:25: error: the key 'percept' of 'lose' is missing"),
        ("{at: , estop: }", "4:10: error: an event happens at a time or when something becomes true"),
        ("{when: }", "4:10: error: an event happens at a time or when something becomes true"),
    ],
)
def test_what_an_event_lacks_is_told(folder: Path, event: str, message: str) -> None:
    with pytest.raises(UserError) as raised:
        checked_scenario(write(folder, f"format: 1\ntree: fetch\nexpect: fell\nscript: [{event}]\n"), Workspace(folder))
    assert message in str(raised.value)


def test_an_event_at_the_last_moment_may_be_in_a_script(folder: Path) -> None:
    text = WHOLE.replace("1 min", "20 s").replace("{at: 2 s,", "{at: 20 s, optional: true,")
    assert checked_scenario(write(folder, text), Workspace(folder)).script[0].optional


@pytest.mark.parametrize("tree", ["../odd/tree.yaml", "tree.yaml"])
def test_files_are_looked_for_beside_it(folder: Path, tree: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(folder, f"format: 1\ntree: {tree}\nexpect: idle runs\n")
    file = path.parent / tree
    file.parent.mkdir(exist_ok=True)
    file.write_text("format: 1\nroot: {emergency_stop: idle}\n", encoding="utf-8")
    monkeypatch.chdir(folder.parent)
    checked_scenario(path, Workspace(folder))


def test_a_robots_folder_is_looked_for_beside_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(folder, "format: 1\ntree: stand\nrobot: ../sim/mine\nexpect: idle runs\n")
    shutil.copytree(builtin_root() / "sim" / "humanoid", folder / "sim" / "mine")
    monkeypatch.chdir(folder.parent)
    checked_scenario(path, Workspace(folder))


def test_mistakes_of_its_tree_are_told_in_the_tree(folder: Path) -> None:
    (folder / "trees").mkdir()
    (folder / "trees" / "odd.yaml").write_text("format: 1\nroot: {emergency_stop: idel}\n", encoding="utf-8")
    write(folder, "format: 1\ntree: odd\nexpect: not fell\n")
    assert [str(problem.place) for problem in check()] == ["trees/odd.yaml:2:24"]


@pytest.mark.parametrize(
    ("text", "shown", "count"), [("3", "3", 1), ("0-9", "0-9", 10), ("7, 0-2,1", "7, 0-2", 4), (" 5 - 6 ", "5-6", 2)]
)
def test_seeds_are_written_as_ranges(text: str, shown: str, count: int) -> None:
    assert (str(Seeds.parse(text)), len(Seeds.parse(text))) == (shown, count)


@pytest.mark.parametrize("text", ["", "-1", "3-", "a", "9-0", "0-99999999999", "1;2", "0-1000000"])
def test_what_are_no_seeds(text: str) -> None:
    with pytest.raises(UserError, match="are no seeds"):
        Seeds.parse(text)
