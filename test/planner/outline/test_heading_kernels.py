"""
Kernels of an outline: every cell that it can reach, at any heading of a class, and no other.
"""

import math
import re

import numpy as np
import pytest

from quad_common.errors import CellsTooSmall, ParameterError
from quad_common.robot_files.robot_file import load_robot
from quad_planner.outline.heading_kernels import CLASSES, STEP, class_of, kernels_of
from quad_planner.outline.robot_outline import (
    convex_hull,
    inner_radius,
    outer_radius,
    outline_from_text,
    standing_outline,
)

TAIL = convex_hull([(0.25, 0.15), (0.25, -0.15), (-0.2, -0.2), (-0.6, 0.0), (-0.2, 0.2)])
CELL = 0.05


def boundary(outline, heading, x, y):
    """Return points four millimetres apart on the boundary of a polygon at a pose [m]."""
    ends = np.roll(outline, -1, axis=0)
    points = np.concatenate(
        [
            a + (b - a) * np.linspace(0.0, 1.0, math.ceil(250.0 * math.dist(a, b)))[:, None]
            for a, b in zip(outline, ends)
        ]
    )
    cos, sin = math.cos(heading), math.sin(heading)
    return points @ np.array([[cos, sin], [-sin, cos]]) + (x, y)


def cells_near(points, distance):
    """Return the cells whose squares are nearer to points than a distance, column and row."""
    cells = set()
    reach = math.ceil(distance / CELL) + 1
    for dx in range(-reach, reach + 1):
        for dy in range(-reach, reach + 1):
            corner = (np.floor(points / CELL) + (dx, dy)) * CELL
            apart = np.hypot(*np.maximum(np.maximum(corner - points, points - corner - CELL), 0).T)
            near = np.floor(points / CELL)[apart < distance] + (dx, dy)
            cells |= set(map(tuple, near.astype(int).tolist()))
    return cells


@pytest.mark.parametrize('distance', [0.0, 0.07])
@pytest.mark.parametrize('k', [0, 5, 9, 31, 71])
def test_every_cell_that_the_outline_reaches_is_in_its_kernel(distance, k):
    kernels = kernels_of(TAIL, distance, CELL)
    rng = np.random.default_rng(k)
    for _ in range(10):
        heading = (k + rng.uniform(-0.5, 0.5)) * STEP
        points = boundary(TAIL, heading, *rng.uniform(0.0, CELL, 2))
        for column, row in cells_near(points, max(distance, 1e-4) - 1e-4):
            at = row + kernels.rows
            assert kernels.low[k, at] <= column <= kernels.high[k, at]


def test_no_cell_of_a_kernel_is_out_of_reach():
    distance, k = 0.07, 5
    kernels = kernels_of(TAIL, distance, CELL)
    reached = set()
    for turn in np.linspace(-0.5, 0.5, 5):
        for x in np.linspace(0.0, CELL, 3):
            for y in np.linspace(0.0, CELL, 3):
                points = boundary(TAIL, (k + turn) * STEP, x, y)
                # The polygon of a class is a little larger than what it holds.
                reached |= cells_near(points, distance + 0.006)
    edge = {
        (int(column), row - kernels.rows)
        for row in range(2 * kernels.rows + 1)
        for column in (kernels.low[k, row], kernels.high[k, row])
        if kernels.low[k, row] <= kernels.high[k, row]
    }
    assert edge <= reached


def test_cells_too_small_for_an_outline_are_refused_at_once():
    reach = outer_radius(TAIL) + 0.1
    with pytest.raises(
        CellsTooSmall, match=r"cells of 0\.0001 m are too small .* footprint 'circle'"
    ):
        kernels_of(TAIL, 0.1, 1e-4)
    told = set()
    for cells in (128.4, 131.0, 150.0, 977.0):
        with pytest.raises(CellsTooSmall) as refused:
            kernels_of(TAIL, 0.1, reach / cells)
        told.add((re.search(r'Use cells of (\S+) m', str(refused.value))[1], refused.value.most))
    # The same, whatever was too small.
    [(least, most)] = told
    assert kernels_of(TAIL, 0.1, float(least)).rows <= most


def test_classes_go_round():
    assert [class_of(k * STEP) for k in range(CLASSES)] == list(range(CLASSES))
    assert class_of(-0.4 * STEP) == 0
    assert class_of(2.0 * math.pi - 0.6 * STEP) == CLASSES - 1


@pytest.mark.parametrize('name', ['genibo', 'titan_viii'])
def test_the_outline_holds_feet_and_body(name):
    robot = load_robot(name)
    outline = standing_outline(robot)
    parts = [*robot.neutral_feet[:, :2].tolist(), *robot.own_parts.shape.body_corners()[:, :2]]
    assert np.allclose(convex_hull(np.vstack((outline, parts))), outline)
    assert 0.0 < inner_radius(outline) < outer_radius(outline)
    # Nearly within the circle, which leaves out the knees.
    assert outer_radius(outline) < robot.footprint_radius + 0.02


def test_an_outline_is_read_as_nav2_writes_it():
    outline = outline_from_text('[[0.3, 0.2], [-0.5, 0.2], [-0.5, -0.2], [0.3, -0.2], [0.1, 0.1]]')
    assert sorted(map(tuple, outline.tolist())) == [
        (-0.5, -0.2),
        (-0.5, 0.2),
        (0.3, -0.2),
        (0.3, 0.2),
    ]


@pytest.mark.parametrize(
    'text',
    [
        'round',
        '[]',
        '[[0, 0], [1, 0]]',
        '[[1, 0], [2, 0], [2, 1]]',
        '[[1, 0], [-1, 20], [-1, -1]]',
        '[[1, 0], [0, inf], [0, -1]]',
        '[[1, 0], [0, 1e999], [-1, -1]]',
        '[1, 2, 3]',
        '__import__("os")',
    ],
)
def test_what_is_no_outline_is_refused(text):
    with pytest.raises(ParameterError, match='at least three corners'):
        outline_from_text(text)
