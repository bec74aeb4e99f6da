"""Travel times solve the eikonal equation, have one minimum, and every descent arrives."""

import math
from itertools import count, pairwise

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_planner.grid.bit_grid import BitMask
from quad_planner.grid.line_of_sight import sees
from quad_planner.potential.navigation_field import (
    descend_times,
    slowness_near_obstacles,
    travel_times,
)
from quad_planner.search.distance_field import NOT_REACHED, distance_field


def random_slowness(rng, size=35):
    """Draw walls, and slow cells between them."""
    allowed = rng.random(rng.integers(3, size, 2)) > rng.choice([0.0, 0.1, 0.3])
    allowed[tuple(rng.integers(0, allowed.shape))] = True
    slowness = 1.0 + rng.choice([0.0, 1.0, 30.0]) * rng.random(allowed.shape) ** 3
    return np.where(allowed, slowness, np.inf)


def some_cell(rng, slowness):
    cells = np.argwhere(np.isfinite(slowness))
    y, x = cells[rng.integers(len(cells))]
    return int(x), int(y)


def neighbours(times):
    """Return the times west, east, south and north of every cell."""
    walled = np.pad(times, 1, constant_values=np.inf)
    return walled[1:-1, :-2], walled[1:-1, 2:], walled[:-2, 1:-1], walled[2:, 1:-1]


def minima(times, goal):
    is_lowest = np.isfinite(times) & (times <= np.minimum.reduce(neighbours(times)))
    is_lowest[goal[1], goal[0]] = False
    return int(is_lowest.sum())


@pytest.mark.parametrize('seed', range(30))
def test_the_times_solve_the_equation_in_every_cell(seed):
    rng = np.random.default_rng(seed)
    for _ in range(5):
        slowness = random_slowness(rng)
        goal = some_cell(rng, slowness)
        times = travel_times(slowness, goal)
        west, east, south, north = neighbours(times)
        reached = np.isfinite(times)
        reached[goal[1], goal[0]] = False
        a, b, t = np.minimum(west, east)[reached], np.minimum(south, north)[reached], times[reached]
        with np.errstate(invalid='ignore'):
            square = np.maximum(t - a, 0.0) ** 2 + np.maximum(t - b, 0.0) ** 2
        assert square == pytest.approx(slowness[reached] ** 2, rel=1e-6)
        assert times[goal[1], goal[0]] == 0.0


@pytest.mark.parametrize('seed', range(30))
def test_there_is_no_minimum_but_the_goal_and_every_descent_arrives(seed):
    rng = np.random.default_rng(seed)
    for _ in range(5):
        slowness = random_slowness(rng)
        goal = some_cell(rng, slowness)
        times = travel_times(slowness, goal)
        assert minima(times, goal) == 0
        allowed = np.isfinite(slowness)
        forbidden = BitMask.of(~allowed)
        for _ in range(5):
            x, y = some_cell(rng, times)
            path = descend_times(times, forbidden, (x, y) + rng.random(2), goal)
            assert tuple(np.minimum(np.floor(path[-1]), np.array(times.shape[::-1]) - 1)) == goal
            for a, b in pairwise(path):
                assert sees(forbidden.words, forbidden.width, *a, *b)


@pytest.mark.parametrize('seed', range(20))
def test_what_is_reached_is_what_is_reached_without_cutting_corners(seed):
    rng = np.random.default_rng(seed)
    slowness = random_slowness(rng)
    goal = some_cell(rng, slowness)
    reached = np.isfinite(travel_times(slowness, goal))
    assert (reached == (distance_field(np.isfinite(slowness), goal) != NOT_REACHED)).all()


def test_on_an_empty_floor_the_time_is_nearly_the_distance():
    times = travel_times(np.ones((101, 101)), (50, 50))
    rows, columns = np.indices(times.shape)
    distance = np.hypot(rows - 50, columns - 50)
    # First-order upwind differences are late, the more the nearer to the goal.
    assert (times >= distance - 1e-9).all()
    assert (times <= distance + 0.5 + 0.4 * np.log1p(distance)).all()


