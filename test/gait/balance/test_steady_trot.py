"""What a steady trot that keeps its balance needs of joints, and what bounds it."""

import math

import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.steady_trot import SteadyTrot
from quad_gait.behaviours.gait_choice import balanced_gait
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.motion_limits import MotionLimits

OPTIONS = BalanceOptions()


def trot_of(name):
    """Return a robot, its trot as it is walked in balance, and what that can do beside it."""
    robot = load_robot(name)
    gait = balanced_gait(load_gait('trot', robot), OPTIONS)
    return SteadyTrot(robot, gait, OPTIONS), MotionLimits(robot, gait)


def test_joints_are_the_faster_the_farther_a_cycle_goes():
    trot, _ = trot_of('titan_viii')
    uses = [trot.speed_use(BodyMotion(forward=stride)) for stride in (0.0, 0.1, 0.2, 0.3)]
    assert 0.3 < uses[0] < OPTIONS.lift_speed
    assert uses == sorted(uses)
    assert math.isinf(trot.speed_use(BodyMotion(forward=3.0)))


@pytest.mark.parametrize(
    'motion', [BodyMotion(1.0), BodyMotion(0.0, 1.0), BodyMotion(0.0, 0.0, 1.0)]
)
def test_as_much_of_a_motion_is_possible_as_leaves_the_joints_something(motion):
    trot, limits = trot_of('titan_viii')
    most = motion.scaled(limits.largest_scale(motion))
    assert trot.speed_use(most) > OPTIONS.steady_speed
    fraction, reason = trot.possible(most)
    assert 0.95 * OPTIONS.steady_speed < trot.speed_use(most.scaled(fraction))
    assert trot.speed_use(most.scaled(fraction)) <= OPTIONS.steady_speed
    assert 'at most 54 % of the largest joint speeds' in reason


def test_quick_joints_bound_nothing():
    trot, limits = trot_of('mini_cheetah')
    motion = BodyMotion(forward=limits.largest_scale(BodyMotion(forward=1.0)))
    assert trot.possible(motion) == (1.0, '')
