"""Which names a pattern means."""

from __future__ import annotations

import pytest

from humanoid_bt.core.patterns import matching


@pytest.mark.parametrize(
    ("pattern", "means"),
    [
        ("knee[left]", ["knee[left]"]),
        ("knee*", ["knee[left]", "knee_left"]),
        ("knee_[lr]*", ["knee_left"]),
        ("Knee*", []),
    ],
)
def test_a_pattern_means_a_name_as_it_is_or_by_its_signs(pattern: str, means: list[str]) -> None:
    assert matching(["knee[left]", "hip", "knee_left"], pattern) == means
