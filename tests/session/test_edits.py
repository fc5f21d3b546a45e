"""Finding edits: what counts as one, and when. One look per poll, so nothing here waits for a clock."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.edits import Edit, Edits
from humanoid_bt.session.loader import TreeLoader
from humanoid_bt.session.options import RunOptions
from humanoid_bt.tree.ticking.executor import Executor
from humanoid_bt.tree.tree import Tree
from tests.projects import make_project
from tests.tree.helpers import make_robot

WALK = "format: 1\nroot:\n  emergency_stop: walk\n"
WAIT = "format: 1\nroot:\n  emergency_stop: {wait: {duration: 1.0}}\n"
BROKEN = "format: 1\nroot:\n  emergency_stop: {wak: }\n"
CHOOSY = """
    def setup(self, **kwargs):
        super().setup(**kwargs)
        {what}
"""


class Files:
    """A project whose tree ``mine`` is watched."""

    def __init__(self, root: Path, **options: object) -> None:
        self.root = make_project(root / "project")
        self.tree = self.root / "trees" / "mine.yaml"
        self.skill = self.root / "skills" / "mine.py"
        self.tree.write_text(WALK, encoding="utf-8")
        self.while_loading: Callable[[], object] = lambda: None
        self._options = options
        self.edits = self.watched()

    def watched(self) -> Edits:
        loader = TreeLoader(RunOptions("mine", **self._options), Workspace(self.root))  # type: ignore[arg-type]  # of each their own kind
        return Edits(loader, self._prepare)

    def _prepare(self, tree: Tree) -> Executor:
        self.while_loading()
        executor = Executor(tree, make_robot(None))  # type: ignore[arg-type]  # it needs no engine here
        executor.setup()
        return executor

    def write(self, text: str) -> None:
        self.tree.write_text(text, encoding="utf-8")

    def polls(self, times: int) -> list[Edit]:
        """Look some times; return what was found."""
        return [edit for edit in (self.edits.poll() for _ in range(times)) if edit is not None]

    def edit(self) -> Edit:
        """Look until something is found, which must be the only thing."""
        (edit,) = self.polls(8)
        return edit


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Files:
    monkeypatch.chdir(tmp_path)
    return Files(tmp_path)


def leaf(edit: Edit) -> str:
    assert edit.executor is not None
    return edit.executor.tree.nodes[-1].name


def messages(edit: Edit) -> str:
    assert edit.executor is None
    return "\n".join(str(problem) for problem in edit.problems)


def test_without_an_edit_there_is_none(files: Files) -> None:
    assert files.polls(10) == []
    files.tree.touch()
    assert files.polls(10) == []


def test_an_edited_tree_is_loaded_when_it_was_the_same_in_two_looks(files: Files) -> None:
    files.write(WAIT)
    assert files.edits.poll() is None
    edit = files.edits.poll()
    assert edit is not None
    assert edit.files == ("project/trees/mine.yaml",)
    assert leaf(edit) == "wait"
    assert files.polls(10) == []


def test_a_file_that_is_still_written_is_waited_for(files: Files) -> None:
    for end in range(1, len(WAIT), 4):
        files.write(WAIT[:end])
        assert files.edits.poll() is None
    files.write(WAIT)
    assert leaf(files.edit()) == "wait"


@pytest.mark.parametrize("text", [None, ""])
def test_a_file_that_is_missing_or_empty_for_a_moment_is_not_broken(files: Files, text: str | None) -> None:
    if text is None:
        files.tree.unlink()
    else:
        files.write(text)
    assert files.polls(4) == []
    files.write(WAIT)
    assert leaf(files.edit()) == "wait"


def test_a_file_that_stays_away_is_told_once_and_may_come_back(files: Files) -> None:
    files.tree.unlink()
    assert "cannot be read: No such file" in messages(files.edit())
    assert files.polls(10) == []
    files.write(WALK)
    edit = files.edit()
    assert (edit.executor, edit.problems) == (None, ())
    files.write(WAIT)
    assert leaf(files.edit()) == "wait"


def test_a_file_that_another_one_is_renamed_over_is_an_edit(files: Files) -> None:
    other = files.tree.with_suffix(".swp")
    other.write_text(WAIT, encoding="utf-8")
    other.rename(files.tree)
    assert leaf(files.edit()) == "wait"


def test_a_file_that_is_written_while_it_is_loaded_counts_when_it_is_written(files: Files) -> None:
    files.write(WAIT)
    half = [BROKEN]  # a tree that is loaded twice: before it is written, and after it

    def write_half() -> None:
        if half:
            files.write(half.pop())

    files.while_loading = write_half
    assert files.polls(2) == []
    files.write(WALK + "# again\n")
    assert leaf(files.edit()) == "walk"


def test_a_broken_tree_is_told_once_with_every_mistake_and_a_fix_is_loaded(files: Files) -> None:
    files.write(BROKEN + "extra: 1\n")
    text = messages(files.edit())
    assert "project/trees/mine.yaml:3:20: " in text and "did you mean 'walk'?" in text
    assert "project/trees/mine.yaml:4:1: " in text
    assert files.polls(10) == []
    (files.root / "trees/other.yaml").write_text("nothing", encoding="utf-8")
    assert files.polls(10) == []
    files.write(WAIT)
    assert leaf(files.edit()) == "wait"


def test_another_mistake_is_told_and_an_undone_edit_too(files: Files) -> None:
    files.write(BROKEN)
    assert "'wak'" in messages(files.edit())
    files.write(BROKEN.replace("wak", "wai"))
    assert "'wai'" in messages(files.edit())
    files.write(WALK)
    edit = files.edit()
    assert (edit.executor, edit.problems) == (None, ())
    files.write(BROKEN)
    assert "'wak'" in messages(files.edit())


def test_an_edited_skill_of_the_tree_is_an_edit(files: Files) -> None:
    source = files.skill.read_text(encoding="utf-8")
    files.skill.write_text(source.replace('"walking"', '"strolling"'), encoding="utf-8")
    edit = files.edit()
    assert edit.files == ("project/skills/mine.py",)
    assert leaf(edit) == "walk"
    files.skill.write_text("1/0\n", encoding="utf-8")
    assert "skills/mine.py:1:1: error: the skill file cannot be imported: ZeroDivisionError" in messages(files.edit())


def test_a_skill_that_comes_to_stand_before_one_of_the_tree_is_an_edit(files: Files) -> None:
    mine = files.root / "skills" / "walks.py"
    files.write(WALK.replace("walk", "idle"))
    assert leaf(files.edit()) == "idle"
    mine.write_text(
        "from humanoid_bt.decision.skill import Skill, Status\n\n\nclass Idle(Skill):\n    def update(self):\n"
        "        return self.running('mine')\n",
        encoding="utf-8",
    )
    edit = files.edit()
    assert edit.executor is not None
    assert edit.executor.tree.nodes[-1].behaviour.update.__module__.endswith("walks")
    mine.unlink()
    edit = files.edit()
    assert edit.executor is not None
    assert edit.executor.tree.nodes[-1].behaviour.update.__module__.endswith("idle")


def test_what_the_tree_does_not_use_is_no_edit(files: Files) -> None:
    (files.root / "skills/more.py").write_text("x = 1\n", encoding="utf-8")
    (files.root / "trees/wait.yaml").write_text(WALK, encoding="utf-8")
    assert files.polls(10) == []


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ("robot: other\n", "mine.yaml:1:8: error: no robot named 'other'"),
        ("scene: ball_on_stand\n", "mine.yaml:1:8: error: the scene cannot change during a run"),
    ],
)
def test_another_robot_or_scene_is_refused(files: Files, header: str, says: str) -> None:
    files.write(header + WALK)
    assert says in messages(files.edit())


def test_a_parameter_that_was_set_and_vanished_is_a_mistake(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    files = Files(tmp_path)
    text = "format: 1\nparameters: {long: 1.0}\nroot:\n  emergency_stop: {wait: {duration: $long}}\n"
    files.write(text)
    files._options = {"parameters": {"long": "2"}}
    files.edits = files.watched()
    files.write(text.replace("long", "time"))
    assert "no parameter 'long'" in messages(files.edit())


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ("raise KeyError('arm')", "the node 'mine/emergency_stop/walk' raised KeyError: 'arm'"),
        ("raise SystemExit", "raised SystemExit"),
    ],
)
def test_a_tree_that_cannot_be_set_up_is_a_broken_edit(files: Files, what: str, says: str) -> None:
    source = files.skill.read_text(encoding="utf-8")
    head = '"""Walk ahead for ever, and raise after a while if asked to."""\n'
    files.skill.write_text(source.replace(head, head + CHOOSY.format(what=what)), encoding="utf-8")
    text = messages(files.edit())
    assert says in text and "skills/mine.py" in text
    assert files.polls(10) == []
    files.skill.write_text(source, encoding="utf-8")
    assert files.edit().problems == ()


def test_an_edited_subtree_is_an_edit_and_a_broken_one_is_told_at_its_place(files: Files) -> None:
    part = files.root / "parts" / "part.yaml"
    part.parent.mkdir()
    part.write_text("format: 1\nsubtree: true\nroot: walk\n", encoding="utf-8")
    files.write("format: 1\nroot:\n  emergency_stop: {subtree: {tree: ../parts/part.yaml}}\n")
    assert leaf(files.edit()) == "walk"
    part.write_text("format: 1\nsubtree: true\nroot: {wak: }\n", encoding="utf-8")
    edit = files.edit()
    assert edit.files == ("project/parts/part.yaml",)
    assert "did you mean 'walk'?" in messages(edit)
    assert edit.problems[0].place is not None and edit.problems[0].place.file.endswith("parts/part.yaml")
    part.write_text("format: 1\nsubtree: true\nroot: {walk: {name: stroll}}\n", encoding="utf-8")
    assert leaf(files.edit()) == "stroll"


def test_a_file_that_the_edited_tree_comes_to_use_is_an_edit(files: Files) -> None:
    part = files.root / "trees" / "parts" / "part.yaml"
    part.parent.mkdir()
    files.write("format: 1\nroot:\n  emergency_stop: {subtree: {tree: ./parts/part.yaml}}\n")
    assert "no tree file" in messages(files.edit())
    part.write_text("format: 1\nroot: {wak: }\n", encoding="utf-8")
    assert "did you mean 'walk'?" in messages(files.edit())
    part.write_text("format: 1\nroot: walk\n", encoding="utf-8")
    assert leaf(files.edit()) == "walk"


def test_a_comment_that_allows_what_it_cannot_allow_is_a_mistake(files: Files) -> None:
    files.write(WALK.replace("walk", "walk  # allow no-time-limit"))
    assert "reason" in messages(files.edit())
