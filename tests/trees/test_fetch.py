"""The demo tree on the simulated robot: it finds its target wherever that is."""

from pathlib import Path

import pytest

from tests.trees.fetch_trials import fault, trial


@pytest.mark.parametrize(("scene", "seed"), [("random_target", 7), ("behind", 0)])
def test_a_target_anywhere_is_found_and_touched(tmp_path: Path, scene: str, seed: int) -> None:
    report = trial(tmp_path, scene, seed)
    assert not fault(report)
    turned = [entry["path"] for entry in report.timeline if entry["path"].endswith("/turn")]
    assert bool(turned) == (scene == "behind")


def test_it_stands_and_looks_around_before_it_turns(tmp_path: Path) -> None:
    report = trial(tmp_path, "behind", 1)
    times = {entry["path"].rsplit("/", 1)[-1]: entry["time"] for entry in reversed(report.timeline)}
    assert times["idle"] == 0
    assert times["turn"] == pytest.approx(9, abs=0.05)
