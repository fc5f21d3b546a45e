"""``estop``, ``reset``, ``status`` against the folder of a run that this process plays."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from humanoid_bt.cli import main
from humanoid_bt.core.messages import Mode, State
from humanoid_bt.link import run_folder
from humanoid_bt.link.run_folder import RunFolder, RunInfo
from humanoid_bt.link.wire import encode_state
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.timing import Timing
from tests.tree.helpers import make_state


@pytest.fixture(autouse=True)
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where runs live: not where those of a real robot do."""
    root = tmp_path / "runs"
    monkeypatch.setattr(run_folder, "default_root", lambda: root)
    return root


class Played:
    """A run whose control is played by a thread."""

    def __init__(self, tree: str, refusal: str = "") -> None:
        file, recording = Path("trees", f"{tree}.yaml").absolute(), Path("runs", f"{tree}.rrd").absolute()
        self.folder = RunFolder.create(RunInfo(tree, "humanoid", "empty", str(file), str(recording)))
        channels.create_channels(self.folder)
        self.states = channels.writer(self.folder, "state")
        self.estop = channels.estop(self.folder)
        self.tree = tree
        self.refusal = refusal
        self.mode = Mode.RUN
        self.tell(make_state(1.0))
        self.hangs = threading.Event()
        self.ends = False  # with its first stop
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._control)
        self._thread.start()

    def tell(self, state: State) -> None:
        sources = {"base": f"{self.tree}/emergency_stop/approach"}
        self.states.write(encode_state(dataclasses.replace(state, command_sources=sources)))

    def _control(self) -> None:
        while not self._over.wait(0.001):
            if not self.hangs.is_set() and self.estop.poll():
                while (request := self.estop.reset_request) is not None:
                    self.estop.answer(request.ticket, not self.refusal, self.refusal)
                raised = self.estop.raised
                mode = Mode.EMERGENCY_STOP if raised else Mode.RUN
                reason, source = (raised.reason, raised.source) if raised else ("", "")
                self.tell(make_state(2.0, mode, reason, source))
                if self.ends and raised:
                    self.folder.close()

    @property
    def stopped(self) -> bool:
        """Whether its control knows, or can know, of the e-stop."""
        while self.estop.poll():
            pass
        return self.estop.raised is not None

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        self.folder.close()


@pytest.fixture
def one() -> Iterator[Played]:
    played = Played("fetch")
    yield played
    played.close()


@pytest.fixture
def other() -> Iterator[Played]:
    played = Played("stand", refusal="the robot is falling: its base is low")
    yield played
    played.close()


@pytest.mark.parametrize("command", ["estop", "reset", "status"])
def test_without_a_robot_they_say_so(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command]) == 2
    assert capsys.readouterr().err.startswith("error: no robot is running")


