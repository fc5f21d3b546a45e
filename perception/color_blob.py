"""Find something by its colour in the picture of the head camera."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Literal

import numpy as np
from scipy import ndimage

from humanoid_bt import Moment, Percept, PerceptName, PerceptSource, Picture, param, rotation_matrix

_HUES = {"red": 0.0, "orange": 28.0, "yellow": 52.0, "green": 130.0, "blue": 215.0, "purple": 280.0}  # deg
_MIDDLE = 2 / 3  # of its radius, which a ball's middle lies behind the mean of the half that is seen
_FEW = 2.0  # pixels that say half as much as many
_SURE = 0.98  # confidence of a whole disc of many pixels in just the colour
_WHOLE = 0.75  # share of the disc from which its place counts as well seen
_BEFORE = 0.5  # share of where it was that something must cover for it to count as hidden


class ColorBlob(PerceptSource):
    """Find the largest blob of a colour in the head camera's picture: a ball, or what is as round.

    Its place is where the depth of the picture puts its middle, seen from where control believes the eyes to be. Its
    confidence is the product of three shares: how much its pixels say (few say little), how much of a whole disc is
    seen (less at the edge of the picture, or behind something), and how near its colour is.

    While something nearer covers it, such as the hand that reaches for it, it is published where it was last well seen,
    with a confidence that falls to nothing in `memory`. Where the picture shows that it is gone, and where it is out of
    the picture, nothing is published, and the percept grows old.
    """

    needs = ("camera", "state")
    rate = 5.0

    target: PerceptName = param("target", doc="Percept that it publishes.")
    color: Literal["red", "orange", "yellow", "green", "blue", "purple"] = param("orange", doc="What to look for.")
    tolerance: float = param(0.25, unit="rad", above=0, maximum=1.0, doc="How far its hue may be from that colour's.")
    saturation: float = param(0.45, minimum=0, maximum=1, doc="How colourful it is at least, from grey 0 to pure 1.")
    pixels: int = param(3, minimum=1, doc="Fewest pixels of it.")
    farthest: float = param(5.0, unit="m", above=0, doc="Farther away it is not looked for.")
    memory: float = param(10.0, unit="s", above=0, doc="How long it is believed to be behind what covers it.")

    def setup(self) -> None:
        """Begin with nothing seen."""
        self._seen: tuple[Percept, float] | None = None  # in the world, and its radius

    def look(self, now: Moment) -> Iterable[Percept]:
        """Return the largest blob, if there is one, or where it is hidden."""
        picture = now.picture
        rows, columns, off = self._blob(picture)
        whole = _whole(picture, rows, columns) if len(rows) >= self.pixels else 0.0
        turn, base = rotation_matrix(now.state.base_quaternion), now.state.base_position
        if whole < _WHOLE and (hidden := self._hidden(now.time, picture, turn, base)) is not None:
            return [hidden]
        if not whole:
            return []
        seen, radius = self._percept(now.time, picture, rows, columns, whole * (1 - 0.5 * off / self.tolerance))
        if whole >= _WHOLE:
            place, spread = base + turn @ seen.position, turn @ seen.covariance @ turn.T
            self._seen = replace(seen, position=place, covariance=spread), radius
        return [seen]

    def _percept(
        self, time: float, picture: Picture, rows: np.ndarray, columns: np.ndarray, share: float
    ) -> tuple[Percept, float]:
        """Return what pixels show, and its radius [m]."""
        depth = float(picture.depth[rows, columns].mean())
        pixel = depth / picture.focal  # what one is wide there [m]
        radius = math.sqrt(len(rows) / math.pi) * pixel
        column, row = columns.mean(), rows.mean()
        ray = picture.rays(column, row)
        along = np.outer(ray, ray) / (ray @ ray)
        spread = pixel**2 / len(rows) * (np.eye(3) - along) + (0.5 * radius) ** 2 * along
        position = picture.point(column, row, depth + _MIDDLE * radius)
        confidence = _SURE * len(rows) / (len(rows) + _FEW) * share
        return Percept(self.target, time, position, confidence, class_name="ball", covariance=spread), radius

    def _hidden(self, time: float, picture: Picture, turn: np.ndarray, base: np.ndarray) -> Percept | None:
        """Return it where it was last well seen if something covers it there, None if nothing does."""
        if self._seen is None:
            return None
        last, radius = self._seen
        position = turn.T @ (last.position - base)
        depth, left, up = picture.rotation.T @ (position - picture.position)
        left_over = 1 - (time - last.stamp) / self.memory
        if depth < radius or left_over <= 0:
            return None
        width, height = picture.size
        column = (width - 1) / 2 - left / depth * picture.focal
        row = (height - 1) / 2 - up / depth * picture.focal
        around = max(1.0, radius / depth * picture.focal)
        rows, columns = np.mgrid[0:height, 0:width]
        disc = (rows - row) ** 2 + (columns - column) ** 2 <= around**2
        if not disc.any() or (picture.depth[disc] < depth + radius).mean() < _BEFORE:
            return None
        spread = turn.T @ last.covariance @ turn
        return replace(last, stamp=time, position=position, confidence=last.confidence * left_over, covariance=spread)

    def _blob(self, picture: Picture) -> tuple[np.ndarray, np.ndarray, float]:
        """Return rows and columns of the largest blob of the colour, and how far its hue is from it [rad]."""
        color = picture.color
        brightest, darkest = color.max(axis=-1), color.min(axis=-1)
        rows, columns = np.nonzero((brightest > 25) & (brightest - darkest > self.saturation * brightest))
        red, green, blue = color[rows, columns].T.astype(float)
        hue = np.arctan2(math.sqrt(3) * (green - blue), 2 * red - green - blue)
        off = np.abs((hue - math.radians(_HUES[self.color]) + math.pi) % (2 * math.pi) - math.pi)
        near = (off < self.tolerance) & (picture.depth[rows, columns] < self.farthest)
        rows, columns, off = rows[near], columns[near], off[near]
        blob = _largest(rows, columns)
        rows, columns, off = rows[blob], columns[blob], off[blob]
        if not len(rows):
            return rows, columns, 0.0
        depths = picture.depth[rows, columns]
        middle = np.median(depths)
        body = np.abs(depths - middle) < 0.3 * middle  # without pixels at its rim that show what is behind it
        return rows[body], columns[body], float(off[body].mean())


def _whole(picture: Picture, rows: np.ndarray, columns: np.ndarray) -> float:
    """Return how much of a whole disc is seen, from 0 to 1."""
    across = max(np.ptp(rows), np.ptp(columns)) + 1
    whole = min(1.0, len(rows) / (math.pi / 4 * across**2) + 1 / across)  # a small disc has no round rim
    width, height = picture.size
    at_edge = rows.min() == 0 or columns.min() == 0 or rows.max() == height - 1 or columns.max() == width - 1
    return whole * (0.5 if at_edge else 1.0)  # nobody knows how much of it is outside


def _largest(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return which pixels are those of the largest part that hangs together, as a mask."""
    if not len(rows):
        return np.zeros(0, dtype=bool)
    at = rows - rows.min(), columns - columns.min()
    mask = np.zeros((np.ptp(rows) + 1, np.ptp(columns) + 1), dtype=bool)
    mask[at] = True
    found = ndimage.label(mask)[0][at]
    return np.asarray(found == np.bincount(found).argmax())
