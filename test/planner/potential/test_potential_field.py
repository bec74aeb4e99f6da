"""The potential field falls towards the goal, and rises towards obstacles nearby."""

import math
import re

import numpy as np
import pytest

from quad_common.errors import DescentStuck, NoPathFound, ParameterError
from quad_planner.potential.potential_field import (
    PotentialField,
    RoundObstacle,
    critical_point,
)

GOAL = (3.0, 2.0)
PILLAR = RoundObstacle(1.5, 1.2, 0.3)
FIELD = PotentialField(GOAL, (PILLAR, RoundObstacle(-1.0, 2.0, 0.5)), goal_distance=4.0)
OPEN = PotentialField((4.0, 0.0), ())
HEAD_ON = PotentialField((4.0, 0.0), (RoundObstacle(2.0, 0.0, 0.3),))
"""From the origin the obstacle stands exactly before the goal."""


def clearance(field, point):
    return min(math.hypot(point[0] - o.x, point[1] - o.y) - o.radius for o in field.obstacles)


def random_points(count=300, seed=1):
    """Return points outside the obstacles, near and far from the goal."""
    points = np.random.default_rng(seed).uniform((-4.0, -4.0), (8.0, 7.0), (count, 2))
    return [point for point in points if clearance(FIELD, point) > 0.05]


def numeric_gradient(field, point, h=1e-6):
    axes = np.eye(2)
    return np.array(
        [
            (field.potential(point + h * axis) - field.potential(point - h * axis)) / (2.0 * h)
            for axis in axes
        ]
    )


def lengths(path):
    return np.linalg.norm(np.diff(path, axis=0), axis=1)


def test_the_gradient_is_the_slope_of_the_potential():
    for point in random_points():
        expected = numeric_gradient(FIELD, point)
        assert FIELD.gradient(point) == pytest.approx(expected, rel=1e-4, abs=1e-6)


def test_potential_and_gradient_are_continuous_where_the_pieces_meet():
    influence = FIELD.influence + PILLAR.radius
    for angle in np.linspace(0.0, 2.0 * np.pi, 12):
        ray = np.array([math.cos(angle), math.sin(angle)])
        for center, radius in ((GOAL, FIELD.goal_distance), ((PILLAR.x, PILLAR.y), influence)):
            inside, outside = (center + (radius + sign * 1e-9) * ray for sign in (-1.0, 1.0))
            assert FIELD.potential(inside) == pytest.approx(FIELD.potential(outside), abs=1e-6)
            assert FIELD.gradient(inside) == pytest.approx(FIELD.gradient(outside), abs=1e-6)


def test_the_goal_is_the_minimum_where_no_obstacle_reaches():
    goal = np.array(GOAL)
    far = PotentialField(GOAL, (RoundObstacle(0.0, 0.0, 0.3),))
    assert far.potential(goal) == 0.0
    assert far.gradient(goal) == pytest.approx([0.0, 0.0])
    for point in random_points():
        if clearance(far, point) > 0.0:
            assert far.potential(point) > 0.0


def test_without_obstacles_the_attraction_is_a_bowl_with_a_cone_around_it():
    field = PotentialField((0.0, 0.0), (), attraction=2.0, goal_distance=3.0)
    for away in (0.5, 1.0, 2.9):
        assert field.potential(np.array([away, 0.0])) == pytest.approx(away**2)
        assert field.gradient(np.array([0.0, away])) == pytest.approx([0.0, 2.0 * away])
    for away in (3.1, 10.0, 1000.0):
        assert field.potential(np.array([away, 0.0])) == pytest.approx(6.0 * away - 9.0)
        assert field.gradient(np.array([0.0, away])) == pytest.approx([0.0, 6.0])


def test_obstacles_repel_within_their_influence_only():
    alone = PotentialField(GOAL, (PILLAR,))
    free = PotentialField(GOAL, ())
    for point in random_points():
        distance = clearance(alone, point)
        if distance <= 0.0:
            continue
        push = alone.gradient(point) - free.gradient(point)
        more = alone.potential(point) - free.potential(point)
        if distance > alone.influence:
            assert (more, *push) == (0.0, 0.0, 0.0)
        else:
            outward = (point - (PILLAR.x, PILLAR.y)) / (distance + PILLAR.radius)
            assert more > 0.0
            # The gradient points uphill: straight at the obstacle.
            assert push / np.linalg.norm(push) == pytest.approx(-outward)


def test_the_repulsion_grows_without_bound_towards_the_obstacle():
    points = [np.array([PILLAR.x + PILLAR.radius + d, PILLAR.y]) for d in (1.0, 0.1, 1e-3, 1e-6)]
    values = [FIELD.potential(point) for point in points]
    assert values == sorted(values)
    assert values[-1] > 1e9


