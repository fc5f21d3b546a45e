"""The keys of ``robot.yaml``, walkers and scene files: one table per dataclass that they are read into."""

from __future__ import annotations

import re
from collections.abc import Iterator

from humanoid_bt.core.params import params_of
from humanoid_bt.plant.scene_config import SceneConfig
from humanoid_bt.robot.config import RobotConfig
from humanoid_bt.robot.policy.config import PolicyConfig
from parts.markdown import docstring
from parts.parameters import dataclass_in, parameter_row, parameter_table


def robot_keys() -> str:
    """Return the reference of ``robot.yaml``."""
    return _sections(RobotConfig, "robot.yaml")


def policy_keys() -> str:
    """Return the reference of ``walk.policy.yaml``."""
    return _sections(PolicyConfig, "walk.policy.yaml")


def scene_keys() -> str:
    """Return the reference of scene files."""
    return _sections(SceneConfig, "The scene file")


def _sections(cls: type, title: str) -> str:
    """Return one table per dataclass, the outermost first, each once."""
    found: dict[type, str] = {cls: title}
    parts: list[str] = []
    for section, heading in _walk(cls, found):
        rows = [parameter_row(spec, found) for spec in params_of(section).values()]
        parts += [f"### {heading}", docstring(section), parameter_table("key", rows)]
    return "\n\n".join(parts)


def _walk(cls: type, found: dict[type, str]) -> Iterator[tuple[type, str]]:
    """Yield a dataclass and those of its parameters, and name each in ``found``."""
    order = [cls]
    for section in order:
        for spec in params_of(section).values():
            inner = dataclass_in(spec.type)
            if inner and inner not in found:
                found[inner] = inner.__name__.removesuffix("Config")
                found[inner] = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", found[inner]).capitalize()
                order.append(inner)
    yield from ((section, found[section]) for section in order)
