"""Stand-ins: nodes that do what a test says in the place of a tree's own, by path or by type."""

from __future__ import annotations

import pytest
from py_trees.common import Status

import humanoid_bt as hbt
from humanoid_bt import Replacement, Stage, UserError, Workspace
from humanoid_bt.testing.substitution import Answer
from tests.review.direct import recorded_directly

HERE = [{"at": 0, "see": {"percept": "target", "position": [0.42, 0.2, 0.9]}}]


def changes(run, node):
    return [(round(change.time, 2), change.status.name) for change in run.changes if change.path.endswith(f"/{node}")]


def test_a_fixed_result_stands_in_for_a_node_by_the_end_of_its_path(dry):
    run = dry.run("fetch", replace={"reach": "success"})
    assert changes(run, "reach") == [(0.02, "SUCCESS")]
    assert run.time == pytest.approx(0.02)
    assert run.report.staged["replace"] == {"reach": "success"}
    assert "staged: reach is replaced: success" in [event["text"] for event in run.report.events]
    assert dry.run("fetch").time > 0.3  # the next run has its own nodes again


def test_a_failing_stand_in_lets_the_tree_do_what_it_does_then(dry):
    run = dry.run("fetch", duration=1, replace={"get near/approach": "failure"})
    assert changes(run, "approach")[0] == (0, "FAILURE")
    assert changes(run, "idle")[0] == (0, "RUNNING")


def test_a_type_means_every_node_of_it_and_a_composite_goes_with_all_below_it(dry):
    run = dry.run("fetch", replace={"selector": "running"}, duration=0.1)
    assert changes(run, "get near") == [(0, "RUNNING"), (0.1, "INVALID")]
    assert not changes(run, "approach")
    assert [node.type_name for node in run.tree.nodes if node.type_name in ("approach", "turn", "idle")] == []
    assert len([node for node in run.tree.nodes if node.type_name == "selector"]) == 3


def test_answers_come_one_after_the_other_and_the_last_again_and_again(tmp_path):
    (tmp_path / "trees").mkdir()
    (tmp_path / "trees" / "again.yaml").write_text(AGAIN)
    answers = [
        {"status": "failure", "after": "60 ms", "feedback": "slipped"},
        "failure",
        {"status": "success", "after": 0.1, "results": {"hand_error": "3 mm"}},
    ]
    run = Stage(tmp_path, dry=True).run("again", replace={"reach": answers}, script=HERE)
    assert changes(run, "reach") == [
        (0.0, "RUNNING"),
        (0.06, "FAILURE"),
        (0.1, "RUNNING"),
        (0.2, "SUCCESS"),
        (0.22, "RUNNING"),
        (0.32, "SUCCESS"),
    ]
    assert next(change.feedback for change in run.changes if change.status is Status.FAILURE) == "slipped"
    assert run.report.result("hand_error") == 0.003
    assert run.report.results[-1]["unit"] == "m"


AGAIN = """
format: 1
name: again
root:
  emergency_stop:
    watchdog:
      percept: target
      max_age: 0.5 s
      repeat:
        times: 2
        retry:
          attempts: 3
          reach: {target: target}
"""


def test_a_stand_in_says_nothing_to_the_robot(dry):
    run = dry.run("fetch", duration=0.1, replace={"approach": "running"})
    assert all("base" not in state.targets for state in run.states)


def test_what_a_node_did_in_a_recording_stands_in_for_it(dry, recorded):
    run = dry.run("fetch", replace={"reach": {"recorded": recorded.recording}}, script=HERE)
    was, now = ([change for change in of.changes if change.path.endswith("/reach")] for of in (recorded, run))
    assert [change.status for change in now] == [change.status for change in was]
    assert now[-1].time - now[0].time == pytest.approx(was[-1].time - was[0].time)
    assert [(one.name, one.unit) for one in now[-1].results] == [("hand_error", "m")]
    assert now[-1].feedback == was[-1].feedback


COUNT = """
from humanoid_bt import Skill, result

class Count(Skill):
    \"\"\"Report all sorts.\"\"\"

    bounded = True
    many: int = result(doc="How many.")
    whole: bool = result(doc="Whether that is all.")
    gap: float = result(unit="m", doc="Still to go.")

    def update(self):
        self.many, self.whole, self.gap = 2**53 + 1, True, 0.0123456789
        return self.succeed("good")
"""


