"""Campaign files and what can be required of a campaign, from where both are declared."""

from __future__ import annotations

from humanoid_bt.campaign.file import CampaignFile, PushVariation
from humanoid_bt.campaign.requirement import NAMES
from humanoid_bt.core.params import Param, params_of
from parts.markdown import table


def campaign_keys() -> str:
    """Return the keys of a campaign file."""
    return _keys(CampaignFile)


def push_keys() -> str:
    """Return the keys of a push."""
    return _keys(PushVariation)


def requirement_names() -> str:
    """Return the names that requirements can use."""
    rows = [(f"`{name}`", doc) for name, doc in NAMES.items()]
    quantiles = "Of the trials that succeeded: the time, and every number that a skill reports."
    ends = ", ".join(f"`_{end}`" for end in ("min", "p5", "median", "p95", "max"))
    return table(("name", "meaning"), [*rows, (f"`time`, `hand_error`, ... with {ends}", quantiles)])


def _keys(cls: type) -> str:
    return table(("key", "meaning"), [(f"`{spec.name}`", _meaning(spec)) for spec in params_of(cls).values()])


def _meaning(spec: Param) -> str:
    unit = f" [{spec.unit}]" if spec.unit else ""
    return spec.doc.removesuffix(".") + unit + (". Required." if spec.required else ".")
