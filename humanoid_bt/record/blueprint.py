"""How the viewer shows a run at once: robot and tree side by side, time below, plots and events at hand."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import rerun as rr
import rerun.blueprint as rrb

from humanoid_bt.record import camera, documents, events, eye, overlays, plots, results, tree_view
from humanoid_bt.record.columns import LANES, TIMELINE, entity
from humanoid_bt.record.scene_view import WORLD

_BACKGROUND = (126, 139, 156)  # lighter than most robots, darker than labels
_MARGIN = 12.0  # around the tree, in the graph's units


def blueprint(graph: tuple[float, float], groups: Iterable[str], base_height: float) -> Any:
    """Return the layout.

    Args:
        graph: width and height of the tree's graph.
        groups: joint groups that have plots.
        base_height: of the standing robot [m], the measure of the picture.
    """
    left = rrb.Vertical(_scene(base_height), _lanes(), row_shares=[9, 7])
    texts = rrb.Tabs(
        rrb.TextLogView(name="events", origin=events.EVENTS, columns=_log_columns()),
        rrb.Spatial2DView(
            name="head camera", origin=camera.CAMERA, contents=["$origin/**", f"/{overlays.PERCEPTS}/**"]
        ),
        rrb.TextDocumentView(name="run", origin=documents.RUN),
        rrb.TextDocumentView(name="tree file", origin=documents.TREE),
    )
    right = rrb.Vertical(_graph(graph), _plots(groups), texts, row_shares=[9, 9, 6])
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[1, 1]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_layout=False,
        auto_views=False,
    )


def _scene(base_height: float) -> Any:
    all_until_now = rrb.VisibleTimeRanges(
        timeline=TIMELINE,
        start=rr.TimeRangeBoundary.infinite(),
        end=rr.TimeRangeBoundary.cursor_relative(seconds=0),
    )
    return rrb.Spatial3DView(
        name="robot",
        origin=WORLD,
        contents=["/**", f"- /{camera.CAMERA}/**"],
        eye_controls=rrb.EyeControls3D(position=eye.position(base_height), look_target=(0, 0, 0), eye_up=(0, 0, 1)),
        spatial_information=rrb.SpatialInformation(target_frame=eye.FRAME),
        background=_BACKGROUND,
        line_grid=False,
        overrides={overlays.PATH: all_until_now},
    )


def _lanes() -> Any:
    return rrb.StateTimelineView(name="nodes over time", origin=LANES)


def _graph(size: tuple[float, float]) -> Any:
    width, height = size
    bounds = rrb.VisualBounds2D(x_range=(-_MARGIN, width + _MARGIN), y_range=(-_MARGIN, height + _MARGIN))
    return rrb.GraphView(name="tree", origin=tree_view.GRAPH, visual_bounds=bounds)


def _plots(groups: Iterable[str]) -> Any:
    overview = rrb.Vertical(
        rrb.TimeSeriesView(name="percepts", origin=plots.PERCEPTS),
        rrb.TimeSeriesView(name="foot forces", origin=plots.FEET),
        name="overview",
    )
    base = rrb.Vertical(
        rrb.TimeSeriesView(name="base", origin=plots.BASE),
        rrb.TimeSeriesView(name="distance of the palms to their targets [m]", origin=plots.HANDS),
        name="base and hands",
    )
    reported = rrb.TimeSeriesView(name="results", origin=results.RESULTS)
    return rrb.Tabs(overview, base, reported, *(_joints(group) for group in groups), name="plots", active_tab=0)


def _joints(group: str) -> Any:
    path = f"/{entity(plots.JOINTS, group)}"
    return rrb.Vertical(
        rrb.TimeSeriesView(
            name=f"{group}: position against setpoint [rad]",
            contents=[f"{path}/setpoint", f"{path}/position", f"{path}/soft_limit"],
        ),
        rrb.TimeSeriesView(name=f"{group}: torque [Nm]", contents=[f"{path}/torque"]),
        row_shares=[3, 2],
        name=group,
    )


def _log_columns() -> Any:
    kinds = (rrb.encodings.TextLogColumnKind.LogLevel, rrb.encodings.TextLogColumnKind.Body)
    return rrb.TextLogColumns(
        timeline_columns=[rrb.encodings.TimelineColumn(TIMELINE)],
        text_log_columns=[rrb.encodings.TextLogColumn(kind) for kind in kinds],
    )
