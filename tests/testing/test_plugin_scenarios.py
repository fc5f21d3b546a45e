"""Scenario files as tests of a user's own project, run by a pytest of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

import humanoid_bt.testing.trial  # noqa: F401 (the inner pytest forgets what it imports, and numpy loads only once)
from humanoid_bt.testing.plugin_scenarios import _is_scenario
from tests.projects import make_project


@pytest.fixture
def user(pytester: pytest.Pytester) -> pytest.Pytester:
    make_project(pytester.path)
    (pytester.path / "scenarios").mkdir()
    return pytester


def write(user: pytest.Pytester, name: str, text: str) -> None:
    (user.path / "scenarios" / name).write_text(text, encoding="utf-8")


def test_each_seed_of_each_scenario_is_a_test(user: pytest.Pytester) -> None:
    write(user, "waits.yaml", "format: 1\ntree: wait\ndry: true\nseeds: 0-2\nexpect: outcome == success\n")
    write(user, "gives_up.yaml", "format: 1\ntree: give_up\ndry: true\nexpect:\n  - outcome == success\n")
    result = user.runpytest_inprocess("-v", "-p", "no:cacheprovider")
    result.assert_outcomes(passed=3, failed=1)
    result.stdout.fnmatch_lines(
        [
            "scenarios/gives_up.yaml::seed-0 FAILED*",
            "scenarios/waits.yaml::seed-2 PASSED*",
            "*gives_up, seed 0*",
            "scenarios/gives_up.yaml:5:5: outcome == success",
            "    at 0.00 s it was not so at the end",
            "    outcome: failure",
            "the run     failure: give_up: the thing is not there",
            "recording   runs/gives_up-seed0-*.rrd",
            "try again   humanoid-bt test scenarios/gives_up.yaml --seeds 0",
            "FAILED scenarios/gives_up.yaml::seed-0 - scenarios/gives_up.yaml:5:5: outcome*",
        ]
    )


def test_a_scenario_with_a_mistake_is_one_clear_message(user: pytest.Pytester) -> None:
    write(user, "odd.yaml", "format: 1\ntree: wayt\nexpect: fell\n")
    result = user.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["scenarios/odd.yaml:2:7: error: no tree named 'wayt' *", "*did you mean 'wait'?*"])
    result.stdout.no_fnmatch_line("*Traceback*")


def test_what_is_no_scenario_at_all_is_told_too(user: pytest.Pytester) -> None:
    write(user, "empty.yaml", "")
    write(user, "list.yaml", "- hosts: all\n")
    (user.path / "scenarios" / "more").mkdir()
    (user.path / "scenarios" / "more" / "binary.yaml").write_bytes(b"\xff\x00\xfe")
    (user.path / "scenarios" / "folder.yaml").mkdir()
    (user.path / "scenarios" / "lost.yaml").symlink_to("nowhere.yaml")
    result = user.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(errors=5)
    result.stdout.fnmatch_lines_random(
        [
            "scenarios/empty.yaml:1:1: error: the file is empty*",
            "scenarios/list.yaml:1:1: error: the scenario must be a mapping, not a list*",
            "scenarios/more/binary.yaml:1:1: error: the file is not UTF-8 text*",
            "scenarios/folder.yaml: error: cannot be read: *",
            "scenarios/lost.yaml: error: cannot be read: No such file or directory*",
        ]
    )
    result.stdout.no_fnmatch_line("*Traceback*")


def test_files_of_other_tools_are_left_alone(pytester: pytest.Pytester) -> None:
    (pytester.path / "scenarios").mkdir()
    write(pytester, "playbook.yaml", "- hosts: all\n")
    write(pytester, "tree.yml", "tree: oak\n")
    pytester.runpytest_inprocess("-p", "no:cacheprovider").assert_outcomes()


def test_a_workspace_may_lie_in_a_folder_named_scenarios(tmp_path: Path) -> None:
    root = tmp_path / "scenarios" / "robot"
    for name in ("campaigns/slippery.yaml", "trees/mine.yaml", "scenarios/fails.yaml"):
        (root / name).parent.mkdir(parents=True)
        (root / name).write_text("format: 1\ntree: mine\n")
    assert not _is_scenario(root / "campaigns/slippery.yaml")
    assert not _is_scenario(root / "trees/mine.yaml")
    assert _is_scenario(root / "scenarios/fails.yaml")
