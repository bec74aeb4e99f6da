"""S1's potential on a map is what it is among discs, and its descent keeps clear."""

import math
from itertools import pairwise

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_planner.grid.bit_grid import BitMask
from quad_planner.grid.line_of_sight import sees
from quad_planner.potential.map_potential import Gains, MapPotential, boundary_distances
from quad_planner.potential.potential_field import PotentialField, RoundObstacle

RESOLUTION = 0.05


def discs(size, *circles):
    """Draw discs, given by center and radius in metres, on a square floor."""
    centers = (np.indices((size, size)) + 0.5) * RESOLUTION
    mask = np.zeros((size, size), dtype=bool)
    for x, y, radius in circles:
        mask |= np.hypot(centers[1] - x, centers[0] - y) <= radius
    return mask


def potential(mask, goal, **gains):
    forbidden = BitMask.of(mask)
    distances = boundary_distances(forbidden, 0.0, RESOLUTION)
    return MapPotential(
        forbidden, distances, RESOLUTION, np.array(goal) / RESOLUTION, Gains(**gains)
    )


ONE = potential(discs(120, (3.0, 3.0, 0.5)), (5.0, 4.0), goal_distance=2.0)


def test_around_one_disc_it_is_the_potential_of_a_round_obstacle():
    exact = PotentialField((5.0, 4.0), (RoundObstacle(3.0, 3.0, 0.5),), goal_distance=2.0)
    for point in np.random.default_rng(0).uniform(0.1, 5.9, (300, 2)):
        distance = math.hypot(*(point - 3.0)) - 0.5
        if distance < 0.3 or abs(distance - 1.5) < 0.1:
            continue
        assert ONE.potential(point / RESOLUTION) == pytest.approx(
            exact.potential(point), rel=0.05, abs=0.1
        )
        # The disc is drawn in squares.
        error = ONE.gradient(point / RESOLUTION) - exact.gradient(point)
        assert np.hypot(*error) < 0.1 + 0.3 * np.hypot(*exact.gradient(point))


def test_the_gradient_is_the_slope_of_the_potential():
    h = 1e-5
    for point in np.random.default_rng(1).uniform(1.0, 119.0, (300, 2)):
        if np.abs((point - 0.5) % 1.0 - 0.5).max() > 0.49:
            # The distance has a kink on the lines between centers.
            continue
        slope = [
            (ONE.potential(point + h * axis) - ONE.potential(point - h * axis))
            / (2.0 * h * RESOLUTION)
            for axis in np.eye(2)
        ]
        if abs(ONE.potential(point)) < 1e4:
            assert ONE.gradient(point) == pytest.approx(np.array(slope), rel=1e-3, abs=1e-3)


def test_distances_are_exact_and_without_obstacles_infinite():
    mask = discs(60, (1.0, 1.4, 0.3), (2.4, 0.4, 0.2))
    distances = boundary_distances(BitMask.of(mask), 0.2, RESOLUTION)
    cells = np.argwhere(mask)
    for y, x in np.random.default_rng(2).integers(0, 60, (100, 2)):
        nearest = np.hypot(*(cells - (y, x)).T).min()
        assert distances[y, x] == pytest.approx((nearest - 0.5) * RESOLUTION - 0.2, abs=1e-5)
    nothing = BitMask.of(np.zeros((4, 70), dtype=bool))
    assert np.isinf(boundary_distances(nothing, 0.2, RESOLUTION)).all()


@pytest.mark.parametrize('shape', [(1, 60), (60, 1), (1, 1), (50, 50)])
def test_without_obstacles_the_descent_is_straight(shape):
    forbidden = BitMask.of(np.zeros(shape, dtype=bool))
    goal = np.array([0.9 * shape[1], 0.9 * shape[0]])
    field = MapPotential(forbidden, np.full(shape, np.inf), RESOLUTION, goal)
    start = np.array([0.1 * shape[1], 0.2 * shape[0]])
    path, has_arrived = field.descend(start)
    assert has_arrived
    assert path[0] == pytest.approx(start)
    assert path[-1] == pytest.approx(goal)
    lengths = np.hypot(*np.diff(path, axis=0).T)
    assert lengths.sum() == pytest.approx(np.hypot(*(goal - start)))


@pytest.mark.parametrize('seed', range(30))
def test_the_potential_falls_with_every_step_and_no_step_is_forbidden(seed):
    rng = np.random.default_rng(seed)
    circles = [(*rng.uniform(0.5, 5.5, 2), rng.uniform(0.1, 0.5)) for _ in range(6)]
    field = potential(discs(120, *circles), rng.uniform(0.2, 5.8, 2))
    forbidden = field.forbidden
    for start in rng.uniform(0.0, 120.0, (5, 2)):
        if forbidden[int(start[1]), int(start[0])]:
            continue
        path, has_arrived = field.descend(start)
        values = [field.potential(point) for point in path]
        fallen = np.diff(values[:-1] if has_arrived else values)
        assert (fallen < 0.0).all()
        lengths = np.hypot(*np.diff(path, axis=0).T)
        assert (lengths <= 1.0 + 1e-9).all()
        for a, b in pairwise(path):
            assert sees(forbidden.words, forbidden.width, *a, *b)


def test_straight_before_a_pillar_is_a_saddle():
    field = potential(discs(121, (3.025, 3.025, 0.5)), (5.525, 3.025))
    near, far = 20.5, 49.0
    while far - near > 1e-6:
        middle = 0.5 * (near + far)
        if field.gradient(np.array([middle, 60.5]))[0] < 0.0:
            near = middle
        else:
            far = middle
    kind, (low, high) = field.critical_point(np.array([near, 60.5]))
    assert kind == 'a saddle point'
    assert low < 0.0 < high


def test_in_a_dead_end_is_a_local_minimum():
    mask = np.zeros((120, 120), dtype=bool)
    mask[30:90, 70:75] = True
    mask[30:34, 40:75] = True
    mask[86:90, 40:75] = True
    field = potential(mask, (5.5, 3.1))
    path, has_arrived = field.descend(np.array([50.5, 55.5]))
    assert not has_arrived
    assert field.critical_point(path[-1])[0] == 'a local minimum'
    # All around it the potential is higher.
    for angle in np.linspace(0.0, 2.0 * np.pi, 16):
        ray = np.array([math.cos(angle), math.sin(angle)])
        assert field.potential(path[-1] + 0.5 * ray) > field.potential(path[-1])


def test_next_to_the_boundary_the_robot_is_pushed_away():
    mask = np.zeros((60, 60), dtype=bool)
    mask[:10] = True
    field = potential(mask, (2.5, 0.6))
    for y in (10.0, 10.001, 10.3, 11.0):
        assert field.gradient(np.array([20.3, y]))[1] < -100.0
    path, _ = field.descend(np.array([20.3, 10.0]))
    assert path[1:, 1].min() > 10.0


@pytest.mark.parametrize('name', Gains._fields)
@pytest.mark.parametrize('value', [0.0, -1.0, math.inf, math.nan])
def test_gains_must_be_positive(name, value):
    with pytest.raises(ParameterError, match=f"'{name}'"):
        Gains(**{name: value}).check()


def test_the_descent_can_be_ended_from_outside():
    class EnoughError(Exception):
        pass

    def check():
        raise EnoughError

    with pytest.raises(EnoughError):
        ONE.descend(np.array([5.0, 5.0]), check)
