"""Runs whose options are odd."""

from __future__ import annotations

from typing import Any

import pytest

import humanoid_bt as hbt


@pytest.mark.parametrize("perception", [{1: {}}, {"color_blob": {1: 2}}])
def test_what_is_no_text_is_no_name_of_a_source_or_a_parameter(perception: Any) -> None:
    with pytest.raises(hbt.UserError, match="1"):
        hbt.Session("fetch", perception=perception)


@pytest.mark.parametrize("pace", [1e-12, 5e-324, 1e-4])
def test_a_pace_at_which_nothing_moves_is_refused(pace: float) -> None:
    with pytest.raises(hbt.UserError, match=r"'pace' must be a number from 0\.001 on"):
        hbt.Session("fetch", pace=pace)
