"""What a test did to a run stands in its report and in its recording, so that nobody takes it for something else."""

from __future__ import annotations

import json

import pytest

import humanoid_bt as hbt
from humanoid_bt import Stage, UserError, Workspace, explain, open_recording
from tests.review.direct import recorded_directly

LINES = [
    "dry: without physics, the robot is at once where it is told to be",
    "idle is replaced: running",
    "at 0.1 s lose (percept target)",
]
LATE = "at 9 s estop (reason too late)"


def test_the_report_says_what_was_staged(recorded, tmp_path):
    assert recorded.report.staged == {
        "dry": True,
        "told": [*LINES, f"{LATE}, which never happened"],
        "conditions": {},
        "replace": {"idle": "running"},
        "script": [
            {"at": 0.1, "lose": {"percept": "target", "duration": None}},
            {"at": 9, "estop": {"reason": "too late"}},
        ],
        "missed": [LATE],
    }
    assert repr(recorded).splitlines()[0] == "fetch on humanoid in ball_on_stand, seed 0, dry: without physics"
    assert f"  staged     {LINES[0]}" in repr(recorded).splitlines()
    assert "dry: without physics" in recorded.report._repr_html_()
    recorded.report.write(tmp_path / "report.json")
    assert json.loads((tmp_path / "report.json").read_text())["staged"]["dry"] is True


def test_the_recording_says_what_was_staged(recorded):
    recording = open_recording(recorded.recording)
    assert recording.setup["staged"]["told"] == [*LINES, LATE]
    told = [(row["time"], row["text"]) for row in recording.happened.events if row["text"].startswith("staged: ")]
    assert told == [
        (0.0, f"staged: {LINES[0]}"),
        (0.0, f"staged: {LINES[1]}"),
        (0.1, "staged: lose (percept target)"),
        (0.34, f"staged: never happened: {LATE}"),
    ]


COLLECT = """
from humanoid_bt import Key, Skill, param

class Collect(Skill):
    \"\"\"Collect numbers in two keys.\"\"\"

    bounded = True
    one: Key = param(doc="In place.")
    two: Key = param(doc="Anew.")

    def initialise(self):
        self.all = []

    def update(self):
        self.all.append(len(self.all))
        self.one.value.append(len(self.all))
        self.two.set(self.all)
        return self.running("on") if len(self.all) < 3 else self.succeed("collected 3")
"""


def test_each_tick_has_the_lists_of_its_own_time(tmp_path):
    for folder, file, text in [
        ("skills", "collect.py", COLLECT),
        ("trees", "t.yaml", "format: 1\nscene: empty\nblackboard: {one: []}\nroot: {collect: {one: one, two: two}}\n"),
    ]:
        (tmp_path / folder).mkdir()
        (tmp_path / folder / file).write_text(text)
    with recorded_directly():
        run = Stage(Workspace(tmp_path), dry=True).run("t", record=tmp_path / "t.rrd")
    one, two = [[1], [1, 2], [1, 2, 3]], [[0], [0, 1], [0, 1, 2]]
    assert [(sample.keys["one"], sample.keys["two"]) for sample in run.samples][:3] == list(zip(one, two, strict=True))
    board = open_recording(tmp_path / "t.rrd").blackboard().to_pylist()
    for name, values in (("one", one), ("two", two)):
        assert [json.loads(row["value"]) for row in board if row["key"] == name] == values


def test_an_explanation_names_what_was_staged(recorded):
    explanation = explain(recorded.recording)
    assert explanation.headline.endswith("; a test staged at 0.100 s: lose (percept target)")
    assert ("staged", LINES[0]) in explanation.rows
    assert ("", LINES[2]) in explanation.rows
    assert ("", f"{LATE}, which never happened") in explanation.rows


def test_a_moment_without_servo_cycles_is_explained_by_its_tick(recorded):
    explanation = explain(recorded.recording, at=0.2)
    assert explanation.headline == "at 0.200 s: 'reach' ran, mode run"
    assert explanation.data["command"] == 9
    with pytest.raises(UserError, match=r"valid: 0.000 to 0.\d\d\d s"):
        explain(recorded.recording, at=2.0)


def test_a_staged_run_is_not_replayed_as_if_nothing_had_been_done_to_it(recorded):
    with pytest.raises(UserError, match="a test that staged what happened, which a replay cannot do: dry") as error:
        hbt.replay(recorded.recording)
    assert "run the test again" in str(error.value)


@pytest.mark.trials
def test_a_push_that_was_staged_explains_the_fall(stage, tmp_path):
    push = {"at": 0.3, "push": {"force": [0, 900, 0]}}
    run = stage.run("stand", record=tmp_path / "push.rrd", script=[push], duration=2)
    assert run.fell
    explanation = explain(run.recording)
    assert explanation.kind == "push"
    assert explanation.headline.endswith(": it was pushed to the left with 900 N at 0.300 s; a test staged it")


@pytest.mark.trials
def test_a_run_to_which_nothing_was_done_is_replayed_to_the_bit(stage, tmp_path):
    run = stage.run("stand", record=tmp_path / "plain.rrd", duration=0.5)
    assert run.report.staged is None
    assert hbt.replay(run.recording).identical
    assert "staged" not in explain(run.recording).text()
