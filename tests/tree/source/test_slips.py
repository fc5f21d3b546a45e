"""The slips that people make most in a tree file: each is one finding, at its place, with what repairs it."""

from pathlib import Path

import pytest
import yaml

import humanoid_bt as hbt
from humanoid_bt.files.workspace import Workspace

TREE = """\
format: 1
name: visit
description: Walk to the ball and touch it.
robot: humanoid
scene: ball_on_stand

parameters:
  target: target
  near: 0.5 m

root:
  emergency_stop:
    watchdog:
      percept: $target
      max_age: 0.5 s
      on_stale: idle
      reactive_sequence:
        - confident: {percept: $target, above: 0.6, hysteresis: 0.1}
        - selector:
            name: get near
            children:
              - condition: distance($target) < $near hysteresis 5 cm
              - timeout:
                  duration: 60 s
                  approach: {target: $target, distance: 0.4 m}
        - reach:
            target: $target
            hand: right
"""

NEAR = """\
format: 1
subtree: true
outputs:
  gone: {type: number, unit: m}
root: {set_blackboard: {key: gone, value: 0.46}}
"""

SLIPS = yaml.safe_load((Path(__file__).parent / "slips.yaml").read_text(encoding="utf-8"))


def _findings(tmp_path, monkeypatch, text):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "trees").mkdir()
    (tmp_path / "trees" / "visit.yaml").write_text(text, encoding="utf-8")
    (tmp_path / "trees" / "near.yaml").write_text(NEAR, encoding="utf-8")
    return hbt.check("visit", workspace=Workspace(tmp_path))


def test_the_tree_is_right_without_them(tmp_path, monkeypatch):
    assert _findings(tmp_path, monkeypatch, TREE) == []


@pytest.mark.parametrize("slip", SLIPS, ids=[slip[0] for slip in SLIPS])
def test_one_slip_is_one_finding_with_what_repairs_it(tmp_path, monkeypatch, slip):
    _, before, after, place, code, hint = slip
    assert TREE.count(before) == 1
    found = _findings(tmp_path, monkeypatch, TREE.replace(before, after))
    assert [(f"{f.place.line}:{f.place.column}", f.code) for f in found] == [(place, code)], found
    assert hint in found[0].hint, found[0].hint


def test_no_hint_lists_more_than_a_line(tmp_path, monkeypatch):
    found = _findings(tmp_path, monkeypatch, TREE.replace("- reach:", "- zzz:"))
    assert len(found) == 1
    assert found[0].hint.endswith("all: humanoid-bt nodes")
    assert len(found[0].hint) < 120


def test_a_name_used_often_is_told_once_with_all_its_lines(tmp_path, monkeypatch):
    found = _findings(tmp_path, monkeypatch, TREE.replace("target: target\n  near", "traget: target\n  near"))
    assert len(found) == 1
    assert "did you mean 'traget'" in found[0].hint
    assert found[0].hint.endswith("also in lines 18, 25, 27")
