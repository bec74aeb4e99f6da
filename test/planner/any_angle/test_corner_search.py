"""Quickest paths over corners, against a search over all that see each other."""

import itertools
import math

import numpy as np
import pytest
from exact_segments import segments_allowed

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_lab.benchmarks.planning.plain_searches import least_cycles_over_points
from quad_lab.benchmarks.planning.small_requests import RESOLUTION, random_requests
from quad_planner.any_angle.corner_search import quickest_corners as search_corners
from quad_planner.any_angle.free_space import FreeSpace
from quad_planner.any_angle.rectangles import corners_of
from quad_planner.grid.bit_grid import BitGrid, BitMask
from quad_planner.grid.line_of_sight import sees
from quad_planner.search.walk_terms import WalkTerms
from quad_planner.wave.wave_search import quickest_path

CRAWL = WalkingTimeModel(cycle_period=5.0, stride=0.226, turn=math.radians(44.2))


def quickest_corners(forbidden, points, terms, **more):
    return search_corners(FreeSpace.outside(forbidden), forbidden, points, terms, **more)


def cycles_of(path, start_yaw, goal_yaw, pace):
    points = path * RESOLUTION
    return pace.cycles(Pose2D(*points[0], start_yaw), Plan.through(points, goal_yaw))


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('seed', range(3))
def test_no_path_takes_fewer_cycles(seed):
    for request in random_requests(seed, 20):
        _, start, goal, start_yaw, goal_yaw, pace = request
        free = request.free[:18, :18]
        if max(start[0], goal[0]) >= free.shape[1] or max(start[1], goal[1]) >= free.shape[0]:
            continue
        lattice = quickest_path(
            BitGrid.of(free), start, goal, WalkTerms(pace, RESOLUTION, start_yaw, goal_yaw, 500)
        )
        if lattice is None:
            continue
        points = np.vstack(([start, goal], lattice.cells[1:-1])) + 0.5
        corners = corners_of(FreeSpace.outside(BitMask.of(~free)).rectangles)
        everywhere = np.vstack((points, np.unique(corners, axis=0)))
        least = least_cycles_over_points(BitMask.of(~free), everywhere, request)
        # The lattice's own path leads over these points.
        assert least <= lattice.cycles
        path = quickest_corners(
            BitMask.of(~free),
            points,
            WalkTerms(pace, RESOLUTION, start_yaw, goal_yaw, lattice.cycles + 1),
        )
        assert cycles_of(path, start_yaw, goal_yaw, pace) == least
        for a, b in itertools.pairwise(path):
            assert sees(BitMask.of(~free).words, free.shape[1], *a, *b)
        assert (
            quickest_corners(
                BitMask.of(~free), points, WalkTerms(pace, RESOLUTION, start_yaw, goal_yaw, least)
            )
            is None
        )


def test_a_path_may_turn_where_no_shortest_path_does():
    # Around the corner at (6, 1) the path bends away from the forbidden cell, towards points where
    # such cells touch: 10 cycles, where paths that turn as shortest paths do take 12.
    rows = [  # the upper row first
        '..##....#....##..#',
        '....#.#.........##',
        '....#..#.......#..',
        '............##.#.#',
        '...#.....#.#...#.#',
        '..#..#..#.#..#....',
        '..#...#....###.#..',
        '#......#..####..#.',
        '#..#..#....##.....',
        '..#............#..',
        '......#.##......#.',
        '..#......#........',
        '...#.##.#....#..##',
        '#..###..##....#.##',
        '#.....###.##......',
        '..##....#..#......',
        '#..###.#.#..#.....',
    ]
    free = np.array([[cell == '.' for cell in row] for row in rows[::-1]])
    forbidden = BitMask.of(~free)
    pace = WalkingTimeModel(cycle_period=1.0, stride=0.439, turn=math.radians(44.2))
    points = np.array([[2.5, 3.5], [17.5, 2.5]])
    start_yaw, goal_yaw = 0.788, 1.548
    plain = np.array([[2.5, 3.5], [3.0, 3.0], [6.0, 1.0], [8.0, 1.0], [13.0, 1.0], [17.5, 2.5]])
    for here, there in itertools.pairwise(plain):
        assert segments_allowed(free, here[None], there - here)[0]
        assert sees(forbidden.words, forbidden.width, *here, *there)
    assert cycles_of(plain, start_yaw, goal_yaw, pace) == 10
    path = quickest_corners(forbidden, points, WalkTerms(pace, RESOLUTION, start_yaw, goal_yaw, 40))
    assert cycles_of(path, start_yaw, goal_yaw, pace) == 10


def test_bends_cost_nothing():
    # A wall whose end is rounded: the path around it bends a little at each corner.
    free = np.ones((60, 120), dtype=bool)
    y, x = np.mgrid[:60, :120]
    free[(x + 0.5 - 60) ** 2 / 50**2 + (y + 0.5) ** 2 / 20**2 < 1.0] = False
    start, goal = np.array([2.5, 5.5]), np.array([117.5, 5.5])
    points = np.vstack((start, goal))
    bending = WalkingTimeModel(cycle_period=5.0, stride=0.226, turn=math.radians(44.2))
    never = WalkingTimeModel(cycle_period=5.0, stride=0.226, turn=math.radians(44.2), bend=0.0)
    yaw = math.radians(30.0)
    took = {
        name: cycles_of(
            quickest_corners(
                BitMask.of(~free), points, WalkTerms(pace, RESOLUTION, yaw, -yaw, 200)
            ),
            yaw,
            -yaw,
            pace,
        )
        for name, pace in (('bending', bending), ('never', never))
    }
    assert took['bending'] < took['never']


def test_a_goal_that_is_not_seen_has_no_path():
    free = np.ones((10, 10), dtype=bool)
    free[:, 5] = False
    points = np.array([[1.5, 1.5], [8.5, 1.5]])
    assert (
        quickest_corners(BitMask.of(~free), points, WalkTerms(CRAWL, RESOLUTION, 0.0, 0.0, 100))
        is None
    )


def test_a_search_can_be_ended():
    free = np.ones((30, 30), dtype=bool)

    def end():
        raise TimeoutError

    with pytest.raises(TimeoutError):
        quickest_corners(
            BitMask.of(~free),
            np.array([[1.5, 1.5], [20.5, 9.5]]),
            WalkTerms(CRAWL, RESOLUTION, 0.0, 0.0, 100),
            check=end,
        )
