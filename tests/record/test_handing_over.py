"""What decision hands over arrives as it was, at once, and never makes it wait for ever."""

from __future__ import annotations

import io
import os
import pickle
import select
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import BaseTarget, FootPose, HandTarget, Percept
from humanoid_bt.decision.result import Reported
from humanoid_bt.link.table import TableWriter
from humanoid_bt.link.wire import encode_state
from humanoid_bt.perception.track import Track
from humanoid_bt.record import recorder_process, remote_recorder
from humanoid_bt.record.outbox import Outbox, Stuck
from humanoid_bt.record.reading import read_cycles
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.recorder_process import RecorderProcess, _Unhurried
from humanoid_bt.record.remote_recorder import RemoteRecorder
from humanoid_bt.record.sample import decode_call, encode_call, encode_cycles, encode_results, encode_sample
from humanoid_bt.record.tick import Tick
from tests.record.helpers import make_state, make_track
from tests.record.test_parts import LAYOUT

MESSAGE = bytes(range(256)) * 16


@pytest.fixture
def ends() -> Iterator[tuple[socket.socket, socket.socket]]:
    one, other = socket.socketpair()
    with one, other:
        yield one, other


def take(end: socket.socket, size: int) -> bytes:
    taken = b""
    while len(taken) < size:
        taken += end.recv(size - len(taken))
    return taken


def test_a_sample_arrives_bit_for_bit() -> None:
    targets = {"base": BaseTarget(np.array([1.0, 0.1]), 0.3), "left_hand": HandTarget(np.array([0.1, 0.2, 0.7]))}
    state = make_state(1.02, joints=(0.1, 1 / 3, -2.0), footsteps=(("left", FootPose(0.1, 0.2, 0.3)),), targets=targets)
    track = make_track(position=(1.0, 1 / 3, 0.7), confidence=0.9, age=0.1)
    ball = np.array([1 / 3, 0.0, 0.9])
    method, arguments = decode_call(io.BytesIO(encode_sample(Tick(state), {"target": track}, {"ball": ball}, {"ball"})))
    assert method == "sample"
    again, tracks, objects, hidden, tick = arguments
    assert encode_state(again) == encode_state(state) == encode_state(Tick.decode(tick).state)
    seen = tracks["target"]
    assert (seen.name, seen.stamp, seen.confidence, seen.age) == ("target", track.stamp, 0.9, 0.1)
    assert seen.position_world.tolist() == track.position_world.tolist()
    assert seen.distance == track.distance
    assert objects["ball"].tolist() == ball.tolist()
    assert hidden == ("ball",)


def test_the_box_around_a_solid_thing_arrives() -> None:
    size = np.array([0.6, 1 / 3, 0.7])
    table = Track(Percept("table", 0.0, np.zeros(3), 0.9, size), np.ones(3), 0.1, make_state(1.0), 0.3)
    _, arguments = decode_call(io.BytesIO(encode_sample(Tick(make_state(1.0)), {"table": table}, {}, ())))
    seen = arguments[1]["table"]
    assert seen.size.tolist() == size.tolist()
    assert seen.heading_world == 0.3


def test_servo_cycles_arrive_bit_for_bit_and_what_comes_after_them() -> None:
    plans, cycles = np.empty((0, 3)), np.arange(8.0).reshape(2, 4) / 3
    whole = b"".join(encode_cycles(plans, cycles))
    source = io.BytesIO(whole + encode_call("event", 1.0, "info", "something") + whole[:-4])
    method, arguments = decode_call(source)
    assert (method, [rows.tolist() for rows in arguments]) == ("cycles", [[], cycles.tolist()])
    assert decode_call(source)[0] == "event"
    with pytest.raises(EOFError):
        decode_call(source)


def test_results_arrive_as_they_were_reported() -> None:
    results = (Reported("hand_error", 1 / 3, "m"), Reported("what", "cup", ""))
    method, (time, path, arrived) = decode_call(io.BytesIO(encode_results(1.0, "reach", results)))
    assert (method, time, path) == ("results", 1.0, "reach")
    assert [str(one) for one in arrived] == [str(one) for one in results]
    assert tuple(arrived) == results


def test_a_call_that_is_cut_short_is_none() -> None:
    whole = encode_call("event", 1.0, "info", "something")
    source = io.BytesIO(whole + whole[:-4])
    assert decode_call(source) == ("event", (1.0, "info", "something"))
    with pytest.raises((EOFError, pickle.UnpicklingError)):
        decode_call(source)


