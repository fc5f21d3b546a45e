"""Behavior-tree task orchestration for humanoid robots.

    import humanoid_bt as hbt                           # a program or a notebook
    from humanoid_bt import Skill, Status, param        # a skill's file

What is named here is the public API; everything else may move. Each name is imported when it is first used, so that
``import humanoid_bt`` costs nothing, and a skill's file needs no simulator.
"""

from __future__ import annotations

import sys
from importlib import import_module

TYPE_CHECKING = False  # typing takes a while to import

__version__ = "0.1.0"

__all__ = [  # noqa: RUF022 (grouped as a reader looks for them)
    # Running and looking
    "load",
    "run",
    "Session",
    "Report",
    "explain",
    "Explanation",
    "Listener",
    "NodeChange",
    "check",
    "Tree",
    "Node",
    "Workspace",
    "unicode_tree",
    "svg_tree",
    # Trees made in Python
    "make_tree",
    "nodes",
    "skills",
    "Key",
    # Looking back
    "open_recording",
    "Recording",
    # Skills
    "Skill",
    "Status",
    "param",
    "result",
    "PerceptName",
    "RobotHandle",
    "Track",
    "Pose",
    "ArmJoint",
    "State",
    "Mode",
    "Gait",
    "Side",
    "SIDES",
    "of_hand",
    "of_gaze",
    "Steady",
    "Lasting",
    "Improving",
    "Route",
    "HandRoute",
    "rotation_matrix",
    # Percept sources
    "PerceptSource",
    "Percept",
    "Moment",
    "Picture",
    # Tests of skills and trees
    "Rig",
    "RigResult",
    "SourceRig",
    "check_skill",
    "SkillCheck",
    "Stage",
    "TreeRun",
    "Watcher",
    "View",
    "Event",
    "faults",
    "Conditions",
    "Replacement",
    # Looking back
    "replay",
    "Replay",
    # Errors
    "HumanoidBtError",
    "UserError",
    "NodeError",
    "Problem",
    "Place",
]

if TYPE_CHECKING:
    from humanoid_bt.campaign.check_files import check as check
    from humanoid_bt.core.errors import HumanoidBtError as HumanoidBtError
    from humanoid_bt.core.errors import Place as Place
    from humanoid_bt.core.errors import Problem as Problem
    from humanoid_bt.core.errors import UserError as UserError
    from humanoid_bt.core.geometry import rotation_matrix as rotation_matrix
    from humanoid_bt.core.messages import SIDES as SIDES
    from humanoid_bt.core.messages import Gait as Gait
    from humanoid_bt.core.messages import Mode as Mode
    from humanoid_bt.core.messages import Percept as Percept
    from humanoid_bt.core.messages import Pose as Pose
    from humanoid_bt.core.messages import Side as Side
    from humanoid_bt.core.messages import State as State
    from humanoid_bt.core.params import PerceptName as PerceptName
    from humanoid_bt.core.params import param as param
    from humanoid_bt.decision.anatomy import ArmJoint as ArmJoint
    from humanoid_bt.decision.blackboard import Key as Key
    from humanoid_bt.decision.hand_route import HandRoute as HandRoute
    from humanoid_bt.decision.result import result as result
    from humanoid_bt.decision.robot_handle import RobotHandle as RobotHandle
    from humanoid_bt.decision.route import Route as Route
    from humanoid_bt.decision.signals import Improving as Improving
    from humanoid_bt.decision.signals import Lasting as Lasting
    from humanoid_bt.decision.signals import Steady as Steady
    from humanoid_bt.decision.skill import Skill as Skill
    from humanoid_bt.decision.skill import Status as Status
    from humanoid_bt.decision.skill import of_gaze as of_gaze
    from humanoid_bt.decision.skill import of_hand as of_hand
    from humanoid_bt.files.workspace import Workspace as Workspace
    from humanoid_bt.perception.picture import Picture as Picture
    from humanoid_bt.perception.source import Moment as Moment
    from humanoid_bt.perception.source import PerceptSource as PerceptSource
    from humanoid_bt.perception.track import Track as Track
    from humanoid_bt.review.explain import explain as explain
    from humanoid_bt.review.explanation import Explanation as Explanation
    from humanoid_bt.review.recording import Recording as Recording
    from humanoid_bt.review.recording import open_recording as open_recording
    from humanoid_bt.review.replay import Replay as Replay
    from humanoid_bt.review.replay import replay as replay
    from humanoid_bt.session.listener import Listener as Listener
    from humanoid_bt.session.prepare import load as load
    from humanoid_bt.session.prepare import skills as skills
    from humanoid_bt.session.report import Report as Report
    from humanoid_bt.session.run import run as run
    from humanoid_bt.session.session import Session as Session
    from humanoid_bt.testing import faults as faults
    from humanoid_bt.testing.check_skill import check_skill as check_skill
    from humanoid_bt.testing.check_skill_result import SkillCheck as SkillCheck
    from humanoid_bt.testing.conditions import Conditions as Conditions
    from humanoid_bt.testing.events import Event as Event
    from humanoid_bt.testing.rig import Rig as Rig
    from humanoid_bt.testing.rig_result import RigResult as RigResult
    from humanoid_bt.testing.source_rig import SourceRig as SourceRig
    from humanoid_bt.testing.stage import Stage as Stage
    from humanoid_bt.testing.substitution import Replacement as Replacement
    from humanoid_bt.testing.tree_run import TreeRun as TreeRun
    from humanoid_bt.testing.tree_run import View as View
    from humanoid_bt.testing.tree_run import Watcher as Watcher
    from humanoid_bt.tree import nodes as nodes
    from humanoid_bt.tree.node import Node as Node
    from humanoid_bt.tree.show import svg_tree as svg_tree
    from humanoid_bt.tree.show import unicode_tree as unicode_tree
    from humanoid_bt.tree.source.compose import make_tree as make_tree
    from humanoid_bt.tree.ticking.executor import NodeChange as NodeChange
    from humanoid_bt.tree.ticking.executor import NodeError as NodeError
    from humanoid_bt.tree.tree import Tree as Tree
