"""
Draws walks and plans: map, safety boundary, mesh, plan, walked track and footholds.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import cycle, pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

from quad_common.files.bounded_file import make_folder
from quad_common.files.whole_file import write_bytes
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_lab.topic_walk.walk_record import WalkRecord
from quad_planner.grid.inflation import inflate

_BETWEEN_OUTLINES = 0.5
"""Distance between two outlines on a leg [m]."""

_MARGIN = 1.0
"""Around what is of interest [m]."""


@dataclass(frozen=True)
class Scene:
    """What a picture shows a plan or a walk on."""

    grid: OccupancyGrid
    """Map."""
    robot: Robot
    """Robot."""
    clearance_radius: float
    """Distance from obstacles that the planner keeps the robot's center at [m]."""
    start: Pose2D
    """Start in the map."""
    goal: Pose2D
    """Goal in the map."""
    heights: HeightMap | None = None
    """Ground, if it is uneven."""
    level_grid: OccupancyGrid | None = None
    """Map without the obstacles of the ground; the same as the map if not given."""
    outline: NDArray[np.float64] | None = None
    """Corners of the robot's outline in the body frame, if it was planned for, shape (n, 2) [m]."""


def draw_walk(path: Path, scene: Scene, record: WalkRecord, title: str = '') -> None:
    """
    Draw a walk.

    Parameters
    ----------
    path : Path
        Where the picture goes; its ending says in which format.
    scene : Scene
        Where the robot walked.
    record : WalkRecord
        What happened.
    title : str
        Over the picture.
    """
    figure, axes = _begin(scene)
    _draw_mesh(axes, scene.grid, scene.robot.mesh_size)
    if record.footholds:
        feet = np.concatenate(record.footholds)
        axes.plot(feet[:, 0], feet[:, 1], '.', color='#2a9d2a', markersize=2, label='footholds')
    track = np.array([(pose.x, pose.y) for pose in record.poses]).reshape(-1, 2)
    axes.plot(track[:, 0], track[:, 1], color='#d62728', linewidth=1.2, label='walked')
    for k, earlier in enumerate(record.plans[:-1]):
        points = earlier.corners
        label = None if k else 'earlier plans'
        axes.plot(points[:, 0], points[:, 1], color='#a8b8f0', linewidth=0.6, label=label)
    for plan in record.plans[-1:]:
        _draw_plan(axes, plan, _COLORS[0], 'plan with turning points')
    if title:
        axes.set_title(title, fontsize=9)
    _finish(figure, axes, scene, record.plans[-1:], path)


_COLORS = ('#1f4fd8', '#d62728', '#2a9d2a', '#9467bd', '#ff8c00')


def draw_plans(path: Path, scene: Scene, plans: Mapping[str, Plan]) -> None:
    """
    Draw plans of several methods over one map.

    Parameters
    ----------
    path : Path
        Where the picture goes; its ending says in which format.
    scene : Scene
        What they were made on.
    plans : mapping of str to Plan
        By the names that are to stand beside them.
    """
    figure, axes = _begin(scene)
    if 'mesh' in plans:
        _draw_mesh(axes, scene.grid, scene.robot.mesh_size)
    for (name, plan), color in zip(plans.items(), cycle(_COLORS)):
        _draw_plan(axes, plan, color, name if len(plans) > 1 else 'plan with turning points')
    if scene.outline is not None:
        for plan in plans.values():
            _draw_outlines(axes, plan, scene.outline)
    _finish(figure, axes, scene, plans.values(), path)


def _begin(scene: Scene) -> tuple[Figure, Axes]:
    """Draw the map, over the ground if that is uneven."""
    figure = Figure(layout='constrained')
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    of_map = None
    if scene.heights is not None:
        _draw_heights(figure, axes, scene.heights)
        of_map = scene.level_grid or scene.grid
    _draw_map(axes, scene.grid, scene.clearance_radius, of_map)
    return figure, axes


def _draw_plan(axes: Axes, plan: Plan, color: str, label: str) -> None:
    points = plan.corners
    axes.plot(
        points[:, 0], points[:, 1], 'o-', color=color, linewidth=1.0, markersize=4, label=label
    )


def _draw_outlines(axes: Axes, plan: Plan, outline: NDArray[np.float64]) -> None:
    """Draw the robot at turning points, in both headings, and on the legs between."""
    places = []
    for here, there in pairwise(plan.poses):
        parts = max(1, round(here.distance_to(there) / _BETWEEN_OUTLINES))
        for part in np.arange(parts + 1) / parts:
            x, y = here.x + part * (there.x - here.x), here.y + part * (there.y - here.y)
            places.append(Pose2D(x, y, here.yaw))
    for pose in (*places, plan.poses[-1]):
        cos, sin = np.cos(pose.yaw), np.sin(pose.yaw)
        corners = outline @ np.array([[cos, sin], [-sin, cos]]) + (pose.x, pose.y)
        axes.fill(*corners.T, facecolor='none', edgecolor='#8a6d3b', linewidth=0.6)


