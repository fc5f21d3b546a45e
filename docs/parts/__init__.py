"""The generated parts of the pages: each is a function that returns Markdown, in the module of what it tells of."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from parts import (
    api,
    campaigns,
    codes,
    config_files,
    house,
    library,
    nodes,
    promises,
    python,
    scenarios,
    tables,
    testing,
    tree_files,
    units,
)

PARTS_BY_NAME: dict[str, Callable[[], str]] = {
    maker.__name__: maker
    for maker in (
        *(nodes.nodes, nodes.skills, nodes.elsewhere, nodes.node_keys),
        *(tree_files.tree_keys, tree_files.parameter_keys, tree_files.percept_words, tree_files.state_words),
        *(config_files.robot_keys, config_files.policy_keys, config_files.scene_keys),
        *(campaigns.campaign_keys, campaigns.push_keys, campaigns.requirement_names),
        *(library.trees, library.library),
        *(python.handle, python.route, python.hand_route, python.track, python.state, python.rig, python.rig_result),
        *(api.api, api.session, api.debugging, api.report),
        *(codes.codes, codes.code_examples),
        *(promises.costs, promises.reactions, promises.speeds, promises.body_rows, promises.gait_figures),
        *(tables.data_tables, tables.recording),
        *(testing.skill_rules, testing.faults, testing.conditions, testing.answers, testing.tree_run, testing.view),
        *(scenarios.scenario_keys, scenarios.run_words, scenarios.node_verbs),
        *(units.units, units.clocks),
        *(house.rooms, house.inner_rooms, house.percept_way, house.command_way),
    )
} | {f"library_{name}": partial(library.library_tree, name) for name in library.made_for_use_in_others()}
"""Name of a generated part -> what makes it."""
