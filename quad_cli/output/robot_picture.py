"""
Draws a robot from its data: side and top of the initial posture, and where a foot gets.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle
from numpy.typing import NDArray

from quad_common.files.bounded_file import make_folder
from quad_common.files.whole_file import whole_file
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS

Array = NDArray[np.float64]

_COLORS = ('#c0392b', '#2471a3', '#d68910', '#1e8449')
"""Colors of the legs, in the order of ``LEGS``."""

_ANGLES = 61
"""Number of angles of pitch and knee for which the workspace is sampled."""


def draw_robot(robot: Robot, path: Path) -> Path:
    """
    Draw a robot.

    Parameters
    ----------
    robot : Robot
        The robot.
    path : Path
        Picture to write; its ending says which format.

    Returns
    -------
    Path
        The picture.
    """
    figure = Figure(figsize=(13.0, 4.6), layout='constrained')
    FigureCanvasAgg(figure)
    side, top, reach = figure.subplots(1, 3)
    chain = robot.stacked_legs.chain(robot.initial_joint_angles)
    lines = np.stack([np.asarray(robot.stacked_legs.hip), *chain], axis=1)
    _draw_view(side, robot, lines, (0, 2), 'side')
    _draw_view(top, robot, lines, (0, 1), 'top')
    _draw_workspace(reach, robot)
    figure.suptitle(f'{robot.name}: {robot.mass:.2f} kg, base_link at 0, initial posture')
    make_folder(path.parent)
    with whole_file(path, 'picture') as beside:
        figure.savefig(beside, dpi=110)
    return path


def _draw_view(axes: Axes, robot: Robot, lines: Array, plane: tuple[int, int], title: str) -> None:
    """Draw body, legs and center of mass as seen along one axis."""
    a, b = plane
    size, center = np.array(robot.body_size), np.array(robot.body_center)
    corner = (center - size / 2.0)[[a, b]]
    axes.add_patch(Rectangle(tuple(corner), size[a], size[b], color='0.85', zorder=0))
    for k, name in enumerate(LEGS):
        axes.plot(lines[k, :, a], lines[k, :, b], '-o', color=_COLORS[k], ms=3, label=name)
        foot = tuple(lines[k, -1, [a, b]])
        axes.add_patch(Circle(foot, robot.foot_radius, color=_COLORS[k], alpha=0.4))
    mass = robot.center_of_mass(robot.initial_joint_angles)
    axes.plot(mass[a], mass[b], 'k+', ms=12, mew=2, label='center of mass')
    if title == 'side':
        ground = float(lines[:, -1, 2].mean()) - robot.foot_radius
        axes.axhline(ground, color='0.4', lw=1)
    else:
        support = lines[[0, 1, 3, 2], -1][:, [0, 1]]
        axes.add_patch(Polygon(support, fill=False, ls=':', ec='0.4'))
        axes.legend(fontsize=7, loc='upper right')
    axes.annotate(
        'forward', (0.98, 0.02), xycoords='axes fraction', ha='right', fontsize=8, color='0.3'
    )
    axes.set_title(f'{title} [m]')
    axes.set_aspect('equal', adjustable='datalim')


def _draw_workspace(axes: Axes, robot: Robot) -> None:
    """Draw where the left front foot gets with its first joint as in the initial posture."""
    leg, lower, upper = robot.legs[0], robot.lower[0], robot.upper[0]
    pitch, knee = np.meshgrid(
        np.linspace(lower[1], upper[1], _ANGLES), np.linspace(lower[2], upper[2], _ANGLES)
    )
    angles = np.stack([np.full_like(pitch, robot.initial_joint_angles[0, 0]), pitch, knee], -1)
    feet = leg.forward(angles.reshape(-1, 3))
    across = 1 if robot.leg_type == 'yaw_pitch_pitch' else 0
    axes.plot(feet[:, across], feet[:, 2], '.', ms=1, color=_COLORS[0], alpha=0.5)
    foot = robot.neutral_feet[0]
    axes.plot(foot[across], foot[2], 'ko', ms=5, label='initial posture')
    axes.plot(leg.hip[across], leg.hip[2], 'k^', ms=6, label='hip')
    axes.legend(fontsize=7)
    axes.set_title(f'reach of {LEGS[0]} [m]')
    axes.set_aspect('equal', adjustable='datalim')
