"""Arrays where every microsecond counts."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from humanoid_bt.core.messages import Array


def numbers(array: Array) -> memoryview[float]:
    """Return an array's own numbers: they copy each other, and take single ones, in a third of the time.

    Args:
        array: of one axis, its numbers one after the other, which lie where they are for good.
    """
    return cast("memoryview[float]", array.data)
