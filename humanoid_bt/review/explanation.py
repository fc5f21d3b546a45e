"""An explanation: what a person reads on one screen, and the same as data for programs."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

from humanoid_bt.core.plain import plain
from humanoid_bt.core.texts import printable
from humanoid_bt.review.cause import Row

_WIDTH = 80
_NAME = 11  # columns of a row's name
_BESIDE = 40  # columns that a text must have beside its name


class Moment(NamedTuple):
    """Something that happened: when [s], and what."""

    time: float
    text: str


@dataclass(frozen=True)
class Explanation:
    """What was found out about a run.

    Attributes:
        recording: its file.
        kind: what sort of cause it is: fall, push, estop, exception, timeout, percept_lost, success, and so on; or
            what was asked for: moment, node, joint.
        headline: the cause in one sentence, with time, node and quantity.
        time: the moment to look at [s], None if there is none.
        node: path of the node behind it, "" if there is none.
        place: where that node stands: file, line and column.
        rows: what shows it: name and text.
        title: what the moments are.
        moments: what led up to it.
        after: what control did, where to look, what would help.
        data: numbers behind it, for programs.
    """

    recording: str
    kind: str
    headline: str
    time: float | None = None
    node: str = ""
    place: str = ""
    rows: list[Row] = field(default_factory=list)
    title: str = ""
    moments: list[Moment] = field(default_factory=list)
    after: list[Row] = field(default_factory=list)
    data: dict[str, Any] = field(default_factory=dict)

    def text(self, width: int = _WIDTH) -> str:
        """Return it as lines of text, at most so many columns wide where words allow."""
        return printable("\n".join(self._lines(width)))

    def _lines(self, width: int) -> Iterator[str]:
        yield from textwrap.wrap(self.headline, width, break_long_words=False, break_on_hyphens=False)
        if self.rows:
            yield ""
            yield from _aligned(self.rows, width)
        if self.moments:
            yield ""
            yield self.title
            for moment in self.moments:
                yield from _hanging(f"{moment.time:9.3f} s  ", moment.text, width)
        if self.after:
            yield ""
            yield from _aligned(self.after, width)

    def __str__(self) -> str:
        return self.text()

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data for JSON."""
        values: dict[str, Any] = plain(asdict(self))  # numbers that are none become text
        values["rows"] = [{"name": name, "text": text} for name, text in self.rows]
        values["moments"] = [{"time": plain(moment.time), "text": moment.text} for moment in self.moments]
        values["after"] = [{"name": name, "text": text} for name, text in self.after]
        return values


def _aligned(rows: Iterable[Row], width: int) -> Iterator[str]:
    for name, text in rows:
        yield from _hanging(f"{name:<{_NAME - 1}} ", text, width)


def _hanging(head: str, text: str, width: int) -> Iterator[str]:
    room = max(width - len(head), _BESIDE)
    lines = textwrap.wrap(text, room, break_long_words=False, break_on_hyphens=False) or [""]
    yield (head + lines[0]).rstrip()
    for line in lines[1:]:
        yield " " * len(head) + line
