"""``trees``, ``scenes``, ``skills``, ``nodes``, ``robots``, ``scenarios``: what there is, without running it."""

from __future__ import annotations

import argparse
import inspect
import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import yaml
from rich.text import Text

from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.cli.output import columns, hanging, print_lines
from humanoid_bt.cli.robots_init import robots_init
from humanoid_bt.cli.robots_table import robots_table
from humanoid_bt.core.errors import Problem, UserError, nearest, relative
from humanoid_bt.core.params import Param, params_of
from humanoid_bt.core.texts import printable
from humanoid_bt.core.units import shown_quantity
from humanoid_bt.files.class_files import class_file
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.source import PerceptSource
from humanoid_bt.perception.source_files import load_sources
from humanoid_bt.plant.scene_config import ObjectConfig, SceneConfig, load_scene
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.session.report import ExitCode
from humanoid_bt.testing.scenario import Scenario, load_scenario
from humanoid_bt.tree.node_type import NodeType
from humanoid_bt.tree.nodes.examples import EXAMPLES
from humanoid_bt.tree.nodes.registry import ALIASES, Registry
from humanoid_bt.tree.source.file import TreeFile, read_file

Found = TypeVar("Found")
Row = tuple[str, str, str, str]


def skills(arguments: argparse.Namespace) -> int:
    """List skills, or explain some."""
    registry = Registry.of(Workspace(arguments.workspace))
    known = {name: kind for name, kind in registry.items() if kind.kind == "skill"}
    _explain_each(arguments.names, known, "skill", _skill)
    return ExitCode.SUCCESS


def sources(arguments: argparse.Namespace) -> int:
    """List percept sources, or explain some."""
    _explain_each(arguments.names, load_sources(Workspace(arguments.workspace)), "source", _source)
    return ExitCode.SUCCESS


def nodes(arguments: argparse.Namespace) -> int:
    """List the types of nodes, or explain some."""
    registry = Registry.of(Workspace(arguments.workspace))
    if arguments.names:
        known = {**registry, **{alias: registry[name] for alias, name in ALIASES.items()}}
        _explain_each(arguments.names, known, "node", _node)
        return ExitCode.SUCCESS
    console = SafeConsole()
    kinds = dict.fromkeys(kind.kind for kind in registry.values())
    width = max(map(len, registry))
    for number, kind in enumerate(kinds):
        if number:
            print()
        console.print(kind + "s", style="bold")
        rows = [(name, _plain(node.doc)) for name, node in registry.items() if node.kind == kind]
        print_lines(columns(rows, indent=2, first=width))
    print()
    print_lines(hanging("", "humanoid-bt nodes NAME explains one, with an example."))
    return ExitCode.SUCCESS


def trees(arguments: argparse.Namespace) -> int:
    """List trees, or explain some."""
    return _files(arguments.names, Workspace(arguments.workspace).trees(), "tree", _read_tree, _tree)


def scenes(arguments: argparse.Namespace) -> int:
    """List scenes, or explain some."""
    return _files(arguments.names, Workspace(arguments.workspace).scenes(), "scene", load_scene, _scene)


def robots(arguments: argparse.Namespace) -> int:
    """List robots, explain some, describe a new one, or measure some side by side."""
    if arguments.names[:1] == ["table"]:
        return robots_table(arguments.names[1:], arguments)
    if given := [name for name in ("out", "trials", "seed", "only", "workers") if getattr(arguments, name) is not None]:
        raise UserError(f"--{given[0]} is for robots table", hint="humanoid-bt robots table ROBOT...")
    if arguments.names[:1] == ["init"]:
        return robots_init(arguments.names[1:], arguments.name, Workspace(arguments.workspace))
    if arguments.name is not None:
        raise UserError("--name is for robots init", hint="humanoid-bt robots init MODEL.xml --name NAME")

    def load(path: Path) -> RobotModel:
        return RobotModel(load_robot_config(path))

    known, explain = Workspace(arguments.workspace).robots(), _robot if arguments.names else _robot_line
    return _files(arguments.names, known, "robot", load, explain)


def scenarios(arguments: argparse.Namespace) -> int:
    """List scenarios, or explain some."""
    known = Workspace(arguments.workspace).scenarios()
    return _files(arguments.names, known, "scenario", load_scenario, _scenario)


# ---- one of them ----------------------------------------------------------------------------------------------------


def _skill(_name: str, skill: NodeType) -> None:
    _headline(skill.type_name, skill.doc)
    file = class_file(skill.cls)
    commands = ", ".join(skill.resources) or "nothing"
    print_lines(hanging("  ", f"commands {commands}" + (f"; from {relative(file)}" if file else "")))
    results = [(result.name, result.type_name, "result", result.doc) for result in skill.results.values()]
    print_lines(columns([*map(_row, skill.params.values()), *results], indent=2))


def _source(name: str, source: type[PerceptSource]) -> None:
    _headline(name, (inspect.getdoc(source) or "").partition("\n\n")[0])
    file, needs = class_file(source), " and ".join(source.needs) or "nothing"
    print_lines(hanging("  ", f"{source.rate:g} Hz, needs {needs}" + (f"; from {relative(file)}" if file else "")))
    print_lines(columns(map(_row, params_of(source).values()), indent=2))


