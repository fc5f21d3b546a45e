"""Writing the tokens of YAML text again, with other blanks between them."""

from __future__ import annotations

import re
from dataclasses import dataclass

import yaml

from humanoid_bt.files.formatting.lines import Line, aligned, display_width
from humanoid_bt.files.formatting.tokens import Piece, pieces

INDENT = 2
"""Columns per level."""

_OPENS = (yaml.FlowMappingStartToken, yaml.FlowSequenceStartToken)
_CLOSES = (yaml.FlowMappingEndToken, yaml.FlowSequenceEndToken)
_AT_MARGIN = (yaml.DirectiveToken, yaml.DocumentStartToken, yaml.DocumentEndToken, yaml.StreamEndToken)
_AT_LEVEL = (yaml.BlockEntryToken, yaml.KeyToken, yaml.ValueToken)
_REST_IS_EMPTY = re.compile(r" *(#|\n)")


def write(text: str) -> str:
    """Return YAML text that can be read with other blanks between its tokens.

    Args:
        text: the YAML text, its lines ending in LF, without byte order mark.

    Raises:
        yaml.YAMLError: it is no valid YAML.
    """
    return _Writer(text).write()


@dataclass(frozen=True, eq=False)
class _Level:
    """A column, and where it stood in the source: of an open block mapping or list, or of a comment.

    Attributes:
        old: the column in the source.
        new: the column to be written.
        is_mapping: whether it is a block mapping's.
        is_indentless: whether it is that of a list in the column of its key, which has no tokens for its ends.
    """

    old: int
    new: int
    is_mapping: bool = False
    is_indentless: bool = False


@dataclass(frozen=True)
class _Flow:
    """An open flow mapping or list: the columns of lines inside of it, and of a line with its end."""

    content: int
    close: int


