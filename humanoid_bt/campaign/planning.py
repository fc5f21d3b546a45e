"""From a campaign file, or a command line, to the plan of a campaign; every mistake is found before a trial runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from humanoid_bt.campaign.digests import called, digests
from humanoid_bt.campaign.file import CampaignFile, PushVariation, load_campaign
from humanoid_bt.campaign.plan import Plan, Setting
from humanoid_bt.campaign.requirement import Requirement
from humanoid_bt.campaign.trial import CONDITION, PUSH, SET
from humanoid_bt.campaign.variation import Factor, Variation
from humanoid_bt.checking.check import load_checked
from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import Param, params_of
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import choose, refuse_blind, sources_of
from humanoid_bt.perception.source_files import files_of
from humanoid_bt.plant.scene_config import load_scene
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.files import files_of as robot_files
from humanoid_bt.session.loader import DEFAULT_ROBOT, DEFAULT_SCENE, used_files
from humanoid_bt.testing.conditions import NOISE, Conditions, unsimulated
from humanoid_bt.tree.source.file import read_file
from humanoid_bt.tree.source.given import with_unit_of
from humanoid_bt.tree.source.parameters import NodeItem
from humanoid_bt.tree.tree import Tree

_PUSH = {"direction": 0.0, "duration": 0.1}  # what a push has that does not say

Made = TypeVar("Made")
Named = tuple[str, str, Path]  # tree, robot or scene; its name; its file


@dataclass(frozen=True)
class Planned:
    """A plan, and what it has to show.

    Attributes:
        plan: it.
        requirements: what has to come of it.
        files: every file that what is run depends on, by what it is called.
    """

    plan: Plan
    requirements: tuple[Requirement, ...]
    files: Mapping[str, Path]


def planned(campaign: CampaignFile, workspace: Workspace, script: Sequence[Any] = ()) -> Planned:
    """Return the plan of a campaign.

    Args:
        campaign: what is asked for.
        workspace: where names are looked up.
        script: its script as it is written.

    Raises:
        UserError: with every mistake that can be found without running a trial.
    """
    names = _all(_names(campaign, workspace))
    factors = _all(_factors(campaign, [file for kind, _, file in names if kind == "tree"]))
    noise = any(factor.name == f"{CONDITION}.{NOISE}" and _changes(factor) for factor in factors)
    settings: list[Setting] = []
    trees: list[Tree] = []
    used: set[Path] = set()
    for name, file in ((name, file) for kind, name, file in names if kind == "tree"):
        header = read_file(file, []).header
        for robot in _chosen(names, "robot") or [header.get("robot") or DEFAULT_ROBOT]:
            for scene in _chosen(names, "scene") or [header.get("scene") or DEFAULT_SCENE]:
                setting = Setting(name, robot, scene)
                tree = _loaded(campaign, workspace, file, setting, factors)
                settings.append(setting)
                trees.append(tree)
                used |= {*used_files(tree), workspace.find_scene(scene)}
                used |= robot_files(load_robot_config(workspace.find_robot(robot)))
                used |= _seeing(campaign, workspace, tree, scene, noise)
    reported = {name: spec.unit for tree in trees for node in tree.nodes for name, spec in node.type.results.items()}
    files = {called(file, workspace): file for file in sorted(used)}
    plan = Plan(
        campaign.name,
        tuple(settings),
        campaign.seeds,
        tuple(factors),
        campaign.duration,
        campaign.dry,
        campaign.perception and campaign.perception.written,
        tuple(script),
        tuple(campaign.fail_on),
        campaign.description,
        digests(files),
        str(workspace.root),
    )
    return Planned(plan, tuple(_all(partial(Requirement, one, reported) for one in campaign.require)), files)


def checked_campaign(path: Path, workspace: Workspace) -> Planned:
    """Read a campaign file and look up all that it names; raises as :func:`planned`."""
    return planned(load_campaign(path), workspace)


def _names(campaign: CampaignFile, workspace: Workspace) -> Iterator[Callable[[], Named]]:
    """Yield what finds the file of each tree, robot and scene, or raises that there is none."""
    found = {"tree": workspace.find_tree, "robot": workspace.find_robot, "scene": workspace.find_scene}
    for kind, find in found.items():
        for item in getattr(campaign, kind).items:
            yield partial(_named, kind, find, item)


def _named(kind: str, find: Callable[[str], Path], item: Item) -> Named:
    return kind, item.value, _found(find, item)


def _found(find: Callable[[str], Path], item: Item) -> Path:
    try:
        return find(item.value)
    except UserError as error:
        raise UserError([replace(problem, place=problem.place or item.place) for problem in error.problems]) from error


def _chosen(names: Sequence[Named], kind: str) -> list[str]:
    return [name for of, name, _ in names if of == kind]


def _loaded(
    campaign: CampaignFile, workspace: Workspace, file: Path, setting: Setting, factors: Sequence[Factor]
) -> Tree:
    """Return a tree as it is run.

    Raises:
        UserError: what is wrong with it, its scene, with what it sees, or with any value that a parameter is given,
            beside the first ones of the others.
    """
    _, robot, scene = setting
    load = partial(load_checked, file, workspace, robot=robot, scene=scene, perception=campaign.perception)
    given = {name: variation.ends or variation.values for name, variation in campaign.parameters.items()}
    seed = next(iter(campaign.seeds))
    for factor in factors:  # both ends may be whole numbers, and what is drawn between them is not
        name = factor.name.removeprefix(f"{SET}.")
        if factor.ends is not None and name in given:
            given[name] = (*given[name], Item(factor.value(None, seed), given[name][0].place))
    first = {name: values[0] for name, values in given.items()}
    tree = load(first)
    if tree.is_subtree:
        hint = "a tree that uses it does"
        raise UserError(f"the tree {tree.name!r} does not run alone: it is made for use in other trees", hint=hint)
    _all(partial(load, {**first, name: value}) for name, values in given.items() for value in values[1:])
    return tree


def _seeing(campaign: CampaignFile, workspace: Workspace, tree: Tree, scene: str, noise: bool) -> set[Path]:
    """Return the files of the percept sources that a tree has in a scene.

    Args:
        campaign: what is asked for.
        workspace: where the sources are.
        tree: it.
        scene: its name or file.
        noise: whether the campaign makes the scene's percepts noisier.

    Raises:
        UserError: a dry run cannot have them, or noise changes nothing of what they see.
    """
    around = load_scene(workspace.find_scene(scene))
    sources = sources_of(campaign.perception, tree.perception, around)
    chosen = choose(sources, workspace, around)
    if campaign.dry and sources is not None:
        refuse_blind(chosen, sources)
    if noise and (problem := unsimulated(chosen)) is not None:
        place = _place(campaign.conditions[NOISE])
        raise UserError([replace(problem, place=place)])
    return set(files_of(sources, workspace))


def _factors(campaign: CampaignFile, trees: Sequence[Path]) -> Iterator[Callable[[], Factor]]:
    """Yield what makes each factor, or raises what is wrong with it."""
    for name, variation in campaign.parameters.items():
        yield partial(_parameter, name, variation, trees)
    for name, variation in campaign.conditions.items():
        yield partial(_condition, name, variation, campaign.dry)
    for number, push in enumerate(campaign.pushes, start=1):
        if campaign.dry:
            yield partial(_refuse_dry, "a push", push.at)
        yield partial(_moment, push.at, f"{PUSH}.{number}.at", campaign.duration)
        for name, spec in params_of(PushVariation).items():
            if name != "at":
                yield partial(_number, getattr(push, name), f"{PUSH}.{number}.{name}", spec)


def _parameter(name: str, variation: Variation, trees: Sequence[Path]) -> Factor:
    place = _place(variation)
    for path in trees:
        declared = read_file(path, []).parameters
        if name not in declared:
            hint = nearest(name, declared) or "the tree declares no parameters"
            raise UserError(f"the tree {path.stem!r} has no parameter {name!r}", place, hint, "unknown-parameter")
        if declared[name].spec.type is NodeItem:
            raise UserError(f"the parameter {name!r} is a node, which only another tree can give", place)
    spec = read_file(trees[0], []).parameters[name].spec
    return variation.factor(f"{SET}.{name}", with_unit_of(variation.ends or variation.values, spec))


def _condition(name: str, variation: Variation, dry: bool) -> Factor:
    factor = variation.factor(f"{CONDITION}.{name}", params_of(Conditions)[name])
    if dry and name != NOISE and _changes(factor):
        _refuse_dry(f"the condition {name!r}", variation)
    return factor


def _changes(condition: Factor) -> bool:
    """Return whether a condition makes any trial differ from the files."""
    default = params_of(Conditions)[condition.name.removeprefix(f"{CONDITION}.")].default
    return bool(condition.ends) or set(condition.values) != {default}


def _refuse_dry(what: str, variation: Variation) -> NoReturn:
    hint = "run it without dry, or leave it out"
    raise UserError(f"{what} needs a body, and a dry run simulates none", _place(variation), hint, "out-of-range")


def _place(variation: Variation) -> Place:
    """Return where the first value of what varies stands."""
    return (variation.ends or variation.values)[0].place


def _moment(variation: Variation, column: str, duration: float | None) -> Factor:
    """Return when a push comes; raises UserError if a trial is over by then."""
    factor = _number(variation, column, params_of(PushVariation)["at"])
    latest = max(factor.ends or factor.values)
    if duration is not None and latest > duration:
        message = f"a push at {latest:g} s never happens: a trial ends after {duration:g} s"
        hint = "an earlier moment, or a longer duration"
        raise UserError(message, (variation.ends or variation.values)[-1].place, hint, "out-of-range")
    return factor


def _number(variation: Variation, column: str, spec: Param) -> Factor:
    """Return a number of a push, which has a value where none is given."""
    of = Param(
        spec.name, float, doc=spec.doc, unit=spec.unit, minimum=spec.minimum, above=spec.above, maximum=spec.maximum
    )
    if variation == Variation():
        variation = Variation((Item(_PUSH[spec.name], Place("default")),))
    return variation.factor(column, of)


def _all(makers: Iterator[Callable[[], Made]]) -> list[Made]:
    """Return everything that can be made; what is wrong with any is raised together."""
    made: list[Made] = []
    problems: list[Problem] = []
    for make in makers:
        try:
            made.append(make())
        except UserError as error:
            problems += error.problems
    if problems:
        raise UserError(problems)
    return made