def test_within_an_obstacle_the_potential_is_infinite():
    for offset in (0.0, 0.1, 0.299):
        assert FIELD.potential(np.array([PILLAR.x, PILLAR.y + offset])) == math.inf


def test_a_mirrored_field_has_the_mirrored_gradient():
    flip = np.array([1.0, -1.0])
    mirrored = PotentialField(
        (GOAL[0], -GOAL[1]),
        [RoundObstacle(o.x, -o.y, o.radius) for o in FIELD.obstacles],
        goal_distance=FIELD.goal_distance,
    )
    for point in random_points(50):
        assert mirrored.gradient(flip * point) == pytest.approx(flip * FIELD.gradient(point))


@pytest.mark.parametrize('start', [(0.0, 0.0), (0.0, 1.5), (-9.0, -9.0), (1.1, 1.2), (3.0, -4.0)])
@pytest.mark.parametrize('step', [0.01, 0.02, 0.1])
def test_the_descent_arrives_in_steps_of_one_length(start, step):
    path = FIELD.descend(start, step)
    assert path[0] == pytest.approx(start)
    assert path[-1] == pytest.approx(GOAL)
    assert lengths(path)[:-1] == pytest.approx(step)
    assert 0.0 < lengths(path)[-1] <= max(step, 0.02)


def test_the_descent_stays_clear_of_obstacles():
    rng = np.random.default_rng(3)
    arrived = 0
    for _ in range(30):
        pillars = [RoundObstacle(x, y, 0.2) for x, y in rng.uniform((1, -2), (5, 2), (3, 2))]
        field = PotentialField((7.0, 0.0), pillars)
        try:
            path = field.descend((-1.0, float(rng.uniform(-1.0, 1.0))))
        except NoPathFound:
            continue
        arrived += 1
        assert min(clearance(field, point) for point in path) > 0.1
    assert arrived >= 20


def test_without_obstacles_the_descent_is_straight():
    path = OPEN.descend((1.0, 3.0))
    assert lengths(path).sum() == pytest.approx(math.hypot(3.0, 3.0))
    assert path[:, 0] + path[:, 1] == pytest.approx(np.full(len(path), 4.0))


