"""What a run can be told, and what is wrong with what it was told."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import humanoid_bt as hbt
from humanoid_bt.session.options import RUN_TIME, RunOptions

SET = "format: 1\nparameters: {seed: 1, duration: 2 s}\nroot: {sequence: [{condition: seed == 5}, {wait: $duration}]}\n"

pytestmark = pytest.mark.usefixtures("in_project")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mode": "fast"}, "'mode' cannot be 'fast'\n    valid: lockstep, realtime"),
        ({"duration": -1}, "'duration' must be a number above 0, not -1"),
        ({"duration": math.nan}, "'duration' must be a number above 0, not nan"),
        ({"duration": "3"}, "'duration' must be a number above 0, not '3'"),
        (
            {"duration": "2 m"},
            "'duration' must be a number above 0, not '2 m'\n    in s, or as text with its unit: s, ms, min",
        ),
        ({"seed": 0.5}, "'seed' must be a whole number, 0 or more, not 0.5"),
        ({"seed": None}, "'seed' must be a whole number, 0 or more, not None"),
        ({"pace": 0}, "'pace' must be a number from 0.001 on, not 0"),
        ({"pace": 1, "mode": "realtime"}, "'pace' does not go with the mode realtime"),
        ({"hold": math.inf}, "'hold' must be a number above 0, not inf"),
        ({"serve": True}, "'serve' must be a port from 1 to 65534, not True"),
        ({"view": "yes"}, "'view' cannot be 'yes'\n    valid: False, True, auto"),
        ({"watch": 1}, "'watch' cannot be 1"),
        ({"record": 3}, "'record' must be a file, True or False, not 3"),
        ({"record": ""}, "'record' must be a file, True or False, not ''"),
        ({"scene": 3}, "'scene' must be the name or the path of a scene, not 3"),
        ({"workspace": 3}, "a workspace is a folder, not 3"),
        ({"listener": print}, "'listener' has no node_changed(), event(), progress(), show()"),
        ({"parameters": ["x"]}, "'parameters' must be a mapping of names to values"),
        (
            {"sede": 3},
            "sede=3: error: the tree has no parameter 'sede' [unknown-parameter]\n"
            "    did you mean the argument 'seed'?",
        ),
        (
            {"near": 0.42},
            "near=0.42: error: the tree has no parameter 'near' [unknown-parameter]\n"
            "    the tree declares no parameters",
        ),
    ],
)
def test_a_wrong_argument_is_one_clear_message(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(hbt.UserError) as raised:
        hbt.run("walk", **arguments)
    assert message in str(raised.value)
    assert str(raised.value).count("\n") <= 1


def test_every_wrong_argument_is_told() -> None:
    with pytest.raises(hbt.UserError) as raised:
        hbt.Session(3, seed=-1, duration=0, record=0)  # type: ignore[arg-type]  # the mistakes that are tried
    assert len(raised.value.problems) == 4


def test_values_are_plain_or_text_and_may_be_called_like_arguments(project: Path) -> None:
    (project / "trees" / "set.yaml").write_text(SET, encoding="utf-8")
    report = hbt.run("set", seed=3, parameters={"seed": 5, "duration": "40 ms"})
    assert (report.outcome, report.seed, report.parameters) == ("success", 3, {"seed": 5.0, "duration": 0.04})
    with pytest.raises(hbt.UserError, match="is given twice"):
        hbt.run("fetch", parameters={"target": "a"}, target="b")
    with pytest.raises(hbt.UserError, match=r"duration=\[1\]: error: 'duration' must be a number, not a list"):
        hbt.run("set", parameters={"duration": [1]})
    with pytest.raises(hbt.UserError, match="'duration' cannot be <object"):
        hbt.run("set", parameters={"duration": object()})


def test_a_recording_that_no_viewer_would_open_is_refused() -> None:
    with pytest.raises(hbt.UserError, match=r"'record' must be a file that ends in .rrd, not 'a.txt'\n    a.rrd"):
        hbt.Session("wait", record="a.txt")


@pytest.mark.parametrize("perception", [{1: {}}, {"color_blob": {1: 2}}])
def test_what_is_no_text_is_no_name_of_a_source_or_a_parameter(perception: Any) -> None:
    with pytest.raises(hbt.UserError, match="1"):
        hbt.Session("fetch", perception=perception)


@pytest.mark.parametrize("pace", [1e-12, 5e-324, 1e-4])
def test_a_pace_at_which_nothing_moves_is_refused(pace: float) -> None:
    with pytest.raises(hbt.UserError, match=r"'pace' must be a number from 0\.001 on"):
        hbt.Session("fetch", pace=pace)


@pytest.mark.parametrize(
    ("options", "watched", "limit"),
    [
        ({}, False, RUN_TIME),
        ({"tree": "slow"}, False, 900.0),
        ({"tree": "slow", "duration": 5.0}, False, 5.0),
        ({}, True, math.inf),
        ({"watch": True}, False, math.inf),
        ({"mode": "realtime"}, False, math.inf),
        ({"mode": "realtime", "duration": 5.0}, True, 5.0),
    ],
)
def test_a_run_that_nobody_watches_has_an_end(
    project: Path, options: dict[str, Any], watched: bool, limit: float
) -> None:
    waits = "{timeout: {duration: 400 s, running: }}, {timeout: {duration: 500 s, running: }}, {wait: 50 s}"
    (project / "trees" / "slow.yaml").write_text(f"format: 1\nroot: {{sequence: [{waits}]}}\n", encoding="utf-8")
    given = RunOptions(**{"tree": "walk", **options})
    assert given.limit(watched, hbt.load(given.tree, workspace=project)) == limit
