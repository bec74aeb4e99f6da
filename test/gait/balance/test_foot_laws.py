"""Where feet land, and how they get there, follows from laws."""

import math

import numpy as np
import pytest

from quad_common.rotations import matrix_from_angles
from quad_gait.balance.foot_laws import (
    GRAVITY,
    Pace,
    ground_velocity,
    landing_place,
    pendulum_time,
    swing_height,
    swing_on,
    tilted_back,
)

RNG = np.random.default_rng(19)


def test_a_body_at_rest_puts_its_feet_under_itself():
    assert landing_place(0.2, 0.1, (0.0, 0.0), (0.0, 0.0), 0.2, 0.1) == (0.2, 0.1)


def test_a_foot_that_lands_is_at_its_neutral_place_in_mid_stance():
    pace, stance = Pace(0.5, -0.2, 0.3), 0.24
    neutral = (0.2, 0.1)
    drift = ground_velocity(*neutral, pace)
    place = np.array(landing_place(*neutral, drift, (0.0, 0.0), stance, 1.0))
    # The ground passes under the body for half of the stance.
    for _ in range(1000):
        place = place + np.array(ground_velocity(*place, pace)) * (stance / 2.0) / 1000.0
    # A turn bends the path a little.
    assert place == pytest.approx([0.2, 0.1], abs=2e-3)


def test_a_pendulum_comes_to_rest_over_the_capture_point():
    height, speed = 0.3, 0.4
    tau = pendulum_time(height)
    foot = landing_place(0.0, 0.0, (0.0, 0.0), (tau * speed, 0.0), 0.2, 1.0)[0]
    x, dt = 0.0, 1e-5
    for _ in range(round(3.5 * tau / dt)):
        speed += dt * GRAVITY / height * (x - foot)
        x += dt * speed
    assert x == pytest.approx(foot, abs=0.05 * foot)
    assert speed == pytest.approx(0.0, abs=0.02)


def test_no_foot_lands_farther_than_it_may():
    for _ in range(50):
        drift, excess = RNG.normal(0.0, 1.0, (2, 2)).tolist()
        x, y = landing_place(0.1, -0.2, tuple(drift), tuple(excess), 0.3, 0.07)
        assert math.hypot(x - 0.1, y + 0.2) <= 0.07 + 1e-12


@pytest.mark.parametrize('steps', [1, 4, 10])
def test_a_swing_ends_where_and_as_fast_as_it_is_to_land(steps):
    place, velocity, left = 0.03, -0.4, 0.16
    dt = left / steps
    for k in range(steps):
        place, velocity = swing_on(place, velocity, 0.12, -0.5, left - k * dt, dt)
    assert (place, velocity) == pytest.approx((0.12, -0.5))


def test_a_swing_in_small_steps_is_the_same_as_in_large_ones():
    place, velocity = 0.0, -0.3
    for k in range(5):
        place, velocity = swing_on(place, velocity, 0.1, -0.3, 0.2 - 0.02 * k, 0.02)
    assert (place, velocity) == pytest.approx(swing_on(0.0, -0.3, 0.1, -0.3, 0.2, 0.1))


def test_a_foot_is_down_at_both_ends_of_its_swing_and_highest_halfway():
    assert swing_height(0.0) == 0.0
    assert swing_height(1.0) == pytest.approx(0.0, abs=1e-12)
    assert swing_height(0.5) == 1.0
    assert all(0.0 <= swing_height(s) <= 1.0 for s in np.linspace(-0.5, 1.5, 21))


def test_a_foot_that_gathers_its_speed_leaves_and_lands_at_rest():
    step = 1e-4
    for end in (0.0, 1.0 - step):
        rate = (swing_height(end + step, 0.1) - swing_height(end, 0.1)) / step
        assert abs(rate) < 0.05 * math.pi
    heights = [swing_height(s, 0.1) for s in np.linspace(0.0, 0.5, 40)]
    assert np.all(np.diff(heights) > 0.0)
    assert heights[-1] == pytest.approx(1.0)
    assert swing_height(0.3, 0.1) == pytest.approx(swing_height(0.7, 0.1))


def test_a_place_is_turned_back_by_the_body_s_rotation():
    for roll, pitch in RNG.normal(0.0, 0.3, (10, 2)):
        place = RNG.normal(0.0, 0.3, 3)
        rotation = matrix_from_angles(np.array([roll, pitch, 0.0]))
        assert tilted_back(*place, roll, pitch) == pytest.approx(rotation.T @ place)