def _finish(figure: Figure, axes: Axes, scene: Scene, plans: Iterable[Plan], path: Path) -> None:
    """Show start, goal and what is of interest, say what is what, and write the picture."""
    for pose, color, label in (
        (scene.start, '#000000', 'start'),
        (scene.goal, '#ff8c00', 'goal'),
    ):
        _draw_pose(axes, scene.robot, pose, color, label)
    interest = [(pose.x, pose.y) for pose in (scene.start, scene.goal)]
    interest += [tuple(corner) for plan in plans for corner in plan.corners]
    _frame(figure, axes, np.array(interest), _corners(scene.grid))
    axes.set_xlabel('x [m]')
    axes.set_ylabel('y [m]')
    axes.legend(fontsize=7, loc='upper left', bbox_to_anchor=(1.0, 1.0), borderaxespad=0.5)
    make_folder(path.parent)
    # Into memory: of a JPEG Pillow leaves a part where the disk is full, and no word.
    content = io.BytesIO()
    figure.savefig(content, format=path.suffix[1:].lower(), dpi=150)
    write_bytes(path, content.getvalue(), 'picture')


def _corners(grid: OccupancyGrid) -> NDArray[np.float64]:
    w, h = grid.width, grid.height
    return grid.map_to_world(np.array([(0.0, 0.0), (w, 0.0), (w, h), (0.0, h)]))


def _draw_heights(figure: Figure, axes: Axes, heights: HeightMap) -> None:
    """Draw the ground in shades."""
    x_min, y_min, x_max, y_max = heights.bounds
    image = axes.imshow(
        heights.heights,
        origin='lower',
        extent=(x_min, x_max, y_min, y_max),
        cmap='Greys_r',
        interpolation='nearest',
    )
    image.set_clim(*_shades(heights))
    figure.colorbar(image, ax=axes, shrink=0.5, label='height [m]')


def _shades(heights: HeightMap) -> tuple[float, float]:
    """Return which heights are black and white: the ground is not darker than gray."""
    known = heights.heights[~np.isnan(heights.heights)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    span = max(high - low, 0.01)
    return low - 0.6 * span, low + span


def _draw_map(
    axes: Axes,
    grid: OccupancyGrid,
    clearance_radius: float,
    of_map: OccupancyGrid | None = None,
) -> None:
    """Draw a map over the ground, if there is one; `of_map` is without the ground's obstacles."""
    forbidden = inflate(grid, clearance_radius)
    picture = np.ones((grid.height, grid.width, 4))
    if of_map is not None:
        picture[..., 3] = 0.0
    picture[forbidden] = (1.0, 0.88, 0.85, 1.0 if of_map is None else 0.5)
    picture[grid.unknown()] = (0.8, 0.8, 0.8, 1.0)
    picture[grid.occupied()] = (0.15, 0.15, 0.15, 1.0)
    if of_map is not None:
        too_much = grid.occupied() & ~of_map.occupied()
        picture[too_much] = (0.6, 0.3, 0.1, 1.0)
        if too_much.any():
            axes.plot([], [], 's', color=(0.6, 0.3, 0.1), label='too high or too steep')
    # Cells are drawn in map coordinates and brought into the world, for maps with a yaw.
    to_world = (
        Affine2D()
        .scale(grid.resolution)
        .rotate(grid.origin.yaw)
        .translate(grid.origin.x, grid.origin.y)
    )
    axes.imshow(
        picture,
        origin='lower',
        extent=(0, grid.width, 0, grid.height),
        transform=to_world + axes.transData,
        interpolation='nearest',
    )
    axes.plot([], [], 's', color='#ffe0d9', label='safety boundary')


def _draw_mesh(axes: Axes, grid: OccupancyGrid, mesh_size: float) -> None:
    width, height = grid.width * grid.resolution, grid.height * grid.resolution
    columns = np.arange(0.0, width + 1e-9, mesh_size, dtype=np.float64)
    rows = np.arange(0.0, height + 1e-9, mesh_size, dtype=np.float64)
    lines: list[list[tuple[float, float]]] = [[(x, 0.0), (x, height)] for x in columns]
    lines += [[(0.0, y), (width, y)] for y in rows]
    for index, line in enumerate(lines):
        ends = grid.origin.transform(np.array(line))
        axes.plot(
            ends[:, 0],
            ends[:, 1],
            color='#9ab',
            linewidth=0.3,
            label='mesh' if index == 0 else None,
        )


def _draw_pose(axes: Axes, robot: Robot, pose: Pose2D, color: str, label: str) -> None:
    feet = pose.transform(robot.neutral_feet)
    axes.plot(feet[:, 0], feet[:, 1], 'o', color=color, markersize=3)
    ends = pose.transform(np.array([(0.0, 0.0), (0.45, 0.0)]))
    axes.annotate(
        '',
        xy=tuple(ends[1]),
        xytext=tuple(ends[0]),
        arrowprops={'arrowstyle': '->', 'color': color, 'linewidth': 1.5},
    )
    axes.plot([], [], color=color, label=label)


def _frame(
    figure: Figure, axes: Axes, interest: NDArray[np.float64], corners: NDArray[np.float64]
) -> None:
    """Show what is of interest, the map's surroundings of it included."""
    low = np.maximum(interest.min(axis=0) - 2.0 * _MARGIN, corners.min(axis=0) - 0.2)
    high = np.minimum(interest.max(axis=0) + 2.0 * _MARGIN, corners.max(axis=0) + 0.2)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect('equal')
    width, height = high - low
    scale = 8.0 / max(width, height)
    figure.set_size_inches(max(4.0, width * scale) + 2.2, max(3.0, height * scale) + 0.6)
