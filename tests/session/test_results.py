"""What a run keeps of what skills report, of what happened, and of what the tree knows at the end."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.session.report import Report
from humanoid_bt.session.session import Session
from humanoid_bt.testing.stage import Stage
from tests.record.helpers import rows

SKILLS = '''
import numpy as np
from humanoid_bt import Key, Skill, Status, param, result


class Count(Skill):
    """Count ticks; report on the way."""

    ticks: int = param(3, doc="How many.")
    last: float | None = param(None, doc="Reported at the end, whatever it is.")
    counted: int = result(doc="Ticks so far.")
    gap: float = result(unit="m", doc="Still to go.")
    word: str = result(doc="What it says.")
    came_to: float = result(doc="What it was given to report.")

    def initialise(self) -> None:
        assert not self.results
        self._count = 0

    def update(self) -> Status:
        self._count += 1
        self.counted = self._count
        self.gap = (self.ticks - self._count) / 10
        if self._count < self.ticks:
            return self.running("counting")
        self.word = "done"
        if self.last is not None:
            self.came_to = self.last
        return self.succeed("counted")


class Wrong(Skill):
    """Report what is no number."""

    gap: float = result(unit="m", doc="Still to go.")

    def update(self) -> Status:
        self.gap = float("nan")
        return Status.SUCCESS


class Note(Skill):
    """Write odd things to the blackboard."""

    key: Key = param(doc="Where to.")

    def update(self) -> Status:
        self.key.set({"place": np.array([1.0, np.inf]), 3: Status.RUNNING, "parts": (1, None, {"x"}), "at": object})
        return self.succeed("noted")
'''

SCENE = """
format: 1
name: three
objects:
  far: {shape: ball, size: [8 cm], position: [9, 0, 0.9]}
  behind: {shape: ball, size: [8 cm], position: [-1, 0, 0.9]}
  under: {shape: ball, size: [8 cm], position: [1, 0, 0.9]}
  near: {shape: ball, size: [8 cm], position: [1, 0, 0.9]}
percepts: {far: {object: far}, behind: {object: behind}, under: {object: under}, near: {object: near}}
events: [{at: 0, hide: under}, {at: 0.1 s, hide: near}]
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("user")
    for part in ("trees", "skills", "sim/scenes"):
        (folder / part).mkdir(parents=True)
    (folder / "skills" / "odd.py").write_text(SKILLS, encoding="utf-8")
    (folder / "sim" / "scenes" / "three.yaml").write_text(SCENE, encoding="utf-8")
    return folder


def run(project: Path, root: str, *, recording: Path | None = None, head: str = "", duration: float = 5.0) -> Report:
    text = f"format: 1\nscene: three\n{head}\nroot: {root}\n"
    (project / "trees" / "t.yaml").write_text(text, encoding="utf-8")
    return Session("t", workspace=project, record=recording or False, camera=False, duration=duration).run()


def told(report: Report, name: str) -> list[tuple[float, str, object]]:
    return [(entry["time"], entry["status"], entry["value"]) for entry in report.results if entry["name"] == name]


def test_each_end_of_a_skill_is_reported_with_its_values(project: Path) -> None:
    report = run(project, "{sequence: [count, {count: {name: other, ticks: 2}}]}")
    assert report.results[0] == {
        "time": 0.04, "path": "t/sequence/count", "status": "SUCCESS", "name": "counted", "value": 3, "unit": "",
    }  # fmt: skip
    assert told(report, "gap") == [(0.04, "SUCCESS", 0.0), (0.06, "SUCCESS", 0.0)]
    assert report.result("counted") == 2
    assert report.result("count/counted") == 3
    assert report.result("other/word") == "done"


def test_a_skill_that_starts_again_reports_anew(project: Path) -> None:
    report = run(project, "{repeat: {times: 2, count: }}")
    assert told(report, "counted") == [(0.04, "SUCCESS", 3), (0.1, "SUCCESS", 3)]


def test_a_skill_that_ends_in_its_first_tick_reports_each_time(project: Path, tmp_path: Path) -> None:
    once = "count: {ticks: 1, last: $n}"
    root = f"{{for_each: {{item: n, items: [1, 2, 3], sequence: [{{{once}}}, {{wait: 40 ms}}]}}}}"
    report = run(project, root, recording=tmp_path / "flight.rrd")
    assert told(report, "counted") == [(time, "SUCCESS", 1) for time in (0.0, 0.06, 0.12)]
    series = "/results/others/t\\/for_each\\/sequence\\/count/counted"
    assert rows(tmp_path / "flight.rrd", series, "Scalars:scalars") == [(time, [1.0]) for time in (0.0, 0.06, 0.12)]
    Stage(project, dry=True).run("t").expect("order: [count, wait, count, wait, count]", "came_to == 3")


