"""Loading percept sources from a workspace's files, the built-in ones and the user's alike."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.declared import wrong_parameters
from humanoid_bt.core.errors import Place, Problem, UserError, relative
from humanoid_bt.core.params import params_of
from humanoid_bt.core.sources import Sources
from humanoid_bt.files.class_files import class_file, class_place, classes_of, load_module
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.source import NEEDS, PerceptSource, source_name
from humanoid_bt.perception.tracker import Tracker

TRACKER = source_name(Tracker)
"""The source that is used where nobody names one: no file can declare another one of this name."""

_CODE = "broken-source"
_TAKEN = frozenset((*dir(PerceptSource), "names", "random", "scene"))
"""Attributes that a source has already; a parameter of that name would break it."""

_FASTEST = round(1 / DECISION_PERIOD)  # Hz


def load_sources(workspace: Workspace) -> dict[str, type[PerceptSource]]:
    """Return every percept source of a workspace by its name; the user's win over built-in files.

    Raises:
        UserError: with every problem found: a file that cannot be imported or has no source, a name that two files of
            one folder declare, the simulated tracker's name, a declaration that is not valid.
    """
    found: dict[str, type[PerceptSource]] = {TRACKER: Tracker}
    folders: dict[str, Path] = {}
    problems: list[Problem] = []
    for path in workspace.perception_files():
        try:
            classes: list[type[PerceptSource]] = classes_of(load_module(path, "source"), PerceptSource)
        except UserError as error:
            problems += error.problems
            continue
        if not classes:
            hint = "class NAME(PerceptSource), with def look(self, now); a file of helpers begins with an underscore"
            problems.append(Problem("this file has no percept source", Place(relative(path), 1, 1), hint, _CODE))
        for cls in classes:
            name, place = source_name(cls), class_place(cls)
            if folders.get(name) == path.parent:
                hint = f"first at {class_place(found[name])}"
                message = f"the percept source {name!r} is declared twice"
                problems.append(Problem(message, place, hint, "duplicate-source"))
            if name == TRACKER:
                message = f"the percept source {name!r} is the simulated tracker, which is used where none is named"
                problems.append(Problem(message, place, "rename it, or give it a source_name", "taken-name"))
            problems += _mistakes(name, cls, place)
            found[name], folders[name] = cls, path.parent
    if problems:
        raise UserError(problems)
    return dict(sorted(found.items()))


def files_of(sources: Sources | None, workspace: Workspace) -> list[Path]:
    """Return the files of sources, without what is built into the package; raises as :func:`load_sources`."""
    if sources is None:
        return []
    known = load_sources(workspace)
    used = {file for one in sources.every if (file := class_file(known[one.name])) is not None}
    return sorted(file for file in used if file.parent.name == "perception")


def whole_ticks(rate: Any) -> int:
    """Return how many ticks of decision lie between two looks at a rate [Hz], 0 if these are not whole."""
    if isinstance(rate, bool) or not isinstance(rate, (int, float)) or not 0 < rate <= _FASTEST:
        return 0
    ticks = round(_FASTEST / rate)
    return ticks if math.isclose(ticks * rate, _FASTEST, rel_tol=1e-3) else 0


def _mistakes(name: str, cls: type[PerceptSource], place: Place) -> Iterator[Problem]:
    missing = sorted(getattr(cls, "__abstractmethods__", ()))
    if missing:
        hint = f"def {missing[0]}(self, now) -> ..., or a leading underscore if it is no source"
        yield Problem(f"the percept source {name!r} has no {'(), '.join(missing)}()", place, hint, _CODE)
    if not whole_ticks(cls.rate):
        hint = "50 Hz divided by a whole number: 50, 25, 10, 5, 2, 1, ..."
        yield Problem(f"the rate of {name!r} cannot be {cls.rate!r}", place, hint, _CODE)
    needs: Any = cls.needs
    if not isinstance(needs, tuple):
        hint = f'needs = ("{needs if needs in NEEDS else "camera"}",)'
        yield Problem(f"the needs of {name!r} must be a tuple, not {needs!r}", place, hint, _CODE)
    elif wrong := [need for need in needs if need not in NEEDS]:
        hint = f'needs = ("camera",); valid: {", ".join(NEEDS)}'
        yield Problem(f"{name!r} cannot need {wrong[0]!r}", place, hint, _CODE)
    if isinstance(cls.patience, bool) or not isinstance(cls.patience, (int, float)) or not cls.patience > 0:
        yield Problem(f"the patience of {name!r} cannot be {cls.patience!r}", place, "seconds: patience = 2.0", _CODE)
    try:
        declared = params_of(cls)
    except (NameError, KeyError, TypeError) as error:
        yield Problem(f"the parameters of {name!r} cannot be read: {error}", place, "annotate each of them", _CODE)
        return
    for parameter in declared:
        if parameter in _TAKEN:
            message = f"{name!r} declares the parameter {parameter!r}, which every source has already"
            yield Problem(message, place, "rename it", "taken-name")
    yield from wrong_parameters(name, declared, place, _CODE)
