"""Exports: what other programs read is what the recording holds, and nothing is overwritten by mistake."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from pyarrow import csv, parquet

from humanoid_bt.cli import main
from humanoid_bt.review.columns import TABLES
from humanoid_bt.review.recording import Recording


def export(file: Path, *arguments: object) -> int:
    return main(["export", str(file), *map(str, arguments)])


def test_parquet_has_every_table_with_its_units(file: Path, recording: Recording, tmp_path: Path) -> None:
    assert export(file, "--to", "parquet", "--output", tmp_path / "out") == 0
    for name, spec in TABLES.items():
        table = parquet.read_table(tmp_path / "out" / f"{name}.parquet")
        assert table.combine_chunks().equals(recording.table(name).combine_chunks())
        units = {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in table.schema}
        assert units == {column.name: column.unit for column in spec.columns}
    about = json.loads((tmp_path / "out/run.json").read_text())
    assert about["setup"] == recording.setup and about["outcome"] == "unfinished" and about["damage"] == []


def test_csv_has_the_same_numbers(file: Path, recording: Recording, tmp_path: Path) -> None:
    some = ["--tables", "joints,nodes", "--between", 1, "2 s", "--rate", 50]
    assert export(file, "--to", "csv", "-o", tmp_path, *some) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["joints.csv", "nodes.csv", "run.json"]
    read = csv.read_csv(tmp_path / "joints.csv")
    whole = recording.joints(between=(1, 2), rate=50)
    assert read["joint"].to_pylist() == whole["joint"].to_pylist()
    assert read["torque"].cast("float32").combine_chunks() == whole["torque"].combine_chunks()


def test_nothing_is_overwritten_by_mistake(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    precious = tmp_path / "events.csv"
    precious.write_text("mine")
    assert export(file, "--to", "csv", "-o", tmp_path) == 2
    assert "events.csv' would be overwritten" in capsys.readouterr().err
    assert [precious.read_text(), *tmp_path.iterdir()] == ["mine", precious]
    assert export(file, "--to", "csv", "-o", tmp_path, "--tables", "events", "--force") == 0
    assert precious.read_text().startswith('"time"')


def test_a_place_that_cannot_be_written_is_told(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").touch()
    assert export(file, "--to", "csv", "-o", tmp_path / "file" / "in it") == 2
    assert "cannot be written: Not a directory" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [tmp_path / "file"]


def test_the_export_stands_beside_the_recording(file: Path, tmp_path: Path) -> None:
    (tmp_path / "run.rrd").symlink_to(file)
    assert export(tmp_path / "run.rrd", "--to", "csv", "--tables", "events") == 0
    assert (tmp_path / "run/events.csv").exists()


@pytest.mark.parametrize(
    ("arguments", "answer"),
    [
        (["--tables", "joint"], "no table 'joint'\n    did you mean 'joints'?"),
        (["--between", "3", "1"], "the earlier one first"),
        (["--rate", "300"], "no samples can be had at a rate of 300"),
    ],
)
def test_wrong_arguments_are_answered(
    arguments: list[str], answer: str, file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert export(file, "--to", "csv", "-o", tmp_path / "out", *arguments) == 2
    assert answer in capsys.readouterr().err
    assert not list(tmp_path.rglob("*.csv*"))


@pytest.fixture(scope="module")
def messages(file: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    reader = pytest.importorskip("mcap.reader")
    path = tmp_path_factory.mktemp("mcap") / "run.mcap"
    assert export(file, "--to", "mcap", "-o", path, "--between", 0, 2.2, "--rate", 100) == 0
    found: dict[str, list[Any]] = {}
    with path.open("rb") as stream:
        made = reader.make_reader(stream, validate_crcs=True)
        for schema, channel, message in made.iter_messages():
            value = json.loads(message.data)
            told = found.setdefault(channel.topic, [])
            if len(told) < 3:
                jsonschema.validate(value, {**json.loads(schema.data), "additionalProperties": False})
            told.append((message.log_time, schema.name, value))
        found["metadata"] = list(made.iter_metadata())
        found["attachments"] = list(made.iter_attachments())
    return found


def test_joints_in_mcap_are_those_of_the_recording(messages: dict[str, list[Any]], recording: Recording) -> None:
    table = recording.joints(rate=100, between=(1.5, 1.5)).to_pylist()
    _, schema, value = next(found for found in messages["/joints"] if found[0] == 1_500_000_000)
    assert schema == "foxglove.JointStates" and value["timestamp"] == {"sec": 1, "nsec": 500_000_000}
    assert [(j["name"], j["position"], j["effort"]) for j in value["joints"]] == [
        (row["joint"], row["position"], row["torque"]) for row in table
    ]
    based = [at for at, _, value in messages["/tf"] if value["transforms"][0]["child_frame_id"] == "base"]
    assert len(messages["/joints"]) == len(messages["/servo"]) == len(based) == 220


def test_joints_in_mcap_can_be_asked_for_by_name(messages: dict[str, list[Any]], recording: Recording) -> None:
    rows = {row["joint"]: row for row in recording.joints(rate=100, between=(1.5, 1.5)).to_pylist()}
    value = next(value for at, _, value in messages["/servo"] if at == 1_500_000_000)
    assert {name: row["setpoint"] for name, row in value.items() if name != "timestamp"} == {
        name: row["setpoint"] for name, row in rows.items()
    }


def test_robot_and_scene_in_mcap_are_fixed_to_frames_that_move(messages: dict[str, list[Any]]) -> None:
    ((_, schema, robot),) = messages["/robot"]
    assert schema == "foxglove.SceneUpdate"
    _, _, bodies = [found for found in messages["/tf"] if len(found[2]["transforms"]) > 1][25]
    moved = {each["child_frame_id"]: each for each in bodies["transforms"]}
    assert {entity["frame_id"] for entity in robot["entities"]} <= moved.keys()
    shin = next(entity for entity in robot["entities"] if entity["id"] == "left_shin")
    assert shin["frame_locked"] and shin["cylinders"] and shin["spheres"]
    second = bodies["transforms"][0]["timestamp"]["sec"] + bodies["transforms"][0]["timestamp"]["nsec"] / 1e9
    place = next(
        value["transforms"][0]["translation"]["x"]
        for at, _, value in messages["/tf"]
        if at >= second * 1e9 and value["transforms"][0]["child_frame_id"] == "base"
    )
    assert moved["pelvis"]["translation"]["x"] == pytest.approx(place, abs=0.005)


def test_a_hidden_thing_in_mcap_can_be_seen_through(messages: dict[str, list[Any]]) -> None:
    opacity = [
        (at, entity["spheres"][0]["color"]["a"])
        for at, _, value in messages["/scene"]
        for entity in value["entities"]
        if entity["id"] == "object_ball"
    ]
    (begin, whole), (hidden, faint) = opacity
    assert (begin, whole) == (0, 1.0)
    assert hidden == 2_000_000_000 and faint < 0.5
    assert all(len(value["entities"]) > 1 for _, _, value in messages["/scene"])


def test_what_happened_is_told_under_known_schemas(messages: dict[str, list[Any]]) -> None:
    assert {schema for topic in ("/events", "/nodes") for _, schema, _ in messages[topic]} == {"foxglove.Log"}
    assert [(at, value["message"]) for at, _, value in messages["/events"]] == [(2_000_000_000, "scene: ball hidden")]
    failed = next(value for _, _, value in messages["/nodes"] if value["level"] == 3)
    assert failed["file"].endswith("fetch.yaml") and failed["line"] > 20
    assert messages["/percepts/target"][0][2]["frame_id"] == "base"
    assert {"/ticks", "/body", "/commands/base", "/commands/gaze"} <= messages.keys()
    assert any(topic.startswith("/results/fetch/") and topic.endswith("/target_distance") for topic in messages)


def test_an_mcap_file_says_what_was_run(messages: dict[str, list[Any]], recording: Recording) -> None:
    assert messages["metadata"][0].metadata["outcome"] == "unfinished"
    assert json.loads(messages["attachments"][0].data) == recording.setup


def test_times_in_mcap_never_go_back(messages: dict[str, list[Any]]) -> None:
    for topic, found in messages.items():
        if topic.startswith("/"):
            assert [at for at, _, _ in found] == sorted(at for at, _, _ in found)


def test_a_missing_package_is_told_with_what_brings_it(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    assert export(file, "--to", "mcap", "-o", tmp_path / "run.mcap") == 2
    assert "pip install 'humanoid-bt[mcap]'" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
