"""What is compiled does the same as the Python function that it was made from."""

from __future__ import annotations

import importlib
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.core.compiled import compiled


def test_arithmetic_is_numpys() -> None:
    @compiled("f8(f8, f8)")
    def share(part: float, whole: float) -> float:
        return part / whole

    assert share(1.0, 4.0) == 0.25
    assert math.isinf(share(1.0, 0.0))
    assert math.isnan(share(0.0, 0.0))


def test_nothing_is_reordered() -> None:
    @compiled("f8(f8[::1])")
    def total(values: np.ndarray) -> float:
        found = 0.0
        for value in values:
            found += value
        return found

    values = np.random.default_rng(3).normal(size=999) * 10.0 ** np.arange(999)[::-1].clip(0, 12)
    one_by_one = 0.0
    for value in values.tolist():
        one_by_one += value
    assert total(values) == one_by_one


def test_a_function_that_cannot_be_kept_is_compiled_all_the_same() -> None:
    """As in a container that can only be read: here there is no file to keep it beside."""
    found: dict = {}
    exec("def double(value): return 2 * value", found)
    assert compiled("f8(f8)")(found["double"])(1.5) == 3.0


def test_only_what_is_compiled_is_told_however_long_it_takes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[bool] = []
    monkeypatch.setattr("humanoid_bt.core.compiled._NOTICED", -1.0)  # a machine so busy that all takes long
    monkeypatch.setattr("humanoid_bt.core.compiled._tell", lambda: told.append(True))
    monkeypatch.syspath_prepend(tmp_path)
    text = 'from humanoid_bt.core.compiled import compiled\n@compiled("f8(f8)")\ndef it(value):\n    return value\n'
    (tmp_path / "slowly.py").write_text(text)
    module = importlib.import_module("slowly")
    assert told == [True]
    importlib.reload(module)
    assert told == [True]


@pytest.mark.parametrize(("before", "after"), [("2 * value", "3 * value"), ("2 * value", "FACTOR * value")])
def test_code_is_made_anew_where_something_that_it_takes_from_elsewhere_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, before: str, after: str
) -> None:
    """numba looks only at the file of the function itself."""
    part, whole = tmp_path / "part_of_it.py", tmp_path / "whole_of_it.py"
    text = "from humanoid_bt.core.compiled import {0}\n{1}\n@{2}\ndef {3}(value):\n    return {4}\n"
    whole.write_text(
        text.format(
            "compiled", "from part_of_it import FACTOR, more", 'compiled("f8(f8)")', "it", "more(value) + FACTOR"
        )
    )
    monkeypatch.syspath_prepend(tmp_path)

    def made() -> float:
        for name in ("part_of_it", "whole_of_it"):
            monkeypatch.delitem(sys.modules, name, raising=False)
        importlib.invalidate_caches()
        return float(importlib.import_module("whole_of_it").it(1.0))

    part.write_text(text.format("inlined", "FACTOR = 5", "inlined", "more", before))
    assert made() == made() == 7
    part.write_text(text.format("inlined", "FACTOR = 5.0", "inlined", "more", after))
    assert made() == {"3 * value": 8, "FACTOR * value": 10}[after]
    part.write_text(text.format("inlined", "FACTOR = 6.0", "inlined", "more", before))
    assert made() == 8


def test_what_simulates_nothing_does_not_load_the_compiler() -> None:
    modules = "humanoid_bt.cli.check, humanoid_bt.cli.explain, humanoid_bt.session.session"
    modules += ", humanoid_bt.record.recorder_process, humanoid_bt.realtime.perception_process"
    code = f"import sys, {modules}; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