def test_for_programs_no_run_is_an_empty_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["status", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == []


def test_estop_stops_and_reset_lets_go(one: Played, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["estop", "--reason", "in the way"]) == 0
    assert "fetch on humanoid" in (out := capsys.readouterr().out)
    assert "emergency stop after" in out
    assert one.estop.raised is not None
    assert one.estop.raised.source.startswith("humanoid-bt estop (")
    assert main(["estop"]) == 0
    assert "since before: in the way" in capsys.readouterr().out
    assert main(["reset"]) == 0
    assert capsys.readouterr().out.startswith("reset: in the way (humanoid-bt estop (")


def test_a_run_that_a_stop_ends_is_told_by_its_name(one: Played, capsys: pytest.CaptureFixture[str]) -> None:
    one.ends, name = True, one.folder.info.run_id
    assert main(["estop"]) == 0
    told = capsys.readouterr().out
    assert told.startswith(f"fetch on humanoid, realtime ({name}): emergency stop after ")
    assert told.endswith(" ms, which ended the run\n")


def test_a_run_is_told_of_that_goes_while_it_is_asked_who_lives(
    one: Played, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    living = run_folder._living

    def gone_meanwhile(folder: Path) -> frozenset[str]:
        if one.stopped:
            one.folder.close()
        return living(folder)

    monkeypatch.setattr(run_folder, "_living", gone_meanwhile)
    assert main(["estop"]) == 0
    assert "emergency stop after" in capsys.readouterr().out


def _lose_ring(folder: Path) -> None:
    (folder / "state").unlink()


def _open_to_others(folder: Path) -> None:
    folder.chmod(0o755)
    folder.parent.chmod(0o755)
    for file in folder.iterdir():
        file.chmod(0o644)


def _lose_meta(folder: Path) -> None:
    (folder / "run.json").unlink()


def _break_meta(folder: Path) -> None:
    (folder / "run.json").write_text("{")


@pytest.mark.parametrize(
    ("damage", "code", "said"),
    [
        (_lose_ring, 4, "the e-stop is raised, but whether the robot stopped cannot be seen: "),
        (_open_to_others, 4, "is not a private file of this user"),
        (_lose_meta, 0, "a run that does not say what it is"),
        (_break_meta, 0, "emergency stop after"),
    ],
)
def test_estop_is_raised_whatever_else_is_damaged(
    one: Played, damage: Callable[[Path], None], code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    damage(one.folder.folder)
    assert main(["estop"]) == code
    assert said in "".join(capsys.readouterr())
    assert one.stopped


def test_without_its_log_nothing_is_stopped_and_that_is_told(one: Played, capsys: pytest.CaptureFixture[str]) -> None:
    (one.folder.folder / "estop").unlink()
    assert main(["estop"]) == 4
    assert f"({one.folder.info.run_id}): not stopped: " in capsys.readouterr().err


def test_what_is_left_of_a_dead_run_is_no_robot(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = RunFolder.create(RunInfo("fetch", "humanoid"))
    channels.create_channels(folder)
    (folder.folder / "run.json").write_text("{")
    assert main(["estop"]) == 2
    assert capsys.readouterr().err.startswith("error: no robot is running")


def test_each_robot_is_told_its_own_time(
    one: Played, other: Played, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("humanoid_bt.cli.estop._TIMEOUT", 0.4)
    one.hangs.set()
    assert main(["estop"]) == 4
    told = capsys.readouterr()
    assert "fetch on humanoid" in told.err and "did not show within 0.4 s" in told.err
    (stopped,) = [line for line in told.out.splitlines() if line.startswith("stand on humanoid")]
    assert float(stopped.partition(" after ")[2].split()[0]) < 400


def test_a_run_is_named_by_the_beginning_of_its_id(
    one: Played, other: Played, capsys: pytest.CaptureFixture[str]
) -> None:
    ids = [played.folder.info.run_id for played in (one, other)]
    assert main(["estop", "--run", ids[0][:-1]]) == 0
    assert one.stopped and other.estop.raised is None
    assert main(["status", "--run", "2"]) == 2
    assert "2 runs begin with '2'" in capsys.readouterr().err


def test_a_robot_that_is_not_stopped_needs_no_reset(one: Played, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reset"]) == 0
    assert capsys.readouterr().out == "nothing to reset: the robot is not stopped\n"


def test_a_refused_reset_says_why(other: Played, capsys: pytest.CaptureFixture[str]) -> None:
    main(["estop"])
    assert main(["reset"]) == 3
    assert capsys.readouterr().err == "refused: the robot is falling: its base is low\n"


def test_a_protective_stop_is_not_reset(one: Played, capsys: pytest.CaptureFixture[str]) -> None:
    one.tell(make_state(1.0, Mode.PROTECTIVE_STOP, "decision silent", "supervisor"))
    assert main(["reset"]) == 3
    assert "a protective stop ends when its cause does: decision silent (supervisor)" in capsys.readouterr().err


def test_of_several_all_are_stopped_and_one_is_reset(
    one: Played, other: Played, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["estop"]) == 0
    assert "2 robots are running: all of them are stopped" in capsys.readouterr().out
    assert one.estop.raised and other.estop.raised
    assert main(["reset"]) == 2
    assert (
        f"humanoid-bt reset --run {one.folder.info.run_id}   # fetch on humanoid, realtime" in capsys.readouterr().err
    )
    assert main(["status"]) == 0
    shown = capsys.readouterr().out
    assert all(played.folder.info.run_id in shown for played in (one, other))
    assert main(["reset", "--run", one.folder.info.run_id]) == 0
    assert main(["reset", "--run", "none"]) == 2


def test_status_shows_a_robot_in_60_columns(one: Played, capsys: pytest.CaptureFixture[str]) -> None:
    told = {"time": 0.8, "node": "fetch/emergency_stop/approach", "feedback": "1.2 m to go", "tick_rate": 49.96}
    seen = {"percepts": {"target": 0.05}, "unseen": {"cup": "hidden"}}
    channels.writer(one.folder, "status").write(json.dumps({**told, **seen}).encode())
    channels.writer(one.folder, "timing").write(Timing(cycles=1000, missed=2, late_p99=40.5).to_bytes())
    assert main(["status"]) == 0
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 60
    shown = " ".join(out.split())
    for text in (
        f"run {one.folder.info.run_id} tree fetch on humanoid in empty, realtime",
        "file trees/fetch.yaml recording runs/fetch.rrd",
        "mode run",
        "1.2 m to go",
        "50.0 Hz",
        "2 deadlines missed",
        "target: 0.25 s old",
        "cup: never seen, hidden",
    ):
        assert text in shown
    assert main(["status", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert (found["file"], found["recording"]) == (one.folder.info.file, one.folder.info.recording)
    assert found["leases"] == {"base": "fetch/emergency_stop/approach"}
    assert found["percepts"] == {"target": 0.25}
    assert found["unseen"] == {"cup": "hidden"}
    assert found["processes"]["decision"]["alive"]


def test_a_rate_of_long_ago_is_not_told_as_one_of_now(one: Played, capsys: pytest.CaptureFixture[str]) -> None:
    told = {"time": 0.8, "node": "fetch/approach", "tick_rate": 50.0}
    ring = channels.writer(one.folder, "status")
    for told_at, rate, silent in ((0.0, None, True), (-1000.0, None, True), (time.monotonic() + 1e3, 50.0, False)):
        ring.write(json.dumps({**told, "told_at": told_at}).encode())
        assert main(["status", "--json"]) == 0
        (found,) = json.loads(capsys.readouterr().out)
        assert found["tick_rate"] == rate
        assert (found["silent"] is not None) is silent
    ring.write(json.dumps({**told, "told_at": time.monotonic() - 65.0}).encode())
    assert main(["status"]) == 0
    assert "tree rate  no tick for 65." in capsys.readouterr().out


def test_a_run_that_has_told_nothing_yet_is_starting(capsys: pytest.CaptureFixture[str]) -> None:
    folder = RunFolder.create(RunInfo("fetch", "humanoid"))
    assert main(["status"]) == 0
    assert "starting" in capsys.readouterr().out
    folder.close()


def test_they_import_nothing_heavy() -> None:
    code = (
        "import sys; from humanoid_bt.cli import main; main(['estop', '--run', 'none']); import humanoid_bt.cli.remote;"
        "print({'mujoco', 'mink', 'rerun', 'py_trees', 'rich', 'numpy', 'yaml'} & set(sys.modules));"
        "import humanoid_bt.realtime.status;"
        "print({'mujoco', 'mink', 'rerun', 'py_trees', 'rich', 'yaml'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["set()", "set()"]


def test_status_removes_what_a_killed_run_has_left(root: Path) -> None:
    killed = RunFolder.create(RunInfo("fetch", "humanoid"))  # decision was killed before it started control
    killed.leave()
    assert main(["status"]) == 2
    assert not killed.folder.exists()
