"""Distances of segments are those that many points on them give, and no rotation changes them."""

import numpy as np
import pytest

from quad_common.robot.segment_distance import distance_between_segments, distance_to_box

HALF_SIZE = np.array([0.5, 0.3, 0.2])


def points_on(segments, count):
    fractions = np.linspace(0.0, 1.0, count)[:, None]
    return segments[:, None, 0] + fractions * (segments[:, None, 1] - segments[:, None, 0])


def random_segments(rng, count):
    """Draw segments, some of which are points."""
    segments = rng.normal(size=(count, 2, 3))
    segments[::7, 1] = segments[::7, 0]
    return segments


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def test_the_distance_of_segments_is_the_least_of_many_points(rng):
    first, second = random_segments(rng, 300), random_segments(rng, 300)
    found = distance_between_segments(first, second)
    offsets = points_on(first, 201)[:, :, None] - points_on(second, 201)[:, None]
    tried = np.linalg.norm(offsets, axis=-1).min(axis=(1, 2))
    assert np.all(found <= tried + 1e-12)
    assert found == pytest.approx(tried, abs=2e-3)


def test_parallel_segments_beside_and_behind_one_another():
    first = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    beside = first + [0.4, 0.3, 0.0]
    behind = first + [3.0, 0.0, 4.0]
    assert distance_between_segments(first, beside) == pytest.approx(0.3)
    assert distance_between_segments(first, behind) == pytest.approx(np.hypot(2.0, 4.0))
    assert distance_between_segments(first, first[::-1]) == pytest.approx(0.0, abs=1e-9)


def test_segments_that_cross_have_no_distance():
    first = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    second = np.array([[0.2, -1.0, 0.0], [0.2, 1.0, 0.0]])
    assert distance_between_segments(first, second) == pytest.approx(0.0, abs=1e-9)


def test_points_have_the_distance_of_points(rng):
    a, b = rng.normal(size=(2, 50, 3))
    found = distance_between_segments(np.stack([a, a], axis=1), np.stack([b, b], axis=1))
    assert found == pytest.approx(np.linalg.norm(a - b, axis=1))


def test_the_order_of_segments_and_of_their_ends_does_not_matter(rng):
    first, second = random_segments(rng, 200), random_segments(rng, 200)
    found = distance_between_segments(first, second)
    assert distance_between_segments(second, first) == pytest.approx(found, abs=1e-9)
    assert distance_between_segments(first[:, ::-1], second) == pytest.approx(found, abs=1e-9)


def test_the_distance_to_a_box_is_the_least_of_many_points(rng):
    segments = random_segments(rng, 300)
    found = distance_to_box(segments, HALF_SIZE)
    outside = np.maximum(np.abs(points_on(segments, 2001)) - HALF_SIZE, 0.0)
    tried = np.linalg.norm(outside, axis=-1).min(axis=1)
    assert np.all(found <= tried + 1e-12)
    assert found == pytest.approx(tried, abs=1e-4)


@pytest.mark.parametrize(
    ('ends', 'distance'),
    [
        # Along a face, through the box, wholly inside, and past a corner.
        (([-2.0, 0.0, 0.5], [2.0, 0.0, 0.5]), 0.3),
        (([-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]), 0.0),
        (([-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]), 0.0),
        (([0.8, 0.3, 0.6], [0.8, 0.3, 0.6]), 0.5),
    ],
)
def test_distances_to_a_box_that_are_known(ends, distance):
    assert distance_to_box(np.array(ends), HALF_SIZE) == pytest.approx(distance)


def test_a_mirrored_segment_is_as_far_from_the_box(rng):
    segments = random_segments(rng, 100)
    for axis in range(3):
        mirrored = segments * np.where(np.arange(3) == axis, -1.0, 1.0)
        assert distance_to_box(mirrored, HALF_SIZE) == pytest.approx(
            distance_to_box(segments, HALF_SIZE), abs=1e-12
        )