class _Writer:
    def __init__(self, text: str) -> None:
        self.text = text
        self.lines: list[Line] = []
        self.line = ""  # the one that is being written
        self.at_line_start = True  # whether the source goes on at the start of a line
        self.is_blank_due = False  # whether an empty line comes next
        self.ends_with_break = True

        self.levels: list[_Level] = []
        self.closed: list[_Level] = []  # those that ended since the last piece, innermost first
        self.has_opened = False  # whether one began since the last piece
        self.is_key = False  # whether a key of a block mapping comes next
        self.flows: list[_Flow] = []
        self.previous: Piece | None = None
        self.previous_level: _Level | None = None

    def write(self) -> str:
        for piece in pieces(self.text):
            if piece.source or isinstance(piece.token, yaml.StreamEndToken):
                self.piece(piece)
            else:
                self.structure(piece.token)
        return "\n".join(aligned(self.lines)) + "\n" * self.ends_with_break

    # What is open.

    def structure(self, token: yaml.Token) -> None:
        """Follow the begin and end of a block, and the begin of a key, which have no characters."""
        if isinstance(token, yaml.BlockMappingStartToken | yaml.BlockSequenceStartToken):
            self.open(token.start_mark.column, is_mapping=isinstance(token, yaml.BlockMappingStartToken))
        elif isinstance(token, yaml.BlockEndToken):
            self.close_indentless()
            self.closed.append(self.levels.pop())
        elif isinstance(token, yaml.KeyToken) and not self.flows:
            self.close_indentless()
            self.is_key = True

    def open(self, column: int, *, is_mapping: bool, is_indentless: bool = False) -> None:
        self.levels.append(_Level(column, self.below if self.levels else 0, is_mapping, is_indentless))
        self.has_opened = True

    def close_indentless(self) -> None:
        if self.levels and self.levels[-1].is_indentless:
            self.closed.append(self.levels.pop())

    @property
    def below(self) -> int:
        """The column of what stands on a line of its own in the innermost block, and begins no entry of it."""
        return self.levels[-1].new + INDENT if self.levels else INDENT

    def column(self, token: yaml.Token) -> int:
        """Return where a token stands that begins a line."""
        if isinstance(token, _AT_MARGIN) or not (self.flows or self.levels):
            return 0
        if self.flows:
            if isinstance(token, _CLOSES):
                return self.flows[-1].close
            return self.flows[-1].content + INDENT * self.is_after(yaml.ValueToken)
        return self.levels[-1].new if self.is_entry(token) else self.below

    def is_entry(self, token: yaml.Token) -> bool:
        """Whether a token outside of flow mappings and lists begins an entry of a block, or ends everything."""
        return self.is_key or isinstance(token, _AT_LEVEL + _AT_MARGIN)

    def is_after(self, *kinds: type[yaml.Token]) -> bool:
        return self.previous is not None and isinstance(self.previous.token, kinds)

    # Pieces.

    def piece(self, piece: Piece) -> None:
        token = piece.token
        if not self.flows and isinstance(token, yaml.BlockEntryToken) and self.levels[-1].is_mapping:
            self.open(token.start_mark.column, is_mapping=False, is_indentless=True)
        elif not self.flows and isinstance(token, yaml.KeyToken):
            self.close_indentless()
        self.gap(piece)
        if isinstance(token, _OPENS):
            self.open_flow(token.end_mark.index)
        elif isinstance(token, _CLOSES):
            self.flows.pop()
        if piece.is_block_scalar:
            self.block_scalar(piece)
        else:
            self.scalar(piece)
        self.closed.clear()
        self.has_opened = self.is_key = False
        self.previous, self.previous_level = piece, self.levels[-1] if self.levels else None

    def open_flow(self, end: int) -> None:
        """Open a flow mapping or list whose bracket ends there in the source: broken up, or beginning beside it."""
        if _REST_IS_EMPTY.match(self.text, end):
            base = self.flows[-1].content if self.flows else self.below - INDENT
            self.flows.append(_Flow(base + INDENT, base))
        else:
            column = display_width(self.line)
            self.flows.append(_Flow(column + 1, column))

    def scalar(self, piece: Piece) -> None:
        """Write a token; a text of several lines goes on below, where blanks at both ends of a line mean nothing."""
        blanks = " \t" if piece.source.startswith(('"', "'")) else " "
        first, *others = piece.source.split("\n")
        self.line += first if not others else _stripped_end(first, blanks)
        margin = " " * (self.flows[-1].content if self.flows else self.below)
        for number, line in enumerate(others, 1):
            self.end_line()
            inner = line.lstrip(blanks)
            if number < len(others):
                inner = _stripped_end(inner, blanks)
            self.line = margin + inner if inner else ""

    def block_scalar(self, piece: Piece) -> None:
        """Write a literal or folded text, whose lines move together."""
        indicators, comment = piece.header
        self.line += indicators
        self.end_line(comment, piece.token.start_mark.index + len(indicators))
        *body, last = piece.source.split("\n")[1:] or [""]
        if last:
            body.append(last)
            self.ends_with_break = "-" in indicators
        digit = re.search(r"\d", indicators)
        parent = self.levels[-1] if self.levels else _Level(0, 0)
        if digit:
            old, new = parent.old + int(digit[0]), parent.new + int(digit[0])
        else:
            old, new = _indentation(body), self.below
        while "+" not in indicators and body and len(body[-1]) <= old and not body[-1].strip(" "):
            body.pop()
            self.is_blank_due = True
        self.lines += [Line(" " * new + line[old:] if len(line) > old else "") for line in body]
        self.at_line_start = True

    # Gaps.

    def gap(self, piece: Piece) -> None:
        """Write what stands before a piece: comments, line breaks, a blank."""
        first, *others = piece.gap.split("\n")
        is_end = isinstance(piece.token, yaml.StreamEndToken)
        if self.at_line_start:
            others = [first, *others]
        elif first.strip() or others or is_end:
            self.end_line(first, piece.start)
        if is_end:
            self.own_lines(others, piece.token)
        elif others:
            self.own_lines(others[:-1], piece.token)
            self.put_blank()
            self.line = " " * self.column(piece.token)
        else:
            self.line += " " * self.has_blank_before(piece.token)
        self.at_line_start = isinstance(piece.token, yaml.StreamStartToken)

    def has_blank_before(self, token: yaml.Token) -> bool:
        """Whether a blank stands between a token and the one before it on its line."""
        if self.previous is None or self.is_after(*_OPENS):
            return False
        if self.is_after(yaml.TagToken):  # "," may be part of a tag
            return True
        if isinstance(token, yaml.ValueToken):  # ":" may be part of a name
            return self.is_after(yaml.AliasToken, yaml.AnchorToken, yaml.FlowEntryToken, yaml.KeyToken)
        return not isinstance(token, (yaml.FlowEntryToken, *_CLOSES))

    def end_line(self, rest: str = "", start: int = 0) -> None:
        """End the line that is being written.

        Args:
            rest: what ends its line in the source: blanks, and a comment if there is one.
            start: where this begins in the text.
        """
        source = display_width(self.text[self.text.rfind("\n", 0, start) + 1 : start]) if rest.strip() else 0
        blanks = len(rest) - len(rest.lstrip())
        self.lines.append(Line(self.line, rest.strip(), source, source + blanks))
        self.line = ""

    def put_blank(self) -> None:
        if self.is_blank_due and self.lines:
            self.lines.append(Line(""))
        self.is_blank_due = False

    def own_lines(self, lines: list[str], token: yaml.Token) -> None:
        """Write lines of the source without tokens: empty ones and comments.

        Comments that follow each other keep what the later ones are indented more than the first, as code that was
        taken out is; and one below a comment at the end of a line, in its column, goes on with it.
        """
        levels = self.comment_levels(token)
        level, base = None, 0
        for line in lines:
            comment = line.strip()
            column = len(line) - len(line.lstrip())
            if not comment:
                self.is_blank_due, level = True, None
                continue
            above = self.lines[-1] if self.lines and not self.is_blank_due else Line("")
            self.put_blank()
            if above.comment and above.source_column == column:
                self.lines.append(Line("", comment, 0, column))
                continue
            before, level = level, _level_of(column, levels)
            if level is not before:
                base = max(level.old, column)
            extra = max(0, column - base)
            deeper = [other.new for other in levels if other.new > level.new]
            if (deeper and level.new + extra >= min(deeper) - 1) or self.previous_is_block_scalar:
                extra = 0
            self.lines.append(Line(" " * (level.new + extra) + comment))

    @property
    def previous_is_block_scalar(self) -> bool:
        return self.previous is not None and self.previous.is_block_scalar

    def comment_levels(self, token: yaml.Token) -> list[_Level]:
        """Return where comments before a token may belong: to the token, or to blocks that end before it."""
        if self.flows:
            if isinstance(token, _CLOSES):
                return [_Level(-1, self.flows[-1].content)]
            return [_Level(token.start_mark.column, self.column(token))]
        is_end = isinstance(token, yaml.StreamEndToken)
        levels = [_Level(0 if is_end else token.start_mark.column, self.column(token))]
        if self.has_opened or not self.is_entry(token):
            return levels
        levels += reversed(self.closed)
        if self.previous_level and self.is_after(yaml.ValueToken, yaml.BlockEntryToken):  # below a key without a value
            levels.append(_Level(self.previous_level.old + 1, self.previous_level.new + INDENT))
        return levels


def _level_of(column: int, levels: list[_Level]) -> _Level:
    """Return the deepest level at or left of a column, else the first; of two in one column the outer one."""
    found = levels[0]
    for level in levels[1:]:
        if found.old < level.old <= column:
            found = level
    return found


def _indentation(lines: list[str]) -> int:
    """Return the column of a literal or folded text that does not say it: that of its first line with a character."""
    found = 1
    for line in lines:
        inner = line.lstrip(" ")
        found = max(found, len(line) - len(inner))
        if inner:
            break
    return found


def _stripped_end(line: str, blanks: str) -> str:
    """Return a line without blanks at its end, unless the first of them is escaped."""
    stripped = line.rstrip(blanks)
    return line if stripped.endswith("\\") else stripped
