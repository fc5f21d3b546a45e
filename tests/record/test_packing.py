"""Blocks of samples: small, within their resolution, and never read when they are damaged."""

from __future__ import annotations

import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from humanoid_bt.record import packing
from humanoid_bt.record.packing import BlockError, bundle, is_whole, pack, unbundle, unpack

RESOLUTION = np.array([1e-5, 1e-3, 1.0])
NUMBERS = st.floats(-1e4, 1e4)


def smooth(rows: int) -> np.ndarray:
    """Return what a moving joint measures: angle, torque, and which command is in force."""
    time = np.arange(rows) * 1e-3
    return np.stack([np.sin(3 * time), 20 * np.cos(5 * time), np.floor(time * 50)], axis=1)


@given(block=arrays(float, st.tuples(st.integers(0, 40), st.just(3)), elements=NUMBERS))
@settings(max_examples=50, deadline=None, derandomize=True, database=None)
def test_what_comes_back_is_within_half_the_resolution(block: np.ndarray) -> None:
    back = unpack(pack(block, RESOLUTION), RESOLUTION)
    assert back.shape == block.shape
    assert (np.abs(back - block) <= 0.5 * RESOLUTION * (1 + 1e-6)).all()


def test_steps_over_the_whole_range_come_back() -> None:
    far = np.array([[1e4, -1e5, 1e9], [-1e4, 1e5, -1e9]] * 3)
    np.testing.assert_allclose(unpack(pack(far, RESOLUTION), RESOLUTION), far, atol=1.0)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
def test_what_has_no_rounded_form_is_exact(value: float) -> None:
    block = smooth(50)
    block[17, 1] = value
    np.testing.assert_array_equal(unpack(pack(block, RESOLUTION), RESOLUTION), block)


def test_a_second_of_a_moving_joint_takes_a_tenth_of_its_numbers() -> None:
    block = smooth(1000)
    assert len(pack(block, RESOLUTION)) < 0.1 * block.nbytes


@pytest.mark.parametrize("last", [0.0, np.inf])
def test_every_damage_is_noticed(last: float) -> None:
    block = smooth(20)
    block[-1, -1] = last
    whole = pack(block, RESOLUTION)
    cut = [whole[:end] for end in range(len(whole))]
    flipped = [
        whole[:at] + bytes([whole[at] ^ 1 << bit]) + whole[at + 1 :] for at in range(len(whole)) for bit in range(8)
    ]
    assert is_whole(whole, bundled=False)
    for damaged in [*cut, *flipped]:
        assert not is_whole(damaged, bundled=False)
        with pytest.raises(BlockError):
            unpack(damaged, RESOLUTION)


def test_a_block_of_other_columns_is_refused() -> None:
    with pytest.raises(BlockError, match="3 columns, not 2"):
        unpack(pack(smooth(5), RESOLUTION), RESOLUTION[:2])


def test_what_older_versions_compressed_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packing, "_compressed", zlib.compress)
    block, messages = smooth(50), [b"one", b"", b"two" * 100]
    old = pack(block, RESOLUTION), bundle(messages)
    monkeypatch.undo()
    assert (len(old[0]), len(old[1])) != (len(pack(block, RESOLUTION)), len(bundle(messages)))
    np.testing.assert_array_equal(unpack(old[0], RESOLUTION), unpack(pack(block, RESOLUTION), RESOLUTION))
    assert unbundle(old[1]) == messages
