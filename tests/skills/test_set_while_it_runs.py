"""Parameters that are set while a skill runs: what it says is true of what it did."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.common import Status

import humanoid_bt as hbt


def session_of(folder: Path, node: str, monkeypatch: pytest.MonkeyPatch) -> hbt.Session:
    (folder / "trees").mkdir()
    text = f"format: 1\nroot: {{emergency_stop: {{timeout: {{duration: 30 s, {node}}}}}}}\n"
    (folder / "trees" / "t.yaml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(folder)
    return hbt.Session("t")


def test_a_wave_that_is_told_to_wave_less_often_than_it_has_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with session_of(tmp_path, "wave: {times: 9}", monkeypatch) as session:
        session.run_until(lambda s: s.node("wave").results.get("waved") == 2, timeout=8)
        session.set("wave.times", 1)
        session.run_until(session.time + 0.5)
        assert session.node("wave").status is Status.SUCCESS
        assert session.node("wave").feedback == "waved the right hand 2 times"


def test_says_how_far_it_turned_whatever_angle_is_set_meanwhile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with session_of(tmp_path, "turn: {angle: 60 deg}", monkeypatch) as session:
        session.run_until(1.0)
        session.set("turn.angle", "170 deg")
        session.run_until(lambda s: s.node("turn").status is not Status.RUNNING, timeout=10)
        turned = session.node("turn").results["turned"]
        assert turned == pytest.approx(session.state.stance[2], abs=0.03)


def test_says_where_it_walked_to_whatever_place_is_set_meanwhile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with session_of(tmp_path, "walk_to: {x: 0.4, y: 0}", monkeypatch) as session:
        session.run_until(1.0)
        session.set("walk_to.x", 5)
        session.run_until(lambda s: s.node("walk_to").status is not Status.RUNNING, timeout=10)
        assert "from (0.4, 0)" in session.node("walk_to").feedback
