"""Scenario files as tests of pytest: each seed of each is one."""

from __future__ import annotations

import re
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from humanoid_bt.testing.scenario import Scenario
    from humanoid_bt.testing.trial import Trial, Trials

_TRIALS: pytest.StashKey[Trials] = pytest.StashKey()
_KEY = re.compile(rb"^(tree|expect)\s*:", re.MULTILINE)
_WORKSPACE = ("trees", "skills", "sim", "campaigns")


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> ScenarioFile | None:
    """Collect the scenarios of a folder ``scenarios/``."""
    return _file(file_path, parent) if _is_scenario(file_path) else None


def pytest_collect_directory(path: Path, parent: pytest.Collector) -> ScenarioFile | None:
    """Collect a folder that is named like a scenario, to tell of it."""
    return _file(path, parent) if _is_scenario(path) else None


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Collect links that lead nowhere, too: pytest itself passes over them."""
    report = yield
    if isinstance(collector, pytest.Directory) and "scenarios" in collector.path.parts and report.passed:
        lost = (path for path in sorted(collector.path.glob("*.yaml")) if not path.exists())
        report.result += [_file(path, collector) for path in lost if _is_scenario(path)]
    return report


def _file(path: Path, parent: pytest.Collector) -> ScenarioFile:
    file: ScenarioFile = ScenarioFile.from_parent(parent, path=path)
    return file


def _is_scenario(path: Path) -> bool:
    """Return whether a path is to be read as a scenario, also if it is a broken one.

    Other tools have folders of this name too: what does not look like a scenario is one where the folder stands in a
    workspace.
    """
    if path.suffix != ".yaml" or "scenarios" not in path.parent.parts:
        return False
    from humanoid_bt.files.workspace import deep_folder

    deep = deep_folder(path.parent)
    if deep is None or deep.name != "scenarios":  # a workspace may itself lie in a folder of this name
        return False
    folders = [folder for folder in path.parents if folder.name == "scenarios"]
    looks = path.is_file() and _KEY.search(path.read_bytes()) is not None
    return looks or any((folder.parent / name).is_dir() for folder in folders for name in _WORKSPACE)


class ScenarioFile(pytest.File):
    """A scenario file."""

    def collect(self) -> Iterator[ScenarioItem]:
        """Yield a test for each of its seeds."""
        from humanoid_bt.core.errors import UserError
        from humanoid_bt.testing.scenario_check import checked_scenario

        try:
            scenario = checked_scenario(self.path, self.trials.workspace(self.path))
        except UserError as error:
            raise self.CollectError(str(error)) from None
        for seed in scenario.seeds:
            yield ScenarioItem.from_parent(self, name=f"seed-{seed}", scenario=scenario, seed=seed)

    @property
    def trials(self) -> Trials:
        """What tries the scenarios of this session, so that they all load the robot once."""
        from humanoid_bt.testing.trial import Trials

        if _TRIALS not in self.config.stash:
            named = self.config.getini("humanoid_bt_workspace")
            self.config.stash[_TRIALS] = Trials(self.config.rootpath / named if named else None)
        return self.config.stash[_TRIALS]


class ScenarioItem(pytest.Item):
    """One seed of a scenario.

    Args:
        scenario: it.
        seed: the seed.
    """

    def __init__(self, *, scenario: Scenario, seed: int, **more: Any) -> None:
        super().__init__(**more)
        self.scenario, self.seed = scenario, seed

    def runtest(self) -> None:
        """Try it; what fails is run again and recorded."""
        assert isinstance(self.parent, ScenarioFile)
        trials = self.parent.trials
        trial = trials.run(self.scenario, self.seed)
        if not trial.passed:
            raise _Failed(trials.recorded(self.scenario, trial))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return what failed, for people."""
        from humanoid_bt.core.errors import UserError

        if isinstance(excinfo.value, (_Failed, UserError)):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return where it is written, and what it is called."""
        return self.path, self.scenario.place("expect").line - 1, f"{self.scenario.name}, seed {self.seed}"


class _Failed(Exception):  # noqa: N818 (the name says it)
    """A seed of a scenario failed."""

    def __init__(self, trial: Trial) -> None:
        super().__init__("\n".join(trial.lines))
