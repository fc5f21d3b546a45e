"""Lists that keep their beginning and their end."""

from __future__ import annotations

from humanoid_bt.core.kept import Kept


def test_few_entries_are_all_kept() -> None:
    kept: Kept[int] = Kept(10)
    for number in range(10):
        kept.append(number)
    assert (kept, kept.left_out, kept.total) == (list(range(10)), 0, 10)


def test_of_many_the_first_and_the_latest_are_kept() -> None:
    kept: Kept[int] = Kept(10)
    for number in range(1000):
        kept.append(number)
        assert len(kept) <= 10
    assert kept[:5] == [0, 1, 2, 3, 4]
    assert kept[5:] == list(range(996, 1000)) or kept[5:] == list(range(995, 1000))
    assert kept.left_out + len(kept) == kept.total == 1000


def test_nothing_new_is_missed() -> None:
    kept: Kept[int] = Kept(10)
    seen: list[int] = []
    told = 0
    for number in range(1000):
        kept.append(number)
        if number % 3 == 0:
            seen += kept.since(told)
            told = kept.total
    assert seen == list(range(1000))
    assert kept.since(told) == []