def test_the_potential_falls_along_the_descent():
    path = FIELD.descend((0.0, 0.0))
    values = np.array([FIELD.potential(point) for point in path])
    # Next to the obstacle a step of one length may climb the valley's other side a little.
    assert np.all(np.diff(values) < 0.02)
    assert values[0] > values[len(values) // 2] > values[-1]


def test_a_tolerance_ends_the_descent_earlier():
    path = OPEN.descend((0.0, 0.0), step=0.02, tolerance=0.5)
    assert path[-1] == pytest.approx([4.0, 0.0])
    assert 0.48 < lengths(path)[-1] <= 0.5


def test_at_the_goal_the_descent_is_over_at_once():
    path = FIELD.descend(GOAL)
    assert lengths(path).sum() == 0.0
    assert path[-1] == pytest.approx(GOAL)


def test_a_descent_that_gets_stuck_says_where():
    with pytest.raises(NoPathFound) as caught:
        HEAD_ON.descend((0.0, 0.0))
    sentence = str(caught.value)
    assert '\n' not in sentence
    assert 'no path from (0.00, 0.00) m to (4.00, 0.00) m' in sentence
    # To and fro, a step apart.
    assert re.search(r'comes to rest at \(1\.(38|40), 0\.00\) m', sentence)
    # There attraction and repulsion are equal, but for the length of a step.
    downhill = [HEAD_ON.gradient(np.array([x, 0.0]))[0] for x in (1.38, 1.42)]
    assert downhill[0] < 0.0 < downhill[1]


def test_a_little_beside_the_line_the_descent_gets_past():
    path = HEAD_ON.descend((0.0, 0.2))
    assert path[-1] == pytest.approx([4.0, 0.0])
    assert min(clearance(HEAD_ON, point) for point in path) > 0.1


def test_a_goal_next_to_an_obstacle_is_not_reached_in_silence():
    field = PotentialField((2.7, 0.0), (RoundObstacle(2.0, 0.0, 0.3),))
    with pytest.raises(NoPathFound, match=r'comes to rest at \(2\.9'):
        field.descend((4.0, 0.0))


def test_a_path_that_is_too_long_is_given_up():
    with pytest.raises(NoPathFound):
        OPEN.descend((0.0, 0.0), longest=1.0)
    assert OPEN.descend((0.0, 0.0), longest=4.0)[-1] == pytest.approx([4.0, 0.0])


@pytest.mark.parametrize('name', ['repulsion', 'attraction', 'influence', 'goal_distance'])
@pytest.mark.parametrize('value', [0.0, -1.0, -math.inf, math.nan])
def test_factors_and_distances_must_be_positive(name, value):
    with pytest.raises(ParameterError, match=f"'{name}' is .* must be positive"):
        PotentialField(GOAL, (), **{name: value})


@pytest.mark.parametrize('step', [0.0, -0.02, math.nan])
def test_a_step_that_leads_nowhere_is_refused_by_name(step):
    with pytest.raises(ParameterError, match="'step'"):
        OPEN.descend((0.0, 0.0), step=step)


def test_a_descent_from_within_an_obstacle_is_refused():
    with pytest.raises(NoPathFound):
        FIELD.descend((PILLAR.x, PILLAR.y + 0.1))


def test_a_path_that_is_too_long_is_not_called_a_local_minimum():
    with pytest.raises(NoPathFound) as caught:
        OPEN.descend((0.0, 0.0), longest=1.0)
    assert 'comes to rest' not in str(caught.value)


def test_the_hessian_is_the_slope_of_the_gradient():
    h = 1e-6
    for point in random_points(100):
        distances = [math.hypot(*(point - (o.x, o.y))) - o.radius for o in FIELD.obstacles]
        if min(abs(d - FIELD.influence) for d in distances) < 1e-3:
            continue
        slopes = [
            (FIELD.gradient(point + h * axis) - FIELD.gradient(point - h * axis)) / (2.0 * h)
            for axis in np.eye(2)
        ]
        assert FIELD.hessian(point) == pytest.approx(np.array(slopes), rel=1e-3, abs=1e-4)


@pytest.mark.parametrize(
    ('hessian', 'kind'),
    [
        ([[2.0, 0.5], [0.5, 3.0]], 'a local minimum'),
        ([[-2.0, 0.5], [0.5, -3.0]], 'a local maximum'),
        ([[2.0, 0.0], [0.0, -1e-3]], 'a saddle point'),
        ([[0.0, 1.0], [1.0, 0.0]], 'a saddle point'),
        ([[2.0, 2.0], [2.0, 2.0]], 'a degenerate critical point'),
        ([[0.0, 0.0], [0.0, 0.0]], 'a degenerate critical point'),
    ],
)
def test_the_kind_of_a_critical_point_is_told_by_its_eigenvalues(hessian, kind):
    told, eigenvalues = critical_point(np.array(hessian))
    assert told == kind
    assert eigenvalues == pytest.approx(np.linalg.eigvalsh(hessian))


def test_straight_before_a_pillar_is_a_saddle_and_in_a_trap_a_local_minimum():
    with pytest.raises(DescentStuck) as caught:
        HEAD_ON.descend((0.0, 0.0))
    assert caught.value.kind == 'a saddle point'
    assert 'a saddle point: attraction and repulsion are equal' in str(caught.value)
    assert caught.value.place == pytest.approx((1.39, 0.0), abs=0.02)
    trap = [RoundObstacle(2.0, y, 0.3) for y in np.linspace(-0.6, 0.6, 5)]
    trap += [RoundObstacle(x, y, 0.3) for x in (1.4, 1.7) for y in (-0.8, 0.8)]
    with pytest.raises(DescentStuck) as caught:
        PotentialField((4.0, 0.0), trap).descend((0.0, 0.1))
    assert caught.value.kind == 'a local minimum'
    assert min(caught.value.eigenvalues) > 0.0
    assert isinstance(caught.value, NoPathFound)
    assert caught.value.code == NoPathFound.code


def test_the_example_of_the_paper_arrives_and_a_pillar_on_its_diagonal_stops_it():
    # S1 part V.A with table I; the radii, and the third obstacle's place, are lost.
    pillars = [RoundObstacle(1.0, 3.0, 0.5), RoundObstacle(5.0, 7.0, 0.5)]
    path = PotentialField((8.0, 8.0), pillars).descend((0.0, 0.0))
    assert path[-1] == pytest.approx([8.0, 8.0])
    assert min(math.hypot(*(p - (o.x, o.y))) - o.radius for p in path for o in pillars) > 0.3
    third = RoundObstacle(4.0, 4.0, 0.5)
    with pytest.raises(DescentStuck) as caught:
        PotentialField((8.0, 8.0), [third]).descend((0.0, 0.0))
    assert caught.value.kind == 'a saddle point'
    # The two others push it off the diagonal.
    PotentialField((8.0, 8.0), [*pillars, third]).descend((0.0, 0.0))