def _node(name: str, node: NodeType) -> None:
    if node.kind == "skill":
        _skill(name, node)
    else:
        _headline(name, node.doc)
        also = f"another name of {node.type_name}; " if name != node.type_name else ""
        none = "nodes at keys of its own" if node.branches else "no children"
        takes = {"many": "a list of children", "one": "one child, beside its parameters", "none": none}
        print_lines(hanging("  ", f"{also}{node.kind} with {takes[node.takes]}"))
        more = inspect.cleandoc(vars(node.cls).get("__doc__") or "").partition("\n\n")[2]
        for paragraph in filter(None, _plain(more).split("\n\n")):
            print_lines(hanging("  ", " ".join(paragraph.split())))
        branches = [
            (key, "nodes" if slot.many else "node", "required" if slot.required else "optional", slot.doc)
            for key, slot in node.branches.items()
        ]
        print_lines(columns([*map(_row, node.params.values()), *branches], indent=2))
    if node.type_name in EXAMPLES:
        print_lines(["  example", *(f"    {line}" for line in EXAMPLES[node.type_name].splitlines())])


def _read_tree(path: Path) -> TreeFile:
    problems: list[Problem] = []
    file = read_file(path, problems)
    if problems:
        raise UserError(problems)
    return file


def _tree(name: str, file: TreeFile) -> None:
    header = file.header
    _headline(name, header.get("description", ""))
    made_for = [f"{key} {header[key]}" for key in ("robot", "scene") if header.get(key)]
    what = ["a sub-tree, for other trees"] if header.get("subtree") else made_for
    print_lines(hanging("  ", "; ".join(filter(None, [", ".join(what), f"from {relative(file.path)}"]))))
    rows = [_row(declared.spec) for declared in file.parameters.values()]
    outputs = [declared.spec for declared in file.outputs.values()]
    rows += [(spec.name, spec.type_name, "output", spec.doc) for spec in outputs]
    print_lines(columns(rows, indent=2))


def _scene(name: str, scene: SceneConfig) -> None:
    _headline(name, scene.description)
    print_lines(hanging("  ", f"from {relative(scene.path)}"))
    rows = [("object", key, f"{thing.color} {thing.shape} {_where(thing)}") for key, thing in scene.objects.items()]
    rows += [("percept", key, f"of {percept.object}") for key, percept in scene.percepts.items()]
    for event in scene.events:
        what = next(key for key in ("hide", "show", "move") if getattr(event, key))
        to = f" to {_point(event.to)}" if event.to else ""
        rows.append(("event", f"{event.at:g} s", f"{what} {event.object}{to}"))
    print_lines(columns(rows, indent=2))


def _scenario(name: str, scenario: Scenario) -> None:
    _headline(name, scenario.description)
    of = f"{scenario.tree} in {scenario.scene}" if scenario.scene else scenario.tree
    seeds = f"seed{'s' * (len(scenario.seeds) > 1)} {scenario.seeds}"
    dry = ", dry" if scenario.dry else ""
    print_lines(hanging("  ", f"{of}, {seeds}{dry}; from {relative(scenario.path)}"))
    print_lines(line for one in scenario.expect for line in hanging("  expect  ", one.text))


def _where(thing: ObjectConfig) -> str:
    place = f"at {_point(thing.position)}" if thing.position else "where the seed says"
    return f"on a stand {place}" if thing.stand else place


def _point(position: Sequence[float]) -> str:
    return f"[{', '.join(f'{number:g}' for number in position)}] m"


def _robot(name: str, robot: RobotModel) -> None:
    _robot_line(name, robot)
    print_lines(hanging("  joints  ", ", ".join(robot.joint_names)))


def _robot_line(name: str, robot: RobotModel) -> None:
    _headline(name, robot.config.description)
    print_lines(hanging("  ", f"{robot.mass:.1f} kg, {len(robot.joint_names)} joints; {relative(robot.config.path)}"))


# ---- all of them ----------------------------------------------------------------------------------------------------


def _files(
    names: Sequence[str],
    paths: Mapping[str, Path],
    what: str,
    load: Callable[[Path], Found],
    explain: Callable[[str, Found], None],
) -> int:
    """Explain files, those with mistakes at the end.

    Raises:
        UserError: with their mistakes.
    """
    found: dict[str, Found] = {}
    problems: list[Problem] = []
    _refuse_unknown(names, paths, what)
    for name in names or sorted(paths):
        try:
            found[name] = load(paths[name])
        except UserError as error:
            problems += error.problems
    _explain_each([], found, what, explain)
    if problems:
        raise UserError(problems)
    return ExitCode.SUCCESS


def _explain_each(
    names: Sequence[str], known: Mapping[str, Found], what: str, explain: Callable[[str, Found], None]
) -> None:
    _refuse_unknown(names, known, what)
    for number, name in enumerate(names or sorted(known)):
        if number:
            print()
        explain(name, known[name])


def _refuse_unknown(names: Iterable[str], known: Collection[str], what: str) -> None:
    unknown = [name for name in names if name not in known]
    if unknown:
        hints = {name: nearest(name, known, f"humanoid-bt {what}s") for name in unknown}
        raise UserError([Problem(f"no {what} named {name!r}", None, hint) for name, hint in hints.items()])


def _headline(name: str, doc: str) -> None:
    """Print a name in bold and what it is."""
    text = Text("\n".join(hanging(f"{name}  ", _plain(doc))))
    text.stylize("bold", 0, len(name))
    SafeConsole().print(text, soft_wrap=True)


def _plain(doc: str) -> str:
    """Return a docstring as a terminal shows it: names in quotes, and no other marks."""
    return printable(re.sub(r"`+", "'", doc).replace("*", ""))


def _row(spec: Param) -> Row:
    return spec.name, spec.type_name, _default(spec), spec.doc


def _default(spec: Param) -> str:
    if spec.required:
        return "required"
    if spec.default is None:
        return "optional"
    default = spec.default
    if isinstance(default, dict):  # a node
        return f"= {yaml.safe_dump(default, default_flow_style=True, width=math.inf, sort_keys=False).strip()}"
    return f"= {shown_quantity(default, spec.unit)}"