def test_what_is_not_taken_yet_stays_and_keeps_its_order(ends: tuple[socket.socket, socket.socket]) -> None:
    one, other = ends
    outbox = Outbox(one, 0.0)
    count = 0
    while not outbox.size:
        outbox.put(MESSAGE)
        count += 1
    outbox.put(MESSAGE[::-1])
    assert outbox.size > len(MESSAGE)
    under_way = count * len(MESSAGE) + len(MESSAGE) - outbox.size
    found = take(other, under_way)
    outbox.push()
    assert outbox.size == 0
    found += take(other, (count + 1) * len(MESSAGE) - under_way)
    assert found == count * MESSAGE + MESSAGE[::-1]


def test_who_waits_gives_up_on_one_that_takes_nothing(ends: tuple[socket.socket, socket.socket]) -> None:
    outbox = Outbox(ends[0], 0.01)
    with pytest.raises(Stuck):
        while True:
            outbox.put(MESSAGE)


def test_one_that_is_gone_is_an_error(ends: tuple[socket.socket, socket.socket]) -> None:
    one, other = ends
    other.close()
    with pytest.raises(OSError, match="pipe"):
        Outbox(one, 0.0).put(MESSAGE)


@pytest.fixture
def recorder(monkeypatch: pytest.MonkeyPatch) -> Iterator[RemoteRecorder]:
    """One that is never waited for, and whose process takes nothing."""

    def start(end: socket.socket, _core: int | None) -> subprocess.Popen[bytes]:
        return subprocess.Popen(["sleep", "60"], stdin=end.fileno())

    monkeypatch.setattr(remote_recorder, "_start", start)
    monkeypatch.setattr(remote_recorder, "_END_TIMEOUT", 0.1)  # it will not end
    with RemoteRecorder(waits=False) as recorder:
        yield recorder


def test_a_pause_of_decision_does_not_count_as_the_recorders(recorder: RemoteRecorder) -> None:
    for at in (0.0, 0.02):
        recorder.sample(Tick(make_state(at)), {}, {})
    recorder._written = 0.0  # the last batch is not written yet
    for at in (10.0, 10.02):
        recorder.sample(Tick(make_state(at)), {}, {})
    assert recorder.take_news() == []
    assert recorder._handed == 10.02


def test_a_recorder_that_writes_nothing_is_told_once(recorder: RemoteRecorder) -> None:
    for tick in range(600):
        recorder.sample(Tick(make_state(0.02 * tick)), {}, {})
    ((level, text),) = recorder.take_news()
    assert (level, text.partition(":")[0]) == ("error", "the recorder is more than 5 s behind")
    assert recorder._handed == pytest.approx(5.0, abs=0.03)


