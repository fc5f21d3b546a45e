"""What can be said of many trials: how sure a rate is, how a quantity is spread, and what is beyond chance.

Intervals and tests are exact or nearly so for the few hundred trials that campaigns have, and short enough to be read:

- Wilson's score interval: E. B. Wilson, Probable Inference, the Law of Succession, and Statistical Inference, J. Am.
  Stat. Assoc. 22 (1927). It never leaves 0 to 1, and is right for rates near the ends, as L. D. Brown, T. T. Cai and
  A. DasGupta show in Interval Estimation for a Binomial Proportion, Statistical Science 16 (2001).
- McNemar's test for pairs, with its exact (binomial) distribution: Q. McNemar, Psychometrika 12 (1947). The sign test
  of a quantity is the same test, of which of a pair is the larger one.
- Holm's correction where several things are tested at once: S. Holm, Scandinavian J. of Statistics 6 (1979).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, islice, takewhile
from typing import NamedTuple

CONFIDENCE = 0.95
"""Of every interval; what is less likely than the rest of it by chance alone is beyond chance."""

CHANCE = 1 - CONFIDENCE

_Z = 1.959963984540054  # quantile of the normal distribution: 95 % lie within so many deviations


class Interval(NamedTuple):
    """Two ends, between which a number lies as surely as :data:`CONFIDENCE` says."""

    low: float
    high: float


@dataclass(frozen=True)
class Rate:
    """How many of some.

    Attributes:
        count: how many.
        of: of how many.
    """

    count: int
    of: int

    @property
    def share(self) -> float:
        """From 0 to 1; NaN of none."""
        return self.count / self.of if self.of else math.nan

    @property
    def interval(self) -> Interval:
        """Wilson's 95 % interval of the rate behind it."""
        return wilson(self.count, self.of)


def wilson(count: int, of: int) -> Interval:
    """Return Wilson's 95 % score interval of a rate, from 0 to 1 if nothing was tried."""
    if of == 0:
        return Interval(0.0, 1.0)
    share, z2 = count / of, _Z * _Z
    middle = (share + z2 / (2 * of)) / (1 + z2 / of)
    half = _Z / (1 + z2 / of) * math.sqrt(share * (1 - share) / of + z2 / (4 * of * of))
    low = 0.0 if count == 0 else max(0.0, middle - half)
    return Interval(low, 1.0 if count == of else min(1.0, middle + half))


def binomial_p(one: int, other: int) -> float:
    """Return how likely it is by chance that pairs fall so unevenly to two sides, or more so.

    Exact, for both directions. With the numbers of pairs in which only one of two succeeded this is McNemar's test.
    """
    trials, fewer = one + other, min(one, other)
    tail = sum(islice(_ways(trials), fewer + 1))
    return min(1.0, float(2 * tail / 2**trials))


def _ways(number: int) -> Iterator[int]:
    """Yield in how many ways 0, 1, 2, ... can be chosen from a number of things."""
    ways = 1
    for chosen in range(number + 1):
        yield ways
        ways = ways * (number - chosen) // (chosen + 1)


def holm(chances: Mapping[str, float]) -> dict[str, float]:
    """Return the p of several tests, raised so that any is below a bound by chance only as rarely as it says."""
    adjusted: dict[str, float] = {}
    highest = 0.0
    for rank, (name, p) in enumerate(sorted(chances.items(), key=lambda entry: (entry[1], entry[0]))):
        highest = max(highest, min(1.0, p * (len(chances) - rank)))
        adjusted[name] = highest
    return {name: adjusted[name] for name in chances}


@dataclass(frozen=True)
class Spread:
    """How the values of a quantity are spread.

    Attributes:
        values: all of them, the smallest first.
    """

    values: tuple[float, ...]

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        """Return the spread of values; those that are no numbers are left out."""
        return cls(tuple(sorted(value for value in values if math.isfinite(value))))

    def quantile(self, share: float) -> float:
        """Return the value that so much of all lies below, between two values in proportion; NaN of none."""
        if not self.values:
            return math.nan
        place = share * (len(self.values) - 1)
        below = math.floor(place)
        low, high = self.values[below], self.values[min(below + 1, len(self.values) - 1)]
        return low + (place - below) * (high - low)


QUANTILES: Mapping[str, float] = {"min": 0.0, "p5": 0.05, "median": 0.5, "p95": 0.95, "max": 1.0}
"""Names of the quantiles that are told."""


def median_interval(values: Sequence[float]) -> Interval:
    """Return an interval of the median behind some values, from their order alone; no assumption on how they spread.

    Its ends are the values that the median is outside of with at most half of what is left to chance; infinite where
    there are too few to tell.
    """
    ordered = Spread.of(values).values
    number = len(ordered)
    rare = 2**number // round(2 / CHANCE)  # of so many equally likely ways to lie on two sides, at each end
    outside = sum(1 for _ in takewhile(lambda tail: tail <= rare, accumulate(_ways(number)))) - 1
    if outside < 0:
        return Interval(-math.inf, math.inf)
    return Interval(ordered[outside], ordered[number - 1 - outside])
