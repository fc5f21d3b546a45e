"""Results of scenarios as JUnit's XML, which CI servers read."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.whole import write_whole
from humanoid_bt.testing.suite import Result
from humanoid_bt.testing.trial import Trial

_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_junit(results: Iterable[Result], path: Path) -> None:
    """Write results as JUnit's XML: a suite for each scenario, a case for each seed.

    Raises:
        UserError: the file cannot be written.
    """
    root = ElementTree.Element("testsuites", name="humanoid-bt")
    for result in results:
        suite = ElementTree.SubElement(
            root,
            "testsuite",
            name=_text(result.scenario.name),
            tests=str(len(result.trials)),
            failures=str(len(result.failed)),
            errors="0",
            skipped="0",
            time=f"{sum(trial.wall_time for trial in result.trials):.3f}",
        )
        for trial in result.trials:
            _add(suite, trial)
    ElementTree.indent(root)
    content = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    try:
        write_whole(path, content + b"\n")
    except OSError as error:
        raise UserError(f"the results cannot be written to {str(path)!r}: {error.strerror}") from error


def _add(suite: ElementTree.Element, trial: Trial) -> None:
    case = ElementTree.SubElement(
        suite,
        "testcase",
        classname=_text(trial.scenario),
        name=f"seed {trial.seed}",
        file=_text(trial.file),
        time=f"{trial.wall_time:.3f}",
    )
    if not trial.passed:
        first = trial.failures[0]
        failure = ElementTree.SubElement(case, "failure", message=_text(f"{first.expectation}: {first.moment}"))
        failure.set("type", "expectation")
        failure.text = _text("\n".join(trial.lines))


def _text(text: str) -> str:
    """Return a text without what XML has no form for."""
    return _NO_XML.sub("?", text)