else:
    _HOMES = {
        "humanoid_bt.session.prepare": "load skills",
        "humanoid_bt.campaign.check_files": "check",
        "humanoid_bt.decision.blackboard": "Key",
        "humanoid_bt.core.errors": "HumanoidBtError Place Problem UserError",
        "humanoid_bt.core.geometry": "rotation_matrix",
        "humanoid_bt.core.messages": "SIDES Gait Mode Percept Pose Side State",
        "humanoid_bt.core.params": "PerceptName param",
        "humanoid_bt.decision.anatomy": "ArmJoint",
        "humanoid_bt.decision.result": "result",
        "humanoid_bt.decision.robot_handle": "RobotHandle",
        "humanoid_bt.perception.picture": "Picture",
        "humanoid_bt.perception.source": "Moment PerceptSource",
        "humanoid_bt.perception.track": "Track",
        "humanoid_bt.review.recording": "Recording open_recording",
        "humanoid_bt.review.explain": "explain",
        "humanoid_bt.review.explanation": "Explanation",
        "humanoid_bt.session.report": "Report",
        "humanoid_bt.session.run": "run",
        "humanoid_bt.session.session": "Session",
        "humanoid_bt.session.listener": "Listener",
        "humanoid_bt.decision.hand_route": "HandRoute",
        "humanoid_bt.decision.route": "Route",
        "humanoid_bt.decision.signals": "Improving Lasting Steady",
        "humanoid_bt.decision.skill": "Skill Status of_gaze of_hand",
        "humanoid_bt.review.replay": "Replay replay",
        "humanoid_bt.testing.check_skill": "check_skill",
        "humanoid_bt.testing.check_skill_result": "SkillCheck",
        "humanoid_bt.testing.rig": "Rig",
        "humanoid_bt.testing.rig_result": "RigResult",
        "humanoid_bt.testing.source_rig": "SourceRig",
        "humanoid_bt.testing.stage": "Stage",
        "humanoid_bt.testing.tree_run": "TreeRun View Watcher",
        "humanoid_bt.testing.events": "Event",
        "humanoid_bt.testing.conditions": "Conditions",
        "humanoid_bt.testing.substitution": "Replacement",
        "humanoid_bt.tree.source.compose": "make_tree",
        "humanoid_bt.tree.ticking.executor": "NodeChange NodeError",
        "humanoid_bt.tree.show": "svg_tree unicode_tree",
        "humanoid_bt.tree.node": "Node",
        "humanoid_bt.tree.tree": "Tree",
        "humanoid_bt.files.workspace": "Workspace",
    }

    _MODULES = {"nodes": "humanoid_bt.tree.nodes", "faults": "humanoid_bt.testing.faults"}

    def __getattr__(name):
        """Import a public name when it is first used (PEP 562)."""
        if name in _MODULES:
            value = import_module(_MODULES[name])
        else:
            home = next((home for home, names in _HOMES.items() if name in names.split()), None)
            if home is None:
                message = f"module 'humanoid_bt' has no attribute {name!r}"
                raise AttributeError(message, name=name, obj=sys.modules[__name__])  # Python thinks of a near one
            value = getattr(import_module(home), name)
        globals()[name] = value
        return value

    def __dir__():
        return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
