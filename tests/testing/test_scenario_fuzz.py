"""Whatever a scenario file holds, checking it answers with findings that have a place.

``HUMANOID_BT_MUTATIONS=20000 pytest tests/testing/test_scenario_fuzz.py`` tries more files than usual.
"""

from __future__ import annotations

import os
import random
from pathlib import Path

import pytest

from humanoid_bt.campaign.check_files import KINDS
from humanoid_bt.checking.check import checked
from humanoid_bt.core.errors import relative
from humanoid_bt.files.workspace import Workspace, builtin_root
from tests.testing.test_scenario import WHOLE
from tests.tree.mutations import Mutator

MUTATIONS = int(os.environ.get("HUMANOID_BT_MUTATIONS", "80"))
BATCHES = 2


@pytest.mark.parametrize("batch", range(BATCHES))
def test_a_broken_scenario_is_answered_with_places(batch: int, tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    path = tmp_path / "scenarios" / "broken.yaml"
    path.parent.mkdir()
    files = [*Workspace(builtin_root()).trees().values(), *Workspace(builtin_root()).scenarios().values()]
    seeds = [WHOLE, *(file.read_text(encoding="utf-8") for file in builtin_root().glob("scenarios/*.yaml"))]
    choose, mutator, clean = random.Random(batch), Mutator(batch), 0
    for number in range(MUTATIONS // BATCHES):
        path.write_bytes(mutator.mutate(choose.choice(seeds), choose.choice(seeds)))
        try:
            problems = checked(path, workspace, KINDS)
        except BaseException as error:
            error.add_note(f"batch {batch}, file {number}:\n{path.read_bytes()!r}")
            raise
        clean += not problems
        for problem in problems:
            told = f"batch {batch}, file {number}: {problem}\n{path.read_bytes()!r}"
            assert problem.place is not None, told
            assert problem.place.file in {relative(path), *map(relative, files)}, told
            assert problem.place.line >= 1 and problem.place.column >= 1, told
            f"{problem}".encode()  # it can be written to a file
    assert 1 <= clean <= 0.7 * MUTATIONS / BATCHES
