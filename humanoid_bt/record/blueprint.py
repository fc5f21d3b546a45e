"""How the viewer shows a run at once: robot and tree side by side, time below, plots and events at hand."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import rerun as rr
import rerun.blueprint as rrb

from humanoid_bt.record import camera, documents, events, eye, lanes, overlays, plots, results, tree_view
from humanoid_bt.record.columns import TIMELINE, entity
from humanoid_bt.record.scene_view import WORLD

BACKGROUND = (126, 139, 156)
"""Lighter than most robots, darker than labels."""

_MARGIN = 10.0  # around the tree
_ONE_TIME = rrb.TimeAxis(link="LinkToGlobal")  # what is moved or zoomed in one view moves in all


def blueprint(groups: Iterable[str], base_height: float) -> Any:
    """Return the layout.

    Args:
        groups: joint groups that have plots.
        base_height: of the standing robot [m], the measure of the picture.
    """
    left = rrb.Vertical(_scene(base_height), _lanes(), row_shares=[9, 7])
    texts = rrb.Tabs(
        rrb.TextLogView(
            name="events",
            origin=events.EVENTS,
            columns=_log_columns(),
            rows=rrb.TextLogRows(filter_by_log_level=events.SHOWN),
        ),
        rrb.Spatial2DView(
            name="head camera", origin=camera.CAMERA, contents=["$origin/**", f"/{overlays.PERCEPTS}/**"]
        ),
        rrb.TextDocumentView(name="run", origin=documents.RUN),
        rrb.TextDocumentView(name="tree file", origin=documents.TREE),
    )
    right = rrb.Vertical(_tree(), _plots(groups), texts, row_shares=[11, 8, 6])
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
        contents=["/**", f"- /{camera.CAMERA}/**", f"- /{tree_view.TREE}/**"],
        eye_controls=rrb.EyeControls3D(position=eye.position(base_height), look_target=(0, 0, 0), eye_up=(0, 0, 1)),
        spatial_information=rrb.SpatialInformation(target_frame=eye.FRAME),
        background=BACKGROUND,
        line_grid=False,
        overrides={overlays.PATH: all_until_now},
    )


def _lanes() -> Any:
    return rrb.StateTimelineView(
        name="nodes over time",
        origin="/",
        contents=[f"+ /{group}/**" for group in lanes.GROUPS],
        time_view=_ONE_TIME,
    )


def _tree() -> Any:
    width, height = tree_view.SIZE
    bounds = rrb.VisualBounds2D(x_range=(-_MARGIN, width + _MARGIN), y_range=(-_MARGIN, height + _MARGIN))
    return rrb.Spatial2DView(name="tree", origin=tree_view.TREE, background=tree_view.BACKGROUND, visual_bounds=bounds)


def _plots(groups: Iterable[str]) -> Any:
    overview = _beside(
        _legend(plots.SEEN),
        _plot("distance of what is seen [m]", plots.DISTANCE),
        _plot("foot force [N]: left blue, right orange", plots.FEET),
        _plot("confidence of what is seen", plots.CONFIDENCE, range_y=(0.0, 1.0)),
        _plot("age of what is seen [s]", plots.AGE),
        name="overview",
    )
    base = rrb.Grid(
        _plot("speed [m/s]", plots.SPEED),
        _plot("tilt [rad]", plots.TILT),
        _plot("turn rate [rad/s]", plots.TURN),
        _plot("palm to target [m]: left blue, right orange", plots.HANDS),
        grid_columns=2,
        name="base and hands",
    )
    reported = _beside(
        _legend(entity(results.RESULTS, plots.LEGEND)),
        *(_plot(f"{kind} [{unit}]", entity(results.RESULTS, kind)) for unit, kind in results.KINDS.items()),
        _plot(results.OTHERS, entity(results.RESULTS, results.OTHERS)),
        name="results",
    )
    return rrb.Tabs(overview, base, reported, *(_joints(group) for group in groups), name="plots", active_tab=0)


def _joints(group: str) -> Any:
    path = entity(plots.JOINTS, group)
    return rrb.Horizontal(
        _plot("position [rad]: wide measured, thin setpoint", path, "position", "setpoint", "soft_limit"),
        _plot("torque [Nm]", path, "torque"),
        _legend(entity(plots.JOINTS, group, plots.LEGEND)),
        column_shares=[5, 5, 2],
        name=group.replace("_", " "),
    )


def _beside(legend: Any, *views: Any, name: str) -> Any:
    """Return plots, two in a row, with the legend of all of them beside."""
    return rrb.Horizontal(rrb.Grid(*views, grid_columns=2), legend, column_shares=[8, 2], name=name)


def _legend(path: str) -> Any:
    """Return a plot of nothing but a legend."""
    return _plot("legend", path, corner=rrb.Corner2D.LeftTop)


def _plot(
    name: str,
    path: str,
    *parts: str,
    corner: rrb.Corner2D | None = None,
    range_y: tuple[float, float] | None = None,
) -> Any:
    """Return a plot.

    Args:
        name: what it shows, with its unit.
        path: entity of its curves.
        parts: those entities below that are shown, if not all are.
        corner: of the legend, None for no legend; the viewer has no other place for it.
        range_y: where its axis begins and ends, if that is known.
    """
    return rrb.TimeSeriesView(
        name=name,
        contents=[f"+ /{path}/{part}" for part in parts] or f"+ /{path}/**",
        axis_x=_ONE_TIME,
        axis_y=rrb.ScalarAxis(range=range_y) if range_y else None,
        plot_legend=rrb.PlotLegend(corner, visible=corner is not None),
    )


def _log_columns() -> Any:
    kinds = (rrb.encodings.TextLogColumnKind.LogLevel, rrb.encodings.TextLogColumnKind.Body)
    return rrb.TextLogColumns(
        timeline_columns=[rrb.encodings.TimelineColumn(TIMELINE)],
        text_log_columns=[rrb.encodings.TextLogColumn(kind) for kind in kinds],
    )
