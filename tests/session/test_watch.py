"""Runs whose tree is edited, in lockstep: files are looked at after every tick, so nothing depends on a clock."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from humanoid_bt.session.edits import Edit, EditSource
from humanoid_bt.session.session import Session
from humanoid_bt.session.watch import Watch
from tests.projects import make_project
from tests.record.helpers import rows
from tests.session.helpers import Ran, Told, play

WALK = "format: 1\nroot:\n  emergency_stop: walk\n"
WAIT = "format: 1\nroot:\n  emergency_stop: {wait: {duration: 0.4}}\n"
STAND = "format: 1\nroot:\n  emergency_stop: {pause: {duration: 9}}\n"
BROKEN = "format: 1\nroot:\n  emergency_stop: {wak: }\n"

Script = dict[int, Callable[[], object]]


class InStep:
    """Looks for edits after every tick instead of in a thread of its own."""

    def __init__(self, edits: EditSource) -> None:
        self.poll = edits.poll

    def __enter__(self) -> InStep:
        return self

    def __exit__(self, *_: object) -> None:
        pass


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return make_project(tmp_path / "project")


def tree(root: Path, text: str) -> Callable[[], object]:
    """Return what writes the tree ``mine``."""
    return lambda: (root / "trees" / "mine.yaml").write_text(text, encoding="utf-8")


def watched(
    root: Path, first: str, script: Callable[[Session], Script], duration: float = 6.0, recording: Path | None = None
) -> Ran:
    """Run the tree ``mine`` and do something in some of its ticks, counted from 1; "end" ends the run."""
    tree(root, first)()
    told = Told()
    record = recording or False
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("humanoid_bt.session.drive.Watch", InStep)
        run = Session(
            "mine",
            workspace=root,
            duration=duration,
            watch=True,
            pace=1e9,
            record=record,
            camera=False,
            listener=told,
        )
    actions, tick = script(run), 0

    def ask() -> str:
        nonlocal tick
        tick += 1
        return str(actions[tick]() or "") if tick in actions else ""

    return Ran(run, play(run, lambda: "Ctrl-C" if ask() == "end" else ""), told, recording)


def edited(root: Path, *edits: tuple[int, str]) -> Callable[[Session], Script]:
    """Return a script: tick -> text of the tree, or "end"."""
    return lambda _: {tick: (lambda: "end") if text == "end" else tree(root, text) for tick, text in edits}


def started(ran: Ran, name: str) -> list[float]:
    """Return when nodes of a name began to run."""
    return [c["time"] for c in ran.report.timeline if c["path"].endswith(f"/{name}") and c["status"] == "RUNNING"]


def texts(ran: Ran) -> list[str]:
    return [text for _, _, text in ran.told.events]


def test_an_edited_tree_starts_when_the_robot_stands(root: Path) -> None:
    ran = watched(root, WALK, edited(root, (75, WAIT)), duration=4.5)
    (swap,) = ran.report.reloads
    assert (swap.outcome, swap.files, swap.time) == ("reloaded", ["project/trees/mine.yaml"], 1.52)
    assert (1.52, "info", "project/trees/mine.yaml changed: reloaded (2 nodes)") in ran.told.events
    halted = [c for c in ran.report.timeline if c["feedback"] == "halted: replaced by an edited tree"]
    assert [(c["time"], c["path"]) for c in halted] == [
        (1.52, "mine/emergency_stop/walk"),
        (1.52, "mine/emergency_stop"),
    ]
    (began,) = started(ran, "wait")
    assert 0.3 < began - swap.time < 5.0  # it walked, and a step takes a while to end
    assert (ran.report.fell, ran.report.stops) == (False, [])
    assert [shown.nodes[-1].name for shown in ran.told.shown] == ["wait"]
    assert ran.session.tree is ran.told.shown[0]


@pytest.mark.trials
def test_the_robot_is_held_between_two_trees_and_commands_are_counted_on(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands = []
    script = edited(root, (25, WALK + "# again\n"), (160, "end"))

    def listen(run: Session) -> Script:
        submit = run.engine.submit
        monkeypatch.setattr(run.engine, "submit", lambda command: (commands.append(command), submit(command)))
        return script(run)

    ran = watched(root, WALK, listen, duration=12.0)
    first, second = started(ran, "walk")
    between = [command for command in commands if 0.52 <= command.stamp < second - 1e-9]
    assert first == 0.0
    assert len(between) == round((second - 0.52) / 0.02)
    assert all(not command.targets for command in between)
    assert [command.sequence for command in commands][:159] == list(range(159))  # until the run ends
    assert next(c for c in commands if c.stamp == pytest.approx(second)).sources == {"base": "mine/emergency_stop/walk"}
    assert ran.report.stops == []


def test_a_broken_edit_is_told_and_the_old_tree_goes_on(root: Path) -> None:
    ran = watched(root, WALK, edited(root, (20, BROKEN), (35, WALK), (50, BROKEN)), duration=1.2)
    told = [(level, text) for _, level, text in ran.told.events if "mine.yaml changed" in text]
    assert [level for level, _ in told] == ["error", "info", "error"]
    assert told[0][1].startswith(
        "project/trees/mine.yaml changed: 1 mistake, the old tree goes on\nproject/trees/mine.yaml:3:20: error: "
    )
    assert "did you mean 'walk'?" in told[0][1]
    assert [reload.outcome for reload in ran.report.reloads] == ["refused", "unchanged", "refused"]
    assert "did you mean 'walk'?" in ran.report.reloads[0].problems[0]
    assert started(ran, "walk") == [0.0]
    assert ran.told.shown == []


def test_after_its_end_the_robot_waits_for_an_edit(root: Path) -> None:
    again = WAIT.replace("0.4", "0.2")
    ran = watched(root, WAIT, edited(root, (50, BROKEN), (75, again), (150, "end")), duration=20.0)
    assert texts(ran).count("the tree ended: success; waiting for an edit") == 2
    assert any("1 mistake, the robot waits for another edit" in text for text in texts(ran))
    assert [round(c["time"], 2) for c in ran.report.timeline if c["path"] == "mine/emergency_stop/wait"] == [
        0.0,
        0.4,
        1.52,  # the old tree takes the status INVALID, ...
        1.54,
        1.74,
    ]
    assert (ran.report.outcome, ran.report.exit_code) == ("success", 0)
    assert ran.report.reason.startswith("wait: ")
    assert ran.report.sim_time == pytest.approx(2.98)


def test_a_run_that_waits_for_an_edit_ends_with_its_duration_as_its_tree_did(root: Path) -> None:
    give_up = "format: 1\nroot:\n  emergency_stop: give_up\n"
    ran = watched(root, give_up, edited(root), duration=1.0)
    assert (ran.report.outcome, ran.report.reason) == ("failure", "give_up: the thing is not there")
    assert ran.report.sim_time == pytest.approx(1.0)


@pytest.mark.trials
def test_a_run_that_waits_for_an_edit_waits_for_a_reset_too(root: Path) -> None:
    def press(run: Session) -> Script:
        return {50: lambda: run.raise_estop("pressed", source="button")}

    ran = watched(root, WAIT, press, duration=2.0)
    assert (ran.report.outcome, ran.report.exit_code, ran.report.sim_time) == ("stopped", 3, 2.0)


@pytest.mark.trials
def test_a_tree_that_waits_for_a_reset_can_be_replaced(root: Path) -> None:
    walk = "format: 1\nroot:\n  emergency_stop: walk\n"

    def press(run: Session) -> Script:
        return {
            20: lambda: run.raise_estop("pressed", source="button"),
            100: tree(root, walk + "# again\n"),
            150: lambda: run.request_reset(source="key"),
        }

    ran = watched(root, walk, press, duration=4.0)
    assert ran.report.outcome == "unfinished"
    assert len(started(ran, "walk")) == 2
    assert started(ran, "walk")[1] > 2.9


@pytest.mark.trials
def test_an_old_tree_that_raises_when_it_is_replaced_is_told_and_gone(root: Path) -> None:
    ran = watched(root, "format: 1\nroot:\n  emergency_stop: stubborn\n", edited(root, (20, WAIT), (100, "end")))
    assert any("raised RuntimeError: not now" in text for text in texts(ran))
    assert (ran.report.outcome, ran.report.stops) == ("success", [])


def test_a_discarded_tree_commands_no_more(root: Path) -> None:
    """A skill that keeps commanding from outside of its ticks reaches nobody once its tree is replaced."""
    skills = root / "skills" / "mine.py"
    skills.write_text(skills.read_text(encoding="utf-8") + CLINGING, encoding="utf-8")
    ran = watched(root, "format: 1\nroot:\n  emergency_stop: clinging\n", edited(root, (20, WAIT)), duration=2.0)
    assert ran.report.outcome == "success", ran.report.reason
    assert (ran.report.stops, ran.report.fell) == ([], False)


CLINGING = '''

class Clinging(Skill):
    """Come back to life when halted."""

    resources = ("base",)

    def update(self) -> Status:
        return self.running("clinging")

    def terminate(self, new_status: Status) -> None:
        robot = self.robot
        self.robot.release = lambda: robot.walk_to((3.0, 0.0), 0.0)
'''


def test_a_percept_that_never_comes_is_told_of_an_edited_tree(root: Path) -> None:
    blind = "format: 1\nroot:\n  emergency_stop:\n    watchdog: {percept: ball, max_age: 0.5, walk: }\n"
    ran = watched(root, WALK, edited(root, (20, blind)), duration=2.0)
    assert "the scene 'empty' publishes no percept 'ball' (it publishes none)" in texts(ran)


@pytest.mark.trials
def test_the_hash_covers_the_edits(root: Path) -> None:
    def of(*edits: tuple[int, str]) -> str:
        return watched(root, STAND, edited(root, *edits), duration=0.7).report.trace_hash

    assert of((20, WAIT)) == of((20, WAIT)) != of((21, WAIT))
    assert of((20, BROKEN)) != of()


@pytest.mark.trials
def test_the_recording_follows_the_tree(root: Path, tmp_path: Path) -> None:
    both = "format: 1\nroot:\n  emergency_stop: {sequence: [{wait: {duration: 0.2}}, walk]}\n"
    file = tmp_path / "run.rrd"
    ran = watched(root, WALK, edited(root, (25, both)), duration=4.0, recording=file)
    swap = ran.report.reloads[0].time
    documents = rows(file, "/documents/tree", "TextDocument:text")
    assert [time for time, _ in documents] == [0.0, swap]
    assert (
        "emergency_stop: walk" in documents[0][1][0]
        and "sequence: [{wait: {duration: 0.2}}, walk]" in documents[1][1][0]
    )
    edges = [(time, len(found)) for time, found in rows(file, "/tree/edges", "LineStrips2D:strips")]
    assert {count for time, count in edges if time < swap} == {1}
    assert {count for time, count in edges if time > swap} == {3}
    old = rows(file, "/actions/1-walk", "StateChange:state")
    assert [state for _, (state,) in old] == ["RUNNING", "INVALID"]
    assert old[-1][0] == swap
    assert [state for _, (state,) in rows(file, "/actions/2-wait", "StateChange:state")][:1] == ["RUNNING"]


def test_a_watch_polls_in_a_thread_and_ends_with_the_run() -> None:
    polled = threading.Event()
    edit = Edit(("a.yaml",))

    class Once:
        def poll(self) -> Edit | None:
            assert threading.current_thread() is not threading.main_thread()
            found = None if polled.is_set() else edit
            polled.set()
            return found

    before = threading.active_count()
    with Watch(Once()) as watch:
        assert polled.wait(20)
    assert threading.active_count() == before
    assert (watch.poll(), watch.poll()) == (edit, None)


def test_warnings_that_the_old_tree_did_not_have_are_told(root: Path) -> None:
    unread = WALK.replace("root:", "blackboard: {unread: 1}\nroot:")
    ran = watched(root, WALK, edited(root, (10, unread), (30, unread + "# again\n")), duration=1.0)
    told = [text for _, level, text in ran.told.events if level == "warning" and text.startswith("the edited tree")]
    assert len(ran.report.reloads) == 2
    assert len(told) == 1
    assert "project/trees/mine.yaml:2:14: warning: " in told[0] and "[unused-key]" in told[0]
    assert "no-time-limit" not in told[0]


def test_an_edit_waits_while_the_run_is_paused_and_takes_breakpoints_along(root: Path) -> None:
    def script(run: Session) -> Script:
        breaks: Script = {1: lambda: run.break_at("walk"), 2: lambda: run.break_at("emergency_stop=SUCCESS")}
        return breaks | {3: run.pause, 4: tree(root, WAIT), 30: run.resume, 40: lambda: "end"}

    ran = watched(root, WALK, script)
    (swap,) = ran.report.reloads
    assert 0.6 < swap.time < 0.7
    (gone,) = (text for text in texts(ran) if "is gone" in text)
    assert gone.startswith("the breakpoint at walk is gone: the tree 'mine' has no node 'walk'")
    assert ran.session.breakpoints == ("emergency_stop=SUCCESS",)