def test_where_it_is_slower_it_takes_longer_and_one_goes_around():
    slowness = np.ones((41, 81))
    slowness[:33, 38:43] = 20.0
    goal = (70, 10)
    times = travel_times(slowness, goal)
    assert times[10, 10] > 60.0
    path = descend_times(
        times, BitMask.of(np.zeros((41, 81), dtype=bool)), np.array([5.5, 5.5]), goal
    )
    middle = path[(path[:, 0] > 38) & (path[:, 0] < 43)]
    assert (middle[:, 1] > 32.0).all()
    # Twice as slow everywhere is twice as late, by the same ways.
    assert travel_times(2.0 * slowness, goal) == pytest.approx(2.0 * times)


def test_cells_may_be_a_million_times_slower():
    slowness = np.ones((20, 20))
    slowness[:, 10] = 1e6
    times = travel_times(slowness, (2, 2))
    assert minima(times, (2, 2)) == 0
    assert times[2, 15] == pytest.approx(1e6, rel=1e-3)


def test_until_a_cell_the_times_are_the_same():
    rng = np.random.default_rng(4)
    for _ in range(20):
        slowness = random_slowness(rng)
        goal, start = some_cell(rng, slowness), some_cell(rng, slowness)
        whole = travel_times(slowness, goal)
        part = travel_times(slowness, goal, start)
        earlier = whole <= whole[start[1], start[0]]
        assert (part[earlier] == whole[earlier]).all()


def test_a_mirrored_map_has_mirrored_times():
    rng = np.random.default_rng(5)
    slowness = random_slowness(rng)
    x, y = some_cell(rng, slowness)
    width = slowness.shape[1]
    mirrored = travel_times(slowness[:, ::-1], (width - 1 - x, y))
    assert mirrored[:, ::-1] == pytest.approx(travel_times(slowness, (x, y)), rel=1e-9)


def test_the_speed_grows_with_the_distance_to_obstacles():
    distances = np.array([[-0.05, 0.0, 0.1, 0.5, 1.0, 3.0, np.inf]])
    slowness = slowness_near_obstacles(distances, distances <= 0.0, 1.0)
    assert slowness.tolist() == [[np.inf, np.inf, 10.0, 2.0, 1.0, 1.0, 1.0]]


def test_the_descent_keeps_to_the_middle_of_a_corridor():
    distances = np.minimum(np.arange(21), np.arange(21)[::-1])[:, None] * 0.05 * np.ones((1, 80))
    slowness = slowness_near_obstacles(distances, distances <= 0.0, 1.5)
    times = travel_times(slowness, (75, 10))
    path = descend_times(times, BitMask.of(np.isinf(slowness)), np.array([4.5, 3.5]), (75, 10))
    middle = path[(path[:, 0] > 20) & (path[:, 0] < 70)]
    assert np.abs(middle[:, 1] - 10.5).max() < 0.6


@pytest.mark.parametrize('bad', [0.5, 0.0, -1.0, math.nan])
def test_a_slowness_below_one_is_refused(bad):
    slowness = np.ones((3, 4))
    slowness[1, 1] = bad
    with pytest.raises(ParameterError, match="'slowness'"):
        travel_times(slowness, (0, 0))


def test_cells_off_the_map_are_refused():
    with pytest.raises(ParameterError, match="'goal'"):
        travel_times(np.ones((3, 4)), (4, 0))
    with pytest.raises(ParameterError, match="'until'"):
        travel_times(np.ones((3, 4)), (0, 0), (0, 3))


def test_from_where_no_way_leads_nothing_descends():
    slowness = np.ones((3, 5))
    slowness[:, 2] = np.inf
    times = travel_times(slowness, (0, 1))
    assert np.isinf(times[:, 2:]).all()
    for start in ([3.5, 1.5], [2.5, 1.5], [7.0, 1.0], [-1.0, 1.0]):
        with pytest.raises(ParameterError, match="'start'"):
            descend_times(times, BitMask.of(np.isinf(slowness)), np.array(start), (0, 1))
    assert np.isinf(travel_times(slowness, (2, 1))).all()


def test_march_and_descent_can_be_ended_from_outside():
    class EnoughError(Exception):
        pass

    def check():
        if next(calls) == 1:
            raise EnoughError

    slowness = np.ones((400, 400))
    calls = count()
    with pytest.raises(EnoughError):
        travel_times(slowness, (0, 0), check=check)
    # One column wide, so that the path is long.
    times = np.arange(9000.0)[:, None] * np.ones((1, 2))
    calls = count()
    forbidden = BitMask.of(np.zeros((9000, 2), dtype=bool))
    with pytest.raises(EnoughError):
        descend_times(times, forbidden, np.array([0.5, 8999.5]), (0, 0), check)
