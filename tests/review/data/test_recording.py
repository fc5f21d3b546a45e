"""A recording as tables: everything that the run had, in the units that are written on it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.compute as pc
import pytest

import humanoid_bt as hbt
from humanoid_bt.core.errors import UserError
from humanoid_bt.record.reading import News, read_flight
from humanoid_bt.review import explain as explaining
from humanoid_bt.review import samples
from humanoid_bt.review.columns import TABLES
from humanoid_bt.review.happened import Happened
from humanoid_bt.review.recording import Recording
from humanoid_bt.session.run import run


@pytest.mark.parametrize("name", TABLES)
def test_a_table_has_the_columns_that_are_declared(name: str, recording: Recording) -> None:
    table = recording.table(name)
    assert table.schema.equals(TABLES[name].schema, check_metadata=True)
    table.validate(full=True)
    filled = {c for c in table.column_names if table[c].null_count < table.num_rows}
    if name in ("blackboard", "stops", "inputs", "contacts"):  # the demo has none of them
        assert table.num_rows == 0
    else:
        never = {"heading", "height", "text", "hand_error_left", "hand_error_right"}
        of_hands = {"relative", "axis", *(f"q{part}" for part in "wxyz"), *(f"d{part}" for part in "xyz")}
        never |= {*of_hands, "joints", "speed", "press"} if name == "commands" else set()  # it moves no hand
        if name == "percepts":  # it sees nothing solid, and the tracker tells no more
            never |= {"length", "width", "class", *(f"q{part}" for part in "wxyz")}
            never |= {f"deviation_{axis}" for axis in "xyz"}
        assert table.num_rows and set(table.column_names) - filled <= never


def test_units_are_in_the_schema(recording: Recording) -> None:
    schema = recording.joints(between=(1, 1.1)).schema
    assert schema.field("torque").metadata[b"unit"] == b"Nm"
    assert schema.field("position").metadata[b"description"] == b"measured"


def test_joints_are_what_was_recorded_to_the_bit(file: Path, recording: Recording) -> None:
    flight, table = read_flight(file), recording.joints(rate=1000)
    cycles, plans = flight.cycles(), flight.cycles("plans")
    names = list(cycles.described["position"].labels)
    assert table.num_rows == len(cycles.time) * len(names)
    knee = table.filter(pc.field("joint") == "left_knee")
    place = names.index("left_knee")
    for name in ("position", "velocity", "torque"):
        np.testing.assert_array_equal(knee[name], cycles.columns[name][:, place].astype(np.float32))
    latest = np.searchsorted(plans.time, cycles.time + 1e-6) - 1
    np.testing.assert_array_equal(knee["setpoint"], plans.columns["setpoint"][latest, place].astype(np.float32))


def test_a_window_at_a_rate_is_cut_out_of_the_whole(recording: Recording) -> None:
    whole = recording.body(rate=1000)
    inside = whole.filter((pc.field("time") >= 0.9995) & (pc.field("time") <= 2.0005))
    assert recording.body(rate=1000, between=(1, 2)).combine_chunks().equals(inside.combine_chunks())
    times = np.asarray(recording.body(rate=50, between=(1, 2))["time"])
    np.testing.assert_allclose(times, np.arange(1.0, 2.001, 0.02))


def test_windows_join_wherever_they_begin(recording: Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(samples, "_WINDOW", 100)
    times = np.asarray(recording.body(rate=1000, between=(1.0054, 2.0))["time"])
    np.testing.assert_allclose(times, np.arange(1006, 2001) / 1000)


@pytest.mark.parametrize("name", ["ticks", "commands", "body"])
def test_a_window_includes_its_ends(name: str, recording: Recording) -> None:
    odd = next(at for at in recording.ticks()["time"].to_pylist() if at != round(at, 6))  # 0.7000000000000001
    for at in (round(odd, 6), odd):
        assert set(recording.table(name, between=(at, at))["time"].to_pylist()) == {odd}


def test_ticks_tell_what_ran(recording: Recording) -> None:
    ticks = recording.ticks().to_pylist()
    assert {t["running"].rsplit("/", 1)[-1] for t in ticks if t["time"] < 2.0} == {"approach"}
    assert {t["running"].rsplit("/", 1)[-1] for t in ticks if 2.05 < t["time"] < 2.3} == {"idle"}
    assert all((t["took"] or 0) > 0 for t in ticks if t["time"] < 2.3)
    assert ticks[-1]["took"] is None  # the robot comes to a stand, without a tree


def test_spans_follow_from_changes(recording: Recording) -> None:
    spans = {s["name"]: s for s in recording.spans().to_pylist() if s["kind"] in ("skill", "action")}
    assert list(spans) == ["approach", "idle"]
    assert (spans["approach"]["time"], spans["approach"]["ended"]) == (0.0, 2.0)
    assert spans["approach"]["status"] == "INVALID" and "preempted" in spans["approach"]["text"]
    assert spans["idle"]["duration"] == pytest.approx(0.3)
    assert recording.spans(between=(2.2, 2.3)).num_rows < recording.spans().num_rows


def test_a_skill_that_ends_in_its_first_tick_has_a_span(file: Path) -> None:
    log = read_flight(file)
    path = next(node["path"] for node in log.setup["tree"]["nodes"] if node["kind"] == "skill")
    told = [("SUCCESS", ""), ("INVALID", ""), ("FAILURE", ""), ("INVALID", "halted: 'parallel' failed")]
    log.news[:] = [News(1.0, "node", [path, *change]) for change in told]
    spans = Happened(log).spans(2.0)
    assert [(s["node"], s["time"], s["ended"], s["duration"]) for s in spans] == 3 * [(path, 1.0, 1.0, 0.0)]
    assert [s["status"] for s in spans] == ["SUCCESS", "FAILURE", "INVALID"]  # what ended and is only reset has none


def test_limits_are_those_of_the_robot(recording: Recording) -> None:
    limits = {row["joint"]: row for row in recording.limits().to_pylist()}
    assert limits["left_knee"]["torque"] == 150.0
    assert limits["left_hip_yaw"]["lower"] < 0 < limits["left_hip_yaw"]["upper"]


@pytest.mark.trials
def test_a_run_takes_the_parameters_of_another(other: Path) -> None:
    report = run("fetch", duration=0.02, parameters=hbt.open_recording(other).parameters)
    assert report.parameters["stop_distance"] == pytest.approx(0.35)


def test_a_recording_says_what_it_is(recording: Recording) -> None:
    assert recording.outcome == "unfinished" and "2.3 s" in recording.reason
    assert repr(recording).endswith("fetch on humanoid in ball_on_stand, seed 0: unfinished after 2.30 s")
    assert recording.damage == []


@pytest.mark.parametrize(
    ("ask", "answer"),
    [
        (lambda r: r.table("joint"), "no table 'joint'.*did you mean 'joints'"),
        (lambda r: r.joints(columns=["torqe"]), "no column 'torqe'.*did you mean 'torque'"),
        (lambda r: r.joints(rate=300), "rate of 300 Hz.*divides the 1000 Hz"),
        (lambda r: r.joints(rate="fast"), "rate of 'fast' Hz"),
        (lambda r: r.ticks(between=(3, 1)), "earlier one first"),
        (lambda r: r.ticks(between=3), "two engine times"),
        (lambda r: hbt.open_recording(3), "not by 3"),
    ],
)
def test_wrong_questions_are_answered(ask: Callable[[Recording], Any], answer: str, recording: Recording) -> None:
    with pytest.raises(UserError, match=f"(?s){answer}"):
        ask(recording)


def test_long_runs_pass_in_small_parts(recording: Recording) -> None:
    parts = list(recording.batches("joints", rate=1000))
    assert len(parts) == math.ceil(recording.duration / 5)
    assert max(part.num_rows for part in parts) <= 5000 * recording.limits().num_rows
    assert sum(part.num_rows for part in parts) == recording.joints(rate=1000).num_rows


def test_a_run_lasts_from_its_first_tick(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = read_flight(file)
    news_of = log.news_of
    monkeypatch.setattr(explaining, "read_flight", lambda _: log)
    monkeypatch.setattr(log, "news_of", lambda *kinds, **of: (n for n in news_of(*kinds, **of) if n.time >= 0.5))
    began = next(news_of("node", begin=0.5)).time
    assert Recording(log).title.endswith(f": unfinished after {2.3 - began:.2f} s")
    assert f": unfinished after {2.3 - began:.2f} s" in dict(explaining.explain(file).rows)["run"]
