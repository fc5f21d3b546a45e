"""Parameters out of a recording, into the next run, and beside those of another."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import humanoid_bt as hbt
from humanoid_bt.cli import main
from humanoid_bt.core.items import Item
from humanoid_bt.files import document
from humanoid_bt.record.reading import read_flight
from humanoid_bt.record.shape import SETUP
from humanoid_bt.review import parameters
from humanoid_bt.review.recorded_run import recorded_run
from humanoid_bt.review.recording import open_recording
from humanoid_bt.review.setup import ParameterInfo
from humanoid_bt.session.setup import tree_setup


@pytest.fixture
def written(other: Path, tmp_path: Path) -> Path:
    """The parameters of the run that was given one, as a file."""
    path = tmp_path / "yesterday.yaml"
    path.write_text(parameters.as_yaml(open_recording(other)), encoding="utf-8")
    return path


def test_the_file_says_what_the_run_had_and_where_from(written: Path, other: Path) -> None:
    text = written.read_text(encoding="utf-8")
    assert yaml.safe_load(text)["stop_distance"] == "35 cm"
    lines = {line.split(":")[0]: line for line in text.splitlines()}
    assert lines["stop_distance"].endswith("# given") and lines["look"].endswith("fetch.yaml:18:9")
    assert other.name in text.splitlines()[1]


def run_report(tmp_path: Path, *arguments: str) -> tuple[int, dict[str, object]]:
    report = tmp_path / "report.json"
    common = ["--no-record", "--no-view", "--quiet", "--duration", "0.02", "--report", str(report)]
    code = main(["run", "fetch", *common, *arguments])
    return code, json.loads(report.read_text())["parameters"] if report.exists() else {}


def test_a_run_takes_the_file_and_set_wins(written: Path, other: Path, tmp_path: Path) -> None:
    for source in (written, other):
        code, values = run_report(tmp_path, "--params", str(source), "--set", "look=4 s")
        assert code == 5
        assert parameters.same(values, open_recording(other).parameters | {"look": 4.0})


def test_mistakes_are_told_with_their_places(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("p.yaml").write_text("stop_distance: 30 kg\nlok: 3\n", encoding="utf-8")
    code, values = run_report(tmp_path, "--params", "p.yaml")
    told = capsys.readouterr().err
    assert (code, values) == (2, {})
    assert (
        "p.yaml:1:16: error: 'stop_distance'" in told and "p.yaml:2:6: error: the tree has no parameter 'lok'" in told
    )
    assert "did you mean 'look'?" in told
    Path("p.yaml").write_text("- 3\n", encoding="utf-8")
    assert run_report(tmp_path, "--params", "p.yaml")[0] == 2
    assert "p.yaml:1:1: error: a file of parameters is a mapping, not a list" in capsys.readouterr().err


def test_where_a_value_is_from_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("p.yaml").write_text("stop_distance: 30 cm\n", encoding="utf-8")
    main(["run", "fetch", "--no-view", "--quiet", "--duration", "0.02", "--params", "p.yaml", "--camera", "off"])
    (recorded,) = tmp_path.glob("runs/*.rrd")
    assert "stop_distance: 30 cm    # given in p.yaml:1:16\n" in parameters.as_yaml(open_recording(recorded))
    assert recorded_run(read_flight(recorded)).given == {"stop_distance": "30 cm"}  # for its replay


def test_differences_are_those_that_matter(
    file: Path, other: Path, written: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["params", "diff", str(other), str(written)]) == 0
    assert capsys.readouterr().out == ""
    assert main(["params", "diff", str(file), str(other)]) == 1
    *names, line = capsys.readouterr().out.splitlines()
    assert names == [f"A  {file}", f"B  {other}"]
    assert line.startswith("   stop_distance  0.4 m → 35 cm") and line.endswith(" → given")


DECLARED = {"text": "no", "dollar": "no", "two": "no", "many": ["a"], "long": "1 m", "bare": 1.5}
GIVEN = {"text": "5 s", "dollar": "$5", "two": "$$", "many": ["1 m", "$x"], "long": "50 cm", "bare": "2 min"}


@pytest.fixture
def texts(tmp_path: Path) -> Any:
    """What there is of the recording of a run that was given values of every kind."""
    file = tmp_path / "texts.yaml"
    told = {"log": {"text": "{one} {text} {dollar} {two} {long} {bare}"}}
    root = {"for_each": {"items": "$many", "item": "one", **told}}
    file.write_text(json.dumps({"format": 1, "parameters": DECLARED, "root": root}), encoding="utf-8")
    setup = SETUP({"tree": tree_setup(hbt.load(file, parameters=GIVEN), GIVEN)})
    return SimpleNamespace(setup=setup, title="a run", path=tmp_path / "a.rrd", news=[])


def test_what_was_given_is_given_again_as_it_was(texts: Any) -> None:
    assert recorded_run(texts).given == GIVEN


def test_a_text_is_the_same_in_the_file_that_was_made_of_it(
    texts: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parameters, "open_recording", lambda _: texts)
    (tmp_path / "a.yaml").write_text(parameters.as_yaml(texts), encoding="utf-8")
    run, file = (parameters.known_parameters(tmp_path / name) for name in ("a.rrd", "a.yaml"))
    assert list(parameters.changed_parameters(run, file)) == list(parameters.changed_parameters(file, run)) == []
    file["text"] = ParameterInfo(5.1, "5.1 s")
    assert [change.name for change in parameters.changed_parameters(run, file)] == ["text"]


def test_the_newest_recording_is_meant(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["params"]) == 2
    assert "no recording in 'runs'" in capsys.readouterr().err
    Path("runs").mkdir()
    Path("runs/one.rrd").symlink_to(file)
    assert main(["params"]) == 0
    assert "runs/one.rrd" in capsys.readouterr().out


PLAIN = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(st.characters(codec="utf-8"))


@settings(deadline=None, derandomize=True, database=None)
@given(st.dictionaries(st.from_regex(r"[a-z_]\w*", fullmatch=True), PLAIN | st.lists(PLAIN, max_size=3), max_size=4))
def test_any_value_comes_back(values: dict[str, object]) -> None:
    """What the file holds is read as it was, whatever characters are in it."""

    class Held:
        title, path = "a run", Path("a.rrd")
        setup = SETUP({"tree": {"parameters": {name: {"value": value} for name, value in values.items()}}})

    text = parameters.as_yaml(Held())  # type: ignore[arg-type]  # less than a whole one is enough
    read = document.parse(text, "a.yaml")
    assert isinstance(read, Item)
    assert parameters.same(read.plain(), values)


def test_numbers_are_the_same_but_for_noise() -> None:
    assert parameters.same(35 * 0.01, 0.35) and parameters.same([1, math.inf], [1.0, math.inf])
    assert not parameters.same(True, 1) and not parameters.same(0.35, 0.36) and not parameters.same("a", 1)
    changes = parameters.changed_parameters({"a": ParameterInfo(1)}, {"b": ParameterInfo(1)})
    assert [(c.name, c.before is None, c.after is None) for c in changes] == [("a", False, True), ("b", True, False)]
