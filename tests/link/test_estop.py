from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from humanoid_bt.link import estop as module
from humanoid_bt.link.estop import EStop, Raised, ResetAnswer
from humanoid_bt.link.heartbeat import Heartbeat
from humanoid_bt.link.segment import LinkError
from tests.link.conftest import Start, first_line

PROCESSES, RAISES = 4, 100


@pytest.fixture
def control(folder: Path) -> EStop:
    return EStop.create(folder / "estop")


@pytest.fixture
def other(control: EStop, folder: Path) -> EStop:
    return EStop.open(folder / "estop")


def test_a_raise_is_seen_once_by_poll_and_stands(control: EStop, other: EStop) -> None:
    assert not control.poll()
    assert control.raised is None
    other.raise_("key", "the robot is too close")
    assert control.poll()
    assert not control.poll()
    assert control.raised == Raised("key", "the robot is too close", 1)


def test_the_first_cause_is_told_and_all_are_counted(control: EStop, other: EStop) -> None:
    other.raise_("key", "first")
    control.raise_("tree", "second")
    assert control.poll()
    assert control.raised == Raised("key", "first", 2)
    assert other.poll()
    assert other.raised == control.raised


def test_the_same_cause_is_not_entered_again_while_it_stands(control: EStop, other: EStop, folder: Path) -> None:
    for _ in range(100):
        other.raise_("tree", "held " * 200)
    size = (folder / "estop").stat().st_size
    assert control.poll()
    assert control.raised is not None
    assert control.raised.count == 1
    ticket = control.request_reset("cli")
    other.raise_("tree", "held " * 200)
    control.answer(ticket, True)
    assert (folder / "estop").stat().st_size > size
    assert control.raised is not None, "it was raised again after the reset was asked for"


def test_who_joins_later_sees_what_stands(control: EStop, folder: Path) -> None:
    control.raise_("key", "stop")
    late = EStop.open(folder / "estop")
    assert late.poll()
    assert late.raised == Raised("key", "stop", 1)


def test_only_an_accepted_reset_clears_it(control: EStop, other: EStop) -> None:
    other.raise_("key", "stop")
    ticket = other.request_reset("cli")
    assert other.answer_to(ticket) is None
    assert control.poll()
    request = control.reset_request
    assert request is not None
    assert (request.ticket, request.source) == (ticket, "cli")
    control.answer(ticket, False, "the robot has fallen")
    assert control.reset_request is None
    assert control.raised is not None
    assert other.poll()
    assert other.answer_to(ticket) == ResetAnswer(False, "the robot has fallen")
    assert other.raised is not None

    ticket = other.request_reset("cli")
    assert control.poll()
    control.answer(ticket, True)
    assert control.raised is None
    assert other.poll()
    assert other.answer_to(ticket) == ResetAnswer(True, "")
    assert other.raised is None


def test_a_reset_does_not_clear_what_was_raised_after_it_was_asked_for(control: EStop, other: EStop) -> None:
    other.raise_("key", "first")
    ticket = other.request_reset("cli")
    other.raise_("tree", "later")
    assert control.poll()
    control.answer(ticket, True)
    assert control.raised == Raised("tree", "later", 1)


def test_requests_are_answered_one_by_one(control: EStop, other: EStop) -> None:
    first, second = other.request_reset("cli"), control.request_reset("tree")
    assert control.poll()
    for ticket in (first, second):
        request = control.reset_request
        assert request is not None
        assert request.ticket == ticket
        control.answer(ticket, True)
    control.answer(first, False, "twice")
    assert control.reset_request is None
    assert other.poll()
    assert other.answer_to(first) == ResetAnswer(True, "")


def test_long_texts_are_cut_between_characters(control: EStop) -> None:
    control.raise_("ü" * 500, "größe " * 500)
    control.poll()
    assert control.raised is not None
    assert control.raised.source == "ü" * 80
    assert control.raised.reason.startswith("größe größe")


def test_an_entry_whose_writer_died_before_its_hint_is_found(control: EStop, other: EStop) -> None:
    while control.poll():
        pass
    hint = other._words[module._HINT]
    other.raise_("tree", "last words")
    other._words[module._HINT] = hint  # as if killed between the entry and the hint
    assert any(control.poll() for _ in range(module._AUDIT_POLLS))
    assert control.raised == Raised("tree", "last words", 1)


def test_a_raise_without_room_for_words_still_stops(
    control: EStop, other: EStop, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    other.raise_("tree", "never written")
    with pytest.raises(LinkError, match="No space left"):
        other.request_reset("cli")
    monkeypatch.undo()
    assert control.poll()
    assert control.raised == Raised("unknown", "raised without room for its reason", 1)
    control.answer(other.request_reset("cli"), True)
    assert control.raised is None
    assert control.poll()
    assert not any(control.poll() for _ in range(2 * module._AUDIT_POLLS))


def test_an_unreadable_entry_stops(control: EStop, folder: Path) -> None:
    with (folder / "estop").open("ab") as file:
        file.write(os.urandom(512))
    assert any(control.poll() for _ in range(module._AUDIT_POLLS))
    assert control.raised == Raised("unknown", "an entry of the e-stop is unreadable", 1)


def test_a_burst_is_read_in_bounded_pieces(control: EStop, other: EStop) -> None:
    for index in range(200):
        other.raise_("tree", f"cause {index}")
    polls = 0
    while control.poll():
        polls += 1
        assert control.raised is not None
        assert control.raised.reason == "cause 0"
    assert polls == 4
    assert control.raised is not None
    assert control.raised.count == 200


def test_nothing_raised_by_several_processes_at_once_is_lost(control: EStop, folder: Path, start: Start) -> None:
    gate = Heartbeat.create(folder / "gate")
    processes = [
        start("raise_estop", folder / "estop", folder / "gate", f"process {index}", RAISES)
        for index in range(PROCESSES)
    ]
    for process in processes:
        first_line(process)
    gate.beat()
    while any(process.poll() is None for process in processes):
        control.poll()
    while control.poll():
        pass
    assert [process.returncode for process in processes] == [0] * PROCESSES
    assert control.raised is not None
    assert control.raised.reason == "cause 0"
    assert control.raised.count == PROCESSES * RAISES


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGSTOP])
def test_a_process_killed_or_stopped_while_raising_is_in_nobodys_way(
    control: EStop, folder: Path, start: Start, end: signal.Signals
) -> None:
    Heartbeat.create(folder / "gate").beat()
    for index in range(6):
        process = start("raise_estop", folder / "estop", folder / "gate", "doomed", 10**9)
        first_line(process)
        begun = control.raised.count if control.raised else 0
        while control.raised is None or control.raised.count < begun + 20:
            control.poll()
        process.send_signal(end)
        control.raise_("key", f"after {index}")
        while control.poll():
            pass
        process.kill()
        process.wait()
    ticket = control.request_reset("cli")
    control.poll()
    control.answer(ticket, True)
    assert control.raised is None
