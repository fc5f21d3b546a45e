"""Findings for programs: JSON, and SARIF 2.1.0 as code scanning services take it."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from humanoid_bt import __version__
from humanoid_bt.checking.codes import CODES, Code
from humanoid_bt.core.errors import Place, Problem

_SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"


def as_json(problems: Sequence[Problem]) -> str:
    """Return findings as a list of objects; a line or column that is not known is null."""
    return json.dumps([_plain(problem) for problem in problems], indent=2)


def as_sarif(problems: Sequence[Problem]) -> str:
    """Return findings as a SARIF log of one run, with every code of the catalogue as a rule."""
    driver = {"name": "humanoid-bt", "version": __version__, "rules": [_rule(code) for code in CODES.values()]}
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(problem) for problem in problems],
    }
    return json.dumps({"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2)


def _plain(problem: Problem) -> dict[str, Any]:
    place = problem.place or Place("")
    return {
        "file": place.file or None,
        "line": place.line or None,
        "column": place.column or None,
        "severity": problem.severity,
        "code": problem.code,
        "message": problem.message,
        "hint": problem.hint,
    }


def _rule(code: Code) -> dict[str, Any]:
    example = f"\n\nWrong:\n\n{code.wrong}\n\nRight:\n\n{code.right}" if code.wrong else ""
    return {
        "id": code.name,
        "shortDescription": {"text": code.meaning},
        "fullDescription": {"text": code.meaning},
        "help": {"text": code.meaning + example},
        "defaultConfiguration": {"level": code.severity},
    }


def _result(problem: Problem) -> dict[str, Any]:
    result: dict[str, Any] = {
        "level": problem.severity,
        "message": {"text": "\n".join(part for part in (problem.message, problem.hint) if part)},
        "locations": [_location(problem.place)] if problem.place else [],
    }
    if problem.code in CODES:
        result |= {"ruleId": problem.code, "ruleIndex": list(CODES).index(problem.code)}
    return result


def _location(place: Place) -> dict[str, Any]:
    region = {"startLine": max(place.line, 1), "startColumn": max(place.column, 1)}
    return {"physicalLocation": {"artifactLocation": {"uri": _uri(place.file)}, "region": region}}


def _uri(file: str) -> str:
    """Return a file's URI, relative to the working directory where it lies below it; it may be no text."""
    path = Path(file)
    return path.as_uri() if path.is_absolute() else quote(os.fsencode(path.as_posix()))