def test_a_forked_child_lets_go_of_the_recorder(recorder: RemoteRecorder) -> None:
    child = os.fork()
    if not child:
        os._exit(0 if recorder._end.fileno() == -1 else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_a_recorder_that_is_ended_as_it_loads_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    telling, told = os.pipe()
    loading = tmp_path / "python"
    loading.write_text(f"#!/bin/sh\nexec 3>/proc/{os.getpid()}/fd/{told}\nsleep 60 &\necho >&3\nwait\n")
    loading.chmod(0o755)
    monkeypatch.setattr(remote_recorder.sys, "executable", str(loading))
    recorder = RemoteRecorder(waits=True)
    assert os.read(telling, 1) == b"\n", "it has started something, as libraries do that look for others"
    os.close(told)
    recorder.close()
    assert select.select([telling], [], [], 20)[0] and not os.read(telling, 1), "nobody has the other end any more"
    os.close(telling)


def started(monkeypatch: pytest.MonkeyPatch, script: str) -> RemoteRecorder:
    """Return one whose process is a script of a shell, with its end as standard input."""

    def start(end: socket.socket, _core: int | None) -> subprocess.Popen[bytes]:
        return subprocess.Popen(["sh", "-c", script], stdin=end.fileno(), start_new_session=True)

    monkeypatch.setattr(remote_recorder, "_start", start)
    return RemoteRecorder(waits=True)


def test_how_a_recorder_ended_is_known_though_it_takes_a_moment(monkeypatch: pytest.MonkeyPatch) -> None:
    script = "exec 0<&-; sleep 0.05; exit 3"
    with started(monkeypatch, script) as recorder, pytest.raises(HumanoidBtError, match=r"come up: exit code 3"):
        recorder.open()


def test_a_recorder_that_fails_is_left_to_close_its_file(monkeypatch: pytest.MonkeyPatch) -> None:
    with started(monkeypatch, """echo '["failed", "KeyError: 1"]' >&0; sleep 60""") as recorder:
        assert select.select([recorder._end], [], [], 20)[0]
        recorder.sample(Tick(make_state()), {}, {})
        ((_, text),) = recorder.take_news()
        assert text.startswith("the recorder failed (KeyError: 1)")
        with pytest.raises(subprocess.TimeoutExpired):
            recorder._process.wait(0.05)


def test_while_nothing_comes_there_is_time_for_other_things(ends: tuple[socket.socket, socket.socket]) -> None:
    one, other = ends
    source = _Unhurried(other, lambda: one.sendall(b"x"), lambda: 0.0)
    assert source.readinto(bytearray(10)) == 1


def test_what_comes_in_is_gathered_for_a_while_but_not_at_the_end(ends: tuple[socket.socket, socket.socket]) -> None:
    one, other = ends
    source, buffer = _Unhurried(other, lambda: one.sendall(b"x"), lambda: 0.05), bytearray(100)
    one.sendall(b"first")
    assert source.readinto(buffer) == 5
    one.sendall(b"more")
    assert source.readinto(buffer) > 5  # with what came in meanwhile
    one.sendall(b"last")
    one.close()  # whoever waits from now on writes into what is closed
    assert source.readinto(buffer) == 4
    assert source.readinto(buffer) == 0


def test_what_was_gathered_is_handed_on_though_the_other_end_broke(ends: tuple[socket.socket, socket.socket]) -> None:
    one, other = ends
    source = _Unhurried(other, one.close, lambda: 0.0)
    other.sendall(b"an answer that nobody reads")
    one.sendall(b"last")
    one.close()
    assert source.readinto(bytearray(100)) == 4
    assert source.readinto(bytearray(100)) == 0


@pytest.mark.parametrize("pace", [(True, 0.03), (False, 0.1)], ids=["realtime", "lockstep"])
def test_servo_cycles_are_written_while_decision_is_silent(
    ends: tuple[socket.socket, socket.socket],
    record: Callable[..., Recorder],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    pace: tuple[bool, float],
) -> None:
    follows, after = pace
    monkeypatch.setattr(Recorder, "follows", follows)
    with record() as recorder:
        process = RecorderProcess(ends[1])
        process._recorder, process._saved = recorder, time.monotonic() + 60.0  # it has just saved
        process._obey(recorder, "cycles", (np.zeros((4, LAYOUT.plan.width)), np.zeros((20, LAYOUT.cycle.width))))
        process._idle()
        assert len(read_cycles(tmp_path / "run.rrd").time) == 0
        process._saved = time.monotonic() - after
        process._idle()
        assert len(read_cycles(tmp_path / "run.rrd").time) == 20


def test_what_control_does_after_decision_died_is_recorded_to_its_end(
    ends: tuple[socket.socket, socket.socket],
    record: Callable[..., Recorder],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """However long that takes: who waits for the end of the recording waits for it no longer than a moment."""
    paths = tmp_path / "plans", tmp_path / "cycles"
    LAYOUT.create(*paths)
    plans, cycles = (TableWriter.open(path) for path in paths)
    looks = iter(range(20))

    def control_goes_on(_: float) -> None:
        for _ in range(5):
            cycles.rows[cycles.count % len(cycles.rows)] = cycles.count
            cycles.publish()
        if next(looks) == 19:
            cycles.close()

    clock = SimpleNamespace(monotonic=time.monotonic, sleep=control_goes_on)
    monkeypatch.setattr(recorder_process, "time", clock)
    monkeypatch.setattr(recorder_process, "_ALONE", 1e6)
    monkeypatch.setattr("humanoid_bt.record.recorder._CONTROL_ENDS", 0.0)
    process = RecorderProcess(ends[1])
    process._recorder = record()
    process._obey(process._recorder, "follow", paths)
    ends[0].close()
    process.run()
    plans.close()
    assert len(read_cycles(tmp_path / "run.rrd").time) == 100
