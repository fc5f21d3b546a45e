"""What is bound counts as it is when the function is called, and only if it is what compiled code takes it for."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.core.bindable import bindable


@bindable("f8(f8, f8[::1])", "f8, i8, b1, f8[:, ::1], f8[::1]")
def _dot(
    factor: float, vector: np.ndarray, offset: float, row: int, twice: bool, rows: np.ndarray, kept: np.ndarray
) -> float:
    kept[:] = rows[row]
    total = offset
    for place in range(len(vector)):
        total += rows[row, place] * vector[place]
    return factor * total * (2 if twice else 1)


def test_arrays_that_are_bound_are_read_and_written_where_they_are() -> None:
    rows, kept = np.arange(6.0).reshape(2, 3), np.zeros(3)
    dot = _dot.bind(0.5, 1, True, rows, kept)
    assert dot(10.0, np.array([1.0, 2.0, 3.0])) == 10.0 * (26.0 + 0.5) * 2
    np.testing.assert_array_equal(kept, [3.0, 4.0, 5.0])
    rows[1] = 1.0
    assert dot(1.0, np.ones(3)) == 7.0
    np.testing.assert_array_equal(kept, 1.0)


def test_each_bound_function_has_its_own_arrays() -> None:
    one, other = (_dot.bind(0.0, 0, False, np.full((1, 2), value), np.zeros(2)) for value in (1.0, 2.0))
    assert (one(1.0, np.ones(2)), other(1.0, np.ones(2))) == (2.0, 4.0)


@pytest.mark.parametrize(
    "rows", [np.zeros((2, 3), int), np.zeros(3), np.zeros((3, 2)).T, np.zeros((2, 6))[:, ::2]], ids=str
)
def test_an_array_of_another_type_is_not_bound(rows: np.ndarray) -> None:
    with pytest.raises(TypeError, match="is not"):
        _dot.bind(0.0, 0, False, rows, np.zeros(3))


def test_arguments_that_are_missing_or_too_many_are_not_bound() -> None:
    for arguments in ((), (0.0, 0, False, np.zeros((2, 3)), np.zeros(3), 1.0)):
        with pytest.raises(ValueError, match="zip"):
            _dot.bind(*arguments)


def test_code_is_made_anew_where_what_it_takes_from_elsewhere_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "bound_it.py").write_text(
        "from humanoid_bt.core.bindable import bindable\nfrom part_of_bound import FACTOR\n"
        '@bindable("f8()", "f8[::1]")\ndef it(values):\n    return FACTOR * values[0]\n'
    )
    monkeypatch.syspath_prepend(tmp_path)
    for factor in (2.0, 3.25, 3.25):  # of another length, for Python looks at that and at the second
        (tmp_path / "part_of_bound.py").write_text(f"FACTOR = {factor}\n")
        for name in ("part_of_bound", "bound_it"):
            monkeypatch.delitem(sys.modules, name, raising=False)
        importlib.invalidate_caches()
        assert importlib.import_module("bound_it").it.bind(np.ones(1))() == factor
