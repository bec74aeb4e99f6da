"""Which feet are taken to bear load, by the torques of the motors."""

from dataclasses import replace

import numpy as np
import pytest

from quad_common.robot.leg_moments import weight_torques
from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance.balance_options import EstimateOptions
from quad_gait.balance.body_estimate import BodyEstimator, BodyReading
from quad_gait.balance.foot_laws import GRAVITY

OPTIONS = EstimateOptions()
UP = np.eye(3)[2]


def reading_of(robot, fractions):
    """A robot that stands still, its feet bearing these fractions of its weight, shape (4,)."""
    joints = robot.initial_joint_angles
    forces = robot.mass * GRAVITY * np.asarray(fractions)[:, None] * UP
    jacobians = robot.foot_jacobians(joints)
    borne = np.einsum('lij,li->lj', jacobians, forces)
    still = np.zeros((4, 3))
    level = np.array([0.0, 0.0, 0.0, 1.0])
    efforts = weight_torques(robot, joints, UP) - borne
    stands = np.ones(4, dtype=bool)
    return BodyReading(0.0, joints, still, efforts, level, np.zeros(3), GRAVITY * UP, stands)


@pytest.mark.parametrize('name', ['titan_viii', 'genibo', 'cuhk'])
@pytest.mark.parametrize('leg', range(4))
def test_a_foot_has_met_the_ground_once_it_bears_a_part_of_the_weight(name, leg):
    robot = load_robot(name)
    for part, has_met in (
        (OPTIONS.touching_load + 0.01, True),
        (OPTIONS.touching_load - 0.01, False),
    ):
        fractions = np.full(4, 0.05)
        fractions[leg] = part
        estimate = BodyEstimator(robot, OPTIONS).update(reading_of(robot, fractions))
        assert estimate.contacts is not None
        assert estimate.contacts[leg] is has_met
        assert not any(estimate.contacts[other] for other in range(4) if other != leg)


def test_feet_count_for_the_velocity_with_less_load_than_tells_of_the_ground():
    robot = load_robot('cuhk')
    fractions = np.array([0.5, 0.1, 0.02, 0.38])
    estimator = BodyEstimator(robot, OPTIONS)
    estimate = estimator.update(reading_of(robot, fractions))
    assert estimate.contacts == (True, False, False, True)
    assert estimator.bears.tolist() == [True, True, False, True]
    assert estimator.loads == pytest.approx(robot.mass * GRAVITY * fractions, rel=1e-6)


def test_without_torques_no_foot_tells_of_the_ground():
    robot = load_robot('cuhk')
    reading = reading_of(robot, np.full(4, 0.25))
    estimate = BodyEstimator(robot, OPTIONS).update(
        BodyReading(**{**vars(reading), 'efforts': None})
    )
    assert estimate.contacts is None


def test_its_velocity_counts_while_it_is_recent_and_as_a_trot_may_be():
    robot = load_robot('cuhk')
    estimator = BodyEstimator(robot, OPTIONS)
    assert estimator.velocity_at(0.0) is None
    reading = reading_of(robot, np.full(4, 0.25))
    for time in (0.0, 0.02, 0.04):
        estimate = estimator.update(replace(reading, time=time))
    assert estimator.velocity_at(0.06) == estimate.velocity
    assert estimator.velocity_at(0.0) is None
    assert estimator.velocity_at(0.05 + OPTIONS.longest_gap) is None
    # An accelerometer that errs while no foot is down to say so.
    in_the_air = np.zeros(4, dtype=bool)
    for time in np.arange(0.06, 0.6, 0.02):
        wrong = replace(reading, time=time, specific_force=100.0 * UP[::-1], in_stance=in_the_air)
        estimate = estimator.update(wrong)
    assert np.hypot(*estimate.velocity) > 10.0
    assert estimator.velocity_at(0.6) is None
