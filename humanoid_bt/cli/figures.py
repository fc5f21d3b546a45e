"""The figures of ``humanoid-bt bench``: whether they keep what is promised, and as a file for other programs."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.text import Text

from humanoid_bt.bench.promises import Verdict
from humanoid_bt.core.errors import UserError
from humanoid_bt.session.report import versions


def judged(verdict: Verdict | None) -> Text:
    """Return whether a promise was kept, in colour."""
    return Text(verdict or "", "bold red" if verdict == "missed" else "green")


def write_figures(path: Path, figures: Mapping[str, Any]) -> None:
    """Write figures to a JSON file, with what they were measured on.

    Raises:
        UserError: it cannot be written.
    """
    machine = {"system": platform.platform(), "python": platform.python_version()}
    data = {"machine": machine, "versions": versions(), **figures}
    try:
        path.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise UserError(f"the figures cannot be written to {str(path)!r}: {error.strerror}") from error
