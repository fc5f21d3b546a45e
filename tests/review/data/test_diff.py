"""Two runs beside each other: what was run, where they part, what came of it."""

from __future__ import annotations

import itertools
import json
import re
import shutil
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import humanoid_bt as hbt
from humanoid_bt.cli import main
from humanoid_bt.core.messages import Command, HandTarget, Pointing
from humanoid_bt.record.reading import News, read_flight
from humanoid_bt.record.rrd import RrdFile
from humanoid_bt.record.shape import SETUP
from humanoid_bt.record.tick import Tick
from humanoid_bt.review.compare_run import NodeShift, command_parting, first_parting, node_shifts
from humanoid_bt.review.compare_setup import Change, setup_changes
from humanoid_bt.review.difference import Difference, difference
from humanoid_bt.review.recording import Recording, open_recording
from humanoid_bt.session.setup import tree_setup
from humanoid_bt.testing.conditions import Conditions
from humanoid_bt.testing.events import script_of
from humanoid_bt.testing.staging import Staging


@pytest.mark.trials
def test_two_runs_of_one_seed_are_the_same(file: Path, again: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diff", str(file), str(again)]) == 0
    assert capsys.readouterr().out.endswith("\n\nthe runs are the same\n")


def test_a_parameter_and_what_it_leads_to_are_told(
    file: Path, other: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert main(["diff", str(file), str(other), "--view"]) == 1
    out = re.sub(r"\s+", " ", capsys.readouterr().out)
    assert "parameters stop_distance 0.4 m → 35 cm" in out
    assert "tree …/get near/approach distance 0.4 m → 35 cm" in out
    assert re.search(r"first apart at 0\.00 s command targets base position x 1\.[45]\d+ → 1\.5\d+ ", out), out
    both = re.search(r"both in one view: rerun (\S+\.rrd)", out)
    assert both, out
    shown = dict(RrdFile(Path(both[1])).batches_of(lambda entity: "/poses" in entity))
    one, two = (shown[f"/{name}/poses"].column("Transform3D:child_frame")[0].as_py() for name in "AB")
    assert {f"B {frame}" for frame in one} == set(two)
    shutil.rmtree(Path(both[1]).parent)
    assert main(["diff", str(file), str(other), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert (found["same"], found["parting"]["quantity"]) == (False, "command targets base position x")
    assert {change["part"] for change in found["changes"]} == {"parameters", "tree", "results"}


def test_a_recording_that_is_none_is_told(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diff", str(file), str(tmp_path)]) == 2
    assert "is no recording that can be read" in capsys.readouterr().err


def ticks(recording: Recording) -> list[Tick]:
    return list(islice(recording.every_tick(), 20))


def parting(one: list[Tick], other: list[Tick], tolerance: float = 0.0) -> tuple[float, str, str, str] | None:
    return first_parting(iter(one), iter(other), [], ["hip", "knee"], tolerance)


def bent(tick: Tick, angle: float) -> Tick:
    """Return a tick with another angle of joint 3."""
    positions = tick.state.joint_positions.copy()
    positions[3] = angle
    return replace(tick, state=replace(tick.state, joint_positions=positions))


def test_the_first_moment_is_the_first_whatever_differs(recording: Recording) -> None:
    one = ticks(recording)
    assert parting(one, ticks(recording)) is None
    one[7] = bent(one[7], 0.25)
    other = [*one[:7], bent(one[7], 0.250001), *one[8:]]
    found = parting(one, other)
    assert found is not None and found[:2] == (one[7].state.time, "joint_positions 3")
    assert float(found[3]) - float(found[2]) == pytest.approx(1e-6, rel=1e-3)
    assert parting(one, other, tolerance=1e-5) is None
    unseen = [replace(one[0], percepts=()), *other[1:]]
    assert parting(one, unseen) == (0.0, "percept target", "seen at 0.00 s", "none")
    assert parting(one, one[:10]) == (one[10].state.time, "the recording", "goes on", "has ended")


def test_ticks_that_one_recording_lacks_are_no_difference(recording: Recording) -> None:
    one, joints = ticks(recording), ["hip", "knee"]
    for kept in ([*one[:5], *one[9:]], one[3:]):
        for pair in ((one, kept), (kept, one)):
            assert first_parting(iter(pair[0]), iter(pair[1]), [], joints, gaps=True) is None
    other = [*one[:5], *one[9:12], bent(one[12], 0.25), *one[13:]]
    found = first_parting(iter(one), iter(other), [], joints, gaps=True)
    assert found is not None and found[:2] == (one[12].state.time, "joint_positions 3")


def test_what_a_cut_recording_lacks_is_no_difference(file: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.rrd"
    cut.write_bytes(file.read_bytes()[: file.stat().st_size * 4 // 10])
    whole, part = open_recording(file), open_recording(cut)
    found = difference(whole, part)
    assert found.parting is not None and found.parting.quantity == "the recording"
    assert found.nodes == []
    assert {change.part for change in found.changes} == {"outcome"}


def test_runs_in_realtime_mode_are_compared_from_their_first_ticks(file: Path) -> None:
    logs = [read_flight(file) for _ in range(2)]
    for log, late in zip(logs, (1.167, 1.717), strict=True):
        log.setup["mode"] = "realtime"
        log.news[:] = [News(news.time + late, *news[1:]) for news in log.news]
        found = [replace(tick, state=replace(tick.state, time=tick.state.time + late)) for tick in log.ticks(0.0, 0.1)]
        log.ticks = lambda *_, found=found: iter(found)  # type: ignore[method-assign]  # of this log
    one, other = map(Recording, logs)
    assert difference(one, other).is_none
    logs[1].news[:] = [News(news.time + 0.05, *news[1:]) for news in logs[1].news]
    again = Recording(logs[1])
    assert difference(one, again, within=0.06).is_none
    shifted = difference(one, again)
    assert shifted.parting is not None and shifted.parting[:2] == (pytest.approx(0.0), "node")


def change(node: str, status: str, time: float) -> dict[str, Any]:
    return {"node": f"tree/{node}", "status": status, "time": time}


def test_nodes_are_aligned_by_their_own_histories() -> None:
    one = [
        change("a", "RUNNING", 0.0),
        change("b", "RUNNING", 1.0),
        change("b", "SUCCESS", 2.0),
        change("c", "FAILURE", 3.0),
    ]
    other = [change("a", "RUNNING", 0.0), change("b", "RUNNING", 1.02), change("b", "FAILURE", 2.0)]
    assert node_shifts(one, one, 0.0) == []
    assert node_shifts(one, other, 0.02) == [
        NodeShift("b", ("SUCCESS", 2.0), ("FAILURE", 2.0)),
        NodeShift("c", ("FAILURE", 3.0), None),
    ]
    assert node_shifts(one, other, 0.0)[0] == NodeShift("b", ("RUNNING", 1.0), ("RUNNING", 1.02))


def test_what_a_node_does_parts_runs_before_the_command(recording: Recording) -> None:
    one = ticks(recording)
    command = one[0].command
    assert command is not None
    other = [replace(one[0], command=replace(command, stamp=9.0)), *one[1:]]
    shifts = node_shifts([change("a", "RUNNING", 0.0)], [change("a", "FAILURE", 0.0)], 0.0)
    found = first_parting(iter(one), iter(other), shifts, [])
    assert found == (0.0, "node", "a RUNNING", "a FAILURE")
    halted = [*node_shifts([change("a", "RUNNING", 0.0)], [change("a", "INVALID", 0.0)], 0.0)]
    assert first_parting(iter(one), iter(one), halted, []) == (0.0, "node", "a RUNNING", "a HALTED")


def test_a_node_that_was_halted_is_told_so(
    file: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    halted = Difference(nodes=[NodeShift("a", ("FAILURE", 2.0), ("INVALID", 1.0))])
    monkeypatch.setattr("humanoid_bt.cli.diff.difference", lambda *_: halted)
    assert main(["diff", str(file), str(file)]) == 1
    assert "a  FAILURE at 2.00 s → HALTED at 1.00 s\n" in capsys.readouterr().out


def tree(*nodes: tuple[str, str, dict[str, Any]]) -> dict[str, Any]:
    described = [{"path": path, "type": kind, "values": values} for path, kind, values in nodes]
    return dict(SETUP({"tree": {"nodes": described}}))


def changes(one: dict[str, Any], other: dict[str, Any]) -> list[tuple[str, str | None, str | None]]:
    return [(c.name, c.before, c.after) for c in setup_changes(one, other) if c.part == "tree"]


def test_trees_are_compared_by_their_nodes() -> None:
    old = tree(("t/s", "sequence", {}), ("t/s/a", "wait", {"d": "1 s"}), ("t/s/b", "idle", {}), ("t/s/x", "turn", {}))
    new = tree(
        ("u/s", "selector", {}),
        ("u/s/b", "idle", {}),
        ("u/s/a", "wait", {"d": "2 s"}),
        ("u/s/r", "repeat", {"times": 2}),
        ("u/s/r/x", "turn", {}),
    )
    assert changes(old, new) == [
        ("x moved", "s/x", "s/r/x"),
        ("s/r", None, "repeat times: 2"),
        ("s type", "sequence", "selector"),
        ("s/a d", "1 s", "2 s"),
        ("s order", "a, b", "b, a"),
    ]
    assert changes(new, new) == []
    assert changes(tree(("t/a", "to", {"at": [3.0, 0.5]})), tree(("t/a", "to", {"at": [0.0, 0.5]}))) == [
        ("a at", "[3, 0.5]", "[0, 0.5]")
    ]
    assert [c[1:] for c in changes(new, tree(("u/s", "selector", {})))] == [
        ("idle", None),
        ("wait d: 2 s", None),
        ("repeat times: 2", None),
        ("turn", None),
    ]


ASKING = """\
format: 1
blackboard: { count: 3 }
root:
  emergency_stop:
    sequence:
      - condition: count == 3
      - log: { text: "$$5 for {count}" }
      - set_blackboard: { key: next, expression: count + 1 }
"""


def test_expressions_are_compared_as_they_are_written(tmp_path: Path) -> None:
    def loaded(text: str) -> dict[str, Any]:
        file = tmp_path / "asking.yaml"
        file.write_text(text, encoding="utf-8")
        return dict(SETUP({"tree": tree_setup(hbt.load(file), {})}))

    one = loaded(ASKING)
    assert changes(one, loaded("# says more\n" + ASKING)) == []
    assert changes(one, loaded(ASKING.replace("== 3", "> 3").replace("$$5", "6").replace("+ 1", "+ 2"))) == [
        ("emergency_stop/sequence/condition expression", "count == 3", "count > 3"),
        ("emergency_stop/sequence/log text", "$$5 for {count}", "6 for {count}"),
        ("emergency_stop/sequence/set_blackboard expression", "count + 1", "count + 2"),
    ]


@pytest.mark.parametrize(("given", "told"), [("0.35", "0.35 m"), ("35cm", "35 cm")])
def test_values_that_were_given_are_told_with_their_units(given: str, told: str) -> None:
    one, other = (
        dict(SETUP({"tree": tree_setup(hbt.load("fetch", parameters=values), values)}))
        for values in ({}, {"stop_distance": given})
    )
    found = [(change.part, change.before, change.after) for change in setup_changes(one, other)]
    assert found == [("parameters", "0.4 m", told), ("tree", "0.4 m", told)]


def test_files_and_versions_are_compared(recording: Recording) -> None:
    edited = json.loads(json.dumps(recording.setup))
    edited["files"][0]["sha256"] = "0" * 64
    edited["versions"]["mujoco"] = "3.0"
    edited["seed"] = 7
    found = [(c.part, c.name, c.after) for c in setup_changes(recording.setup, edited)]
    assert found == [
        ("settings", "seed", "7"),
        ("files", "tree trees/fetch.yaml", "0" * 12),
        ("versions", "mujoco", "3.0"),
    ]


def test_what_a_test_staged_is_compared() -> None:
    def staged(friction: float, script: list[dict[str, Any]]) -> dict[str, Any]:
        return dict(SETUP({"staged": Staging(False, Conditions(friction=friction), {}, script_of(script)).told()}))

    plain, slippery, other = staged(1.0, []), staged(0.4, []), staged(0.4001, [{"at": "30 s", "lose": "ball"}])
    assert list(setup_changes(slippery, slippery)) == []
    assert list(setup_changes(plain, slippery)) == [Change("settings", "staged conditions", None, '{"friction": 0.4}')]
    assert [(c.part, c.name, c.before) for c in setup_changes(slippery, other)] == [
        ("settings", "staged conditions", '{"friction": 0.4}'),
        ("settings", "staged script", None),
    ]


def test_not_a_number_is_like_itself(recording: Recording) -> None:
    one = ticks(recording)
    broken = replace(one[0], state=replace(one[0].state, com=np.full(3, np.nan)))
    assert parting([broken], [replace(broken, state=replace(broken.state, com=np.full(3, np.nan)))]) is None
    assert open_recording(recording.path).outcome == recording.outcome


def test_commands_differ_where_only_one_of_them_turns_a_hand() -> None:
    place, upright = np.array([0.4, 0.1, 0.9]), np.array([1.0, 0.0, 0.0, 0.0])
    ways = [None, upright, Pointing(np.array([1.0, 0.0, 0.0]))]
    for one, other in itertools.permutations(ways, 2):
        before, after = (Command(1, 0.02, {"left_hand": HandTarget(place, way)}) for way in (one, other))
        parting = command_parting(0.02, before, after)
        assert parting is not None and "left_hand orientation" in str(parting)
        assert command_parting(0.02, before, before) is None
