"""What nodes did is counted by where they are written: all of it, and nothing that cannot be."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.counting import FOLDER, Recorder, recorder
from humanoid_bt.tree.coverage import Coverage, FileCoverage
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.ticking import executor
from tests.semantics.lives import Life, random_lives
from tests.semantics.random_trees import SKILLS, Story, snapshots, stories
from tests.tree.helpers import Run, load, make_workspace, run, seen, write

Counted = Callable[[], Coverage]

SUCCEEDS = "{act: {script: s}}"
TREE = """\
root:
  sequence:
    - watchdog: {percept: target, max_age: 0.5 s, within: {percept: target, distance: 2 m}}
    - timeout:
        duration: 0.25 s
        act: {script: rrrs}
    - force_success: {act: {name: second, script: f}}
"""


@pytest.fixture
def counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Counted:
    """Count into a folder; what is given reads what stands there by now."""
    folder = tmp_path / "counted"
    monkeypatch.setenv(FOLDER, str(folder))

    def read() -> Coverage:
        found = Coverage()
        for path in folder.glob("*.json"):
            found.merge(Coverage.read(path))
        return found

    return read


def only(coverage: Coverage) -> FileCoverage:
    """Return what was counted of the only file."""
    (file,) = coverage.files.values()
    return file


def missing(coverage: Coverage) -> dict[str, tuple[str, ...]]:
    """Return what the nodes of the only file never did, by their names."""
    return {node.name: node.missing for node in only(coverage).ordered}


def test_counts_what_each_node_did_and_what_it_never_did(workspace: Workspace, counted: Counted) -> None:
    life = Run(load(workspace, TREE))
    for _ in range(4):
        life.tick(seen(life.time))
    assert life.executor.status.name == "FAILURE"
    assert missing(counted()) == {
        "sequence": ("success", "halted"),
        "watchdog": ("failure",),
        "within": ("failure",),
        "timeout": ("success", "halted"),
        "act": ("success", "failure"),
        "force_success": ("success", "running", "halted"),
        "second": ("success", "failure", "running", "halted"),
    }


def test_what_cannot_be_is_not_missing(workspace: Workspace, counted: Counted) -> None:
    run(workspace, "{emergency_stop: {sequence: [{force_success: {condition: state.mode == 'run'}}, idle]}}").ticks(1)
    recorder().save()
    nodes = {node.name: node.counted for node in only(counted()).ordered}
    assert nodes == {
        "emergency_stop": ("running", "halted"),
        "sequence": ("running", "halted"),  # nothing in it fails, and idle never ends
        "force_success": ("success",),
        "condition": ("success", "failure"),
        "idle": ("running", "halted"),
    }


def test_a_node_is_known_by_where_it_is_written(workspace: Workspace, counted: Counted) -> None:
    run(workspace, "{sequence: [success, success]}").ticks(1)
    file = only(counted())
    assert [(node.line, node.column, node.name) for node in file.ordered] == [
        (2, 8, "sequence"),
        (2, 19, "success"),
        (2, 28, "success"),
    ]
    assert file.path == workspace.root / "trees" / "t.yaml"


def test_a_sub_tree_belongs_to_its_own_file_whoever_uses_it(workspace: Workspace, counted: Counted) -> None:
    write(workspace, "do", "subtree: true\nparameters: {script: {default: s}}\nroot: {act: {script: $script}}\n")
    for script in "sf":
        path = write(workspace, f"use_{script}", f"root: {{subtree: {{tree: do, script: {script}}}}}\n")
        Run(load_tree(path, workspace)).ticks(1)
    files = {
        file.path.stem: {node.name: sorted(node.seen) for node in file.ordered} for file in counted().files.values()
    }
    assert files == {
        "do": {"act": ["failure", "success"]},
        "use_s": {"subtree": ["success"]},
        "use_f": {"subtree": ["failure"]},
    }


def test_a_parameter_that_stands_for_a_node_is_none_by_itself(workspace: Workspace) -> None:
    path = write(workspace, "t", "subtree: true\nparameters: {do: {type: node}}\nroot: {sequence: [$do, success]}\n")
    assert [node.name for node in Coverage().add(load_tree(path, workspace)).values()] == ["sequence", "success"]


def test_what_begins_and_ends_within_a_tick_is_counted(workspace: Workspace, counted: Counted) -> None:
    """That it ran is not told by itself: the node does not run before the tick, nor after it."""
    life = run(workspace, "{parallel: {success: one, children: [{act: {script: r}}, {success: {}}]}}")
    life.ticks(1)
    assert ("act", "RUNNING") not in life.told()
    assert missing(counted())["act"] == ("success", "failure")


def test_what_raised_was_not_halted(workspace: Workspace, counted: Counted) -> None:
    life = run(workspace, "{act: {script: rx}}")
    life.tick()
    with pytest.raises(Exception, match="out of order"):
        life.tick()
    assert missing(counted()) == {"act": ("success", "failure", "halted")}


def test_what_raised_at_once_was_ticked(workspace: Workspace, counted: Counted) -> None:
    life = run(workspace, "{sequence: [{on_error: {act: {script: x}}}, {act: {name: other, script: s}}]}")
    life.tick()
    assert {node.name: node.ticked for node in only(counted()).ordered} == {
        "sequence": True,
        "on_error": True,
        "act": True,
        "other": False,
    }


def test_a_run_that_is_halted_is_written_too(workspace: Workspace, counted: Counted) -> None:
    life = run(workspace, "{emergency_stop: idle}")
    life.tick()
    life.halt()
    assert missing(counted())["idle"] == ()


def test_a_node_that_says_something_as_it_is_halted_was_halted(workspace: Workspace, counted: Counted) -> None:
    life = run(workspace, "act")
    act = life.tree.root
    act.terminate = lambda _status: setattr(act, "feedback_message", "let go")  # type: ignore[method-assign]  # this node alone
    life.tick()
    life.halt()
    assert missing(counted())["act"] == ("success", "failure")
    assert str(act.feedback_message).startswith("halted: ")


def test_a_file_that_is_a_link_is_the_file_that_it_leads_to(workspace: Workspace, counted: Counted) -> None:
    write(workspace, "real", "root: act\n")
    (link := workspace.root / "trees" / "link.yaml").symlink_to("real.yaml")
    life = Run(load_tree(link, workspace))
    life.tick()
    life.halt()
    assert only(counted()).path.name == "real.yaml"
    assert missing(counted())["act"] == ("success", "failure")


def test_what_was_counted_before_the_folder_is_another_is_not_lost(
    workspace: Workspace, counted: Counted, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(workspace, "{emergency_stop: idle}").tick()
    monkeypatch.delenv(FOLDER)
    assert recorder() is None
    assert missing(counted())["idle"] == ("halted",)


def test_what_two_processes_counted_is_merged(
    workspace: Workspace, counted: Counted, monkeypatch: pytest.MonkeyPatch
) -> None:
    for script in "sf":
        monkeypatch.setattr("humanoid_bt.tree.counting._recorder", None)  # as another process has it
        Run(load(workspace, "parameters: {script: s}\nroot: {act: {script: $script}}\n", script=script)).ticks(1)
    assert missing(counted()) == {"act": ("running", "halted")}


def test_a_file_that_was_edited_counts_anew(workspace: Workspace, counted: Counted) -> None:
    run(workspace, SUCCEEDS).ticks(1)
    run(workspace, "{act: {script: f}}").ticks(1)
    assert [node.seen for file in counted().files.values() for node in file.ordered] != [{"success", "failure"}]
    assert len(counted().files) == 2


def test_nothing_is_counted_unless_it_is_asked_for(workspace: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(FOLDER, raising=False)
    life = run(workspace, SUCCEEDS)
    life.ticks(1)
    assert recorder() is None
    assert type(life.executor._seen()) is executor.Seen


def test_a_forked_process_counts_for_itself(workspace: Workspace, counted: Counted) -> None:
    run(workspace, SUCCEEDS).ticks(1)
    here = recorder()
    if (child := os.fork()) == 0:
        code = 0 if recorder() is not here and recorder().coverage.files == {} else 1
        os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_a_folder_that_cannot_be_written_stops_no_run(
    workspace: Workspace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv(FOLDER, str(tmp_path / "file" / "below"))
    assert run(workspace, SUCCEEDS).ticks(1) == "s"
    assert "tree coverage is not written" in caplog.text


@pytest.mark.parametrize(
    ("text", "said"), [("[]", "holds no tree coverage"), ('{"format": 7}', "its format is 7, not 1"), ("{", "JSON")]
)
def test_other_files_are_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "x.json"
    path.write_text(text)
    with pytest.raises(UserError, match=said):
        Coverage.read(path)


@pytest.fixture(scope="module")
def random_workspace(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    return make_workspace(tmp_path_factory.mktemp("trees") / "project", SKILLS)


@pytest.mark.trials
@random_lives
@given(story=stories())
def test_what_is_never_possible_never_comes(random_workspace: Workspace, story: Story) -> None:
    """In random trees; and all that is told is counted."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(FOLDER, str(random_workspace.root / "counted"))
        patch.setattr(Recorder, "save", lambda _self: None)
        life = Life(story.tree, random_workspace)
        tally = life.executor._tally
        told: set[tuple[str, str]] = set()
        for moment, now in zip(story.moments, snapshots(story.moments), strict=True):
            if moment.halt:
                life.stop(now.time)
            life.step(now)
            told |= {(change.path, change.status.name.lower()) for change in life.changes}
    counts = {node.path: tally._nodes[node.behaviour] for node in life.tree.nodes}
    for path, node in counts.items():
        assert node.seen <= node.possible, path
        assert {status for place, status in told if place == path} - {"invalid"} <= node.seen