def test_a_halted_skill_reports_how_far_it_came(project: Path) -> None:
    report = run(project, "{timeout: {duration: 0.1 s, count: {ticks: 50}}}")
    assert told(report, "gap") == [(0.1, "INVALID", pytest.approx(4.5))]
    assert told(report, "word") == []
    assert [entry["status"] for entry in report.results if entry["time"] > 0.1] == []


def test_a_session_shows_what_a_skill_has_reported_so_far(project: Path) -> None:
    (project / "trees" / "t.yaml").write_text("format: 1\nroot: {count: {ticks: 9}}\n", encoding="utf-8")
    with Session("t", workspace=project) as session:
        session.step()
        session.step()
        assert session.node("count").results == {"counted": 2, "gap": pytest.approx(0.7)}


def test_the_summary_has_the_results_of_what_ended_last(project: Path) -> None:
    report = run(project, "{sequence: [{count: {name: one}}, {count: {name: two, ticks: 2}}]}")
    assert [row for row in report.summary if row[0] in ("counted", "gap", "word")] == [
        ("counted", "2  two"),
        ("gap", "0 cm  two"),
        ("word", "done  two"),
    ]
    assert not any("two" in text for _, text in run(project, "{sequence: [count, wait: 0.1 s]}").summary)


def test_a_long_summary_ends_with_how_much_there_is_more(project: Path) -> None:
    children = ", ".join(f"{{count: {{name: c{number}}}}}" for number in range(4))
    summary = run(project, f"{{parallel: [{children}]}}").summary
    assert ("", "6 more results in the report") in summary
    assert sum("  c" in text for _, text in summary) == 6


def test_a_name_that_nothing_reported_is_answered_with_the_nearest(project: Path) -> None:
    report = run(project, "count")
    with pytest.raises(UserError, match="nothing was reported as 'gab'") as raised:
        report.result("gab")
    assert "did you mean 'gap'?" in raised.value.problems[0].hint
    assert report.result("gab", None) is None


def test_a_value_that_is_none_is_the_skills_error_with_its_line(project: Path) -> None:
    report = run(project, "wrong")
    assert report.outcome == "error"
    line = 1 + SKILLS.splitlines().index('        self.gap = float("nan")')
    assert "the node 't/wrong' raised ValueError: the result 'gap' must be finite, not nan" in report.reason
    assert f"raised at {project / 'skills' / 'odd.py'}:{line}:" in report.reason


def test_the_recording_has_a_series_for_each_result_to_its_end(project: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.rrd"
    run(project, "{sequence: [count, {count: {name: other, ticks: 2}}]}", recording=file)
    assert rows(file, "/results/lengths/t\\/sequence\\/count/gap", "Scalars:scalars") == [
        (0.0, [0.2]),
        (0.02, [0.1]),
        (0.04, [0.0]),
    ]
    texts = [text for _, (text,) in rows(file, "/events", "TextLog:text")]
    assert any("✓ count: counted; counted 3; gap 0 cm; word done" in text for text in texts)


def test_the_report_has_events_blackboard_and_percepts_at_the_end_as_json(project: Path, tmp_path: Path) -> None:
    head = "blackboard: {n: 2, none: {type: number}}"
    report = run(project, "{sequence: [{note: {key: found}}, {wait: 0.3 s}]}", head=head)
    report.write(tmp_path / "r.json")
    values = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert values["events"][0] == {"time": 0.0, "level": "info", "text": "scene: under hidden"}
    assert {"time": 0.1, "level": "info", "text": "scene: near hidden"} in values["events"]
    assert values["blackboard"]["n"] == 2
    assert "none" not in values["blackboard"]
    found = values["blackboard"]["found"]
    assert found == {"place": [1.0, "inf"], "3": "running", "parts": [1, None, ["x"]], "at": "<class 'object'>"}
    assert [*values["percepts"]] == ["near"]
    assert values["percepts"]["near"]["distance"] == pytest.approx(1.0, abs=0.05)
    assert values["unseen"].keys() == {"far", "behind", "under"}
    assert values["unseen"]["under"] == "hidden"
    assert values["unseen"]["far"].startswith("out of range: ")
    assert values["unseen"]["behind"].startswith("out of view: ")
