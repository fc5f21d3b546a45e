"""The picture of the two ways: a percept's up to a skill, a command's down from it, through the processes between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from house.drawing import PART, SMALL, TEXT, TITLE, WIDTH, box, line, paragraph, picture, words
from house.ways import COMMAND, PERCEPT, Step
from humanoid_bt.core import clock

_LEFT, _RIGHT, _MIDDLE = 20.0, WIDTH - 20.0, WIDTH / 2
_TOP = 68.0  # of the decision process
_ARCH = 38.0  # from there to the arch
_DECISION_HEAD, _HEAD = 66.0, 34.0  # from the top of a process to its first step
_ROW = 63.0  # from one step to the next
_FOOT = 10.0  # between a process and what is between processes
_GUTTER = 8.0  # between the two columns
_DOT = 11.0  # radius of a number's disc
_WAY_AT, _TEXT_AT = 28.0, 50.0  # x of the line and of the text, from the left side of their column
_COLUMN = _MIDDLE - _LEFT - _GUTTER / 2
_TEXT_WIDTH = _COLUMN - _TEXT_AT - 12.0
_BEND = 18.0  # radius of the turns of a line
_LOCKSTEP = "In realtime mode; in lockstep all of it is one process, and messages are handed over as they are."
_BACK = 26.0  # from the lowest process to the line that leads back


@dataclass(frozen=True)
class _Column:
    """One way.

    Attributes:
        kind: percept or command.
        x: of its left side.
        steps: from top to bottom, with their numbers.
        process: what is below decision: its kind in the style, and its name.
    """

    kind: str
    x: float
    steps: Sequence[tuple[int, Step]]
    process: tuple[str, str]

    @property
    def way(self) -> float:
        """X of the line."""
        return self.x + _WAY_AT

    @property
    def _crossing(self) -> int:
        """Index of the step between two processes."""
        return next(i for i, (_, step) in enumerate(self.steps) if step.between)

    @property
    def decision_ends(self) -> float:
        """Y of the lower side of decision."""
        return _TOP + _DECISION_HEAD + (self._crossing - 0.5) * _ROW + _DOT

    @property
    def _process_begins(self) -> float:
        return self.decision_ends + _ROW

    @property
    def bottom(self) -> float:
        """Y of the lower side of the other process."""
        return self.y(len(self.steps) - 1) + _ROW / 2 + _FOOT

    def y(self, index: int) -> float:
        """Return the y of a number."""
        first = _TOP + _DECISION_HEAD
        if index < self._crossing:
            return first + index * _ROW
        if index == self._crossing:
            return self.decision_ends + _FOOT + _DOT
        return self._process_begins + _HEAD + (index - self._crossing - 1) * _ROW + _DOT

    def draw(self) -> list[str]:
        """Return the process below decision, the way and its steps."""
        kind, name = self.process
        begins = self._process_begins
        parts = [
            box(self.x, begins, _COLUMN, self.bottom - begins, kind=kind, radius=8),
            words(name, self.x + _TEXT_AT, begins + 8, SMALL),
            line(f"M{self.way:g} {self.y(0):.1f}V{self.y(len(self.steps) - 1):.1f}", f"way {self.kind}-line"),
        ]
        for index, (number, step) in enumerate(self.steps):
            parts += self._step(number, step, self.y(index))
        return parts

    def _step(self, number: int, step: Step, y: float) -> list[str]:
        x, top = self.x + _TEXT_AT, y - PART.line / 2
        look = "between" if step.between else "number"
        return [
            f'<circle class="{self.kind}-{look} {self.kind}-line" cx="{self.way:g}" cy="{y:.1f}" r="{_DOT:g}"/>',
            words(str(number), self.way, top, PART, anchor="middle", kind=look),
            words(step.file, x, top, PART),
            words(step.name, x + PART.width(step.file) + 8, top, SMALL),
            *paragraph(SMALL.wrap(step.does.replace("`", ""), _TEXT_WIDTH), x, top + PART.line + 1, SMALL),
        ]


def draw() -> str:
    """Return the picture."""
    rates = f"servo {_rate(clock.SERVO_PERIOD)}, whole body {_rate(clock.WHOLE_BODY_PERIOD)}"
    up = _Column(
        "percept",
        _LEFT,
        [(i + 1, step) for i, step in reversed(list(enumerate(PERCEPT)))],
        ("other", f"perception process, {_rate(clock.PERCEPTION_PERIOD)}"),
    )
    down = _Column(
        "command",
        _MIDDLE + _GUTTER / 2,
        [(i + 1, step) for i, step in enumerate(COMMAND)],
        ("sober", f"control process: {rates}"),
    )
    bottom = max(up.bottom, down.bottom)
    parts = [
        words("From a percept to a moving joint", _MIDDLE, 14, TITLE, anchor="middle"),
        words(_LOCKSTEP, _MIDDLE, 40, TEXT, anchor="middle"),
        _decision(up, down),
        words(f"decision process, {_rate(clock.DECISION_PERIOD)}", _MIDDLE, _TOP + 9, SMALL, anchor="middle"),
        *_arch(up, down),
        *up.draw(),
        *down.draw(),
        *_way_back(up, down, bottom),
    ]
    return picture("The way of a percept and of a command", bottom + _BACK + 30, parts)


def _decision(up: _Column, down: _Column) -> str:
    """Return decision, which both ways go through, as far down as each of them does."""
    corner = 8.0
    left, right, inner = up.decision_ends, down.decision_ends, down.x - _GUTTER
    path = (
        f"M{_LEFT:g} {_TOP + corner:g}q0 {-corner:g} {corner:g} {-corner:g}H{_RIGHT - corner:g}"
        f"q{corner:g} 0 {corner:g} {corner:g}V{right - corner:.1f}q0 {corner:g} {-corner:g} {corner:g}"
        f"H{inner:g}V{left - corner:.1f}q0 {corner:g} {-corner:g} {corner:g}H{_LEFT + corner:g}"
        f"q{-corner:g} 0 {-corner:g} {-corner:g}z"
    )
    return line(path, "room")


def _arch(up: _Column, down: _Column) -> list[str]:
    """Return the two lines above the first steps, which meet at a skill."""
    y, meet = _TOP + _ARCH, (up.way + down.way) / 2
    return [
        line(f"M{way:g} {first:.1f}V{y + _BEND:g}q0 {-_BEND:g} {turn:g} {-_BEND:g}H{meet:g}", f"way {kind}-line")
        for kind, way, first, turn in (
            (up.kind, up.way, up.y(0), _BEND),
            (down.kind, down.way, down.y(0), -_BEND),
        )
    ]


def _way_back(up: _Column, down: _Column, bottom: float) -> list[str]:
    """Return the line from the joints that move to what is seen next."""
    y = bottom + _BACK
    last = len(up.steps) - 1
    path = (
        f"M{down.way:g} {down.y(len(down.steps) - 1) + _DOT:.1f}V{y - _BEND:.1f}q0 {_BEND:g} {-_BEND:g} {_BEND:g}"
        f"H{up.way + _BEND:g}q{-_BEND:g} 0 {-_BEND:g} {-_BEND:g}V{up.y(last) + _DOT + 4:.1f}m-5 6l5 -6l5 6"
    )
    return [
        line(path, "back"),
        words("the robot moves, and sees again", _MIDDLE / 2 + _WAY_AT, y + 4, SMALL, anchor="middle"),
    ]


def _rate(period: float) -> str:
    return f"{1 / period:g} Hz"
