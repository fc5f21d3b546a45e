"""What is compiled does the same as the Python function that it was made from."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np

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


def test_what_simulates_nothing_does_not_load_the_compiler() -> None:
    modules = "humanoid_bt.cli.check, humanoid_bt.cli.explain, humanoid_bt.session.session"
    modules += ", humanoid_bt.record.recorder_process, humanoid_bt.realtime.perception_process"
    code = f"import sys, {modules}; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