def test_results_of_a_recording_are_what_they_were(tmp_path):
    for folder, file, text in [
        ("skills", "count.py", COUNT),
        ("trees", "t.yaml", "format: 1\nscene: empty\nroot: {sequence: [{wait: 0.1}, count]}\n"),
    ]:
        (tmp_path / folder).mkdir()
        (tmp_path / folder / file).write_text(text)
    stage, file = Stage(Workspace(tmp_path), dry=True), tmp_path / "t.rrd"
    with recorded_directly():
        was = stage.run("t", record=file)
    now = stage.run("t", replace={"count": {"recorded": str(file)}})
    assert now.report.results == was.report.results
    assert now.changes[-2].feedback == was.changes[-2].feedback == "good"


@pytest.mark.parametrize(
    ("replace", "message"),
    [
        ({"rech": "failure"}, "did you mean 'reach'"),
        ({"reach": "fail"}, "did you mean 'failure'"),
        ({"reach": 3}, "valid: success, failure, running, a list of"),
        ({"reach": []}, "valid: success, failure, running, a list of"),
        ({"reach": [{"status": "success", "afer": 1}]}, "did you mean 'after'"),
        ({"reach": [{"status": "success", "results": {"hand": 1}}]}, "the skill reports no 'hand'"),
        ({"reach": [{"status": "success", "results": {"hand_error": "3 kg"}}]}, "has the unit 'kg'"),
        ({"reach": {"recorded": "nowhere.rrd"}}, "replace reach: error: 'nowhere.rrd' is no recording"),
        ({"reach": {"recorded": object()}}, "'recorded' must be text, not an object of type object"),
    ],
)
def test_what_cannot_stand_in_is_said_before_anything_moves(dry, replace, message):
    with pytest.raises(UserError, match=message) as raised:
        dry.run("fetch", replace=replace)
    assert raised.value.__cause__ is None


def test_a_recording_without_the_node_says_so(dry, recorded):
    with pytest.raises(UserError, match=r"'fetch/.*/turn' does not run in the recording"):
        dry.run("fetch", replace={"turn": {"recorded": str(recorded.recording)}})


def test_a_recording_in_which_the_node_only_raised_says_so(dry, tmp_path):
    file = tmp_path / "raised.rrd"
    with recorded_directly():
        dry.run("stand", script=[{"at": 0, "raise": "idle"}], record=file)
    with pytest.raises(UserError, match=r"'stand/.*/idle' did nothing in the recording '.*' but raise an exception"):
        dry.run("stand", replace={"idle": {"recorded": file}})


def test_answers_can_be_made_in_python(dry):
    with pytest.raises(UserError, match="'status' cannot be 'sucess'\n    did you mean 'success'"):
        Answer(status="sucess")
    made = Replacement((Answer(status="success", after=0.1),))
    assert dry.run("fetch", replace={"reach": made}, script=HERE).trace == (
        dry.run("fetch", replace={"reach": [{"status": "success", "after": "100 ms"}]}, script=HERE).trace
    )


def test_the_tree_itself_is_left_as_it_is(dry):
    tree = hbt.load("fetch")
    dry.run(tree, replace={"selector": "success"}, duration=0.1)
    assert tree.node("approach").type_name == "approach"


def test_a_stand_in_of_a_node_that_asks_others_writes_the_keys_that_it_has(dry, tmp_path):
    leaf = "ros_service: {service: /lamp, type: std_srvs/SetBool, response: {message: said}}"
    file = tmp_path / "lamp.yaml"
    file.write_text(f"format: 1\nroot: {{sequence: [{{{leaf}}}, {{condition: said == 'on'}}]}}\n")
    lit = {"status": "success", "after": 0.1, "results": {"message": "on"}}
    run = dry.run(str(file), replace={"ros_service": [lit]})
    assert (run.report.outcome, changes(run, "ros_service")[-1]) == ("success", (0.1, "SUCCESS"))
    with pytest.raises(UserError, match=r"the node takes no 'mesage'(.|\n)*did you mean 'message'"):
        dry.run(str(file), replace={"ros_service": [{"status": "success", "results": {"mesage": "on"}}]})
    with pytest.raises(UserError, match="no-gateway"):
        dry.run(str(file))
