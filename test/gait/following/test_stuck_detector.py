"""A robot is stuck if its cycles have little effect, and not if they have too much."""

import pytest

from quad_common.planar_pose import Pose2D
from quad_gait.following.stuck_detector import Begun, StuckDetector

HERE = Pose2D(1.0, 2.0, 0.5)


def problem_after(planned, done, cycles=3, period=1.0):
    """Return what is said after equal cycles [s] of a robot with a largest stride of 0.2 m."""
    detector = StuckDetector(0.2)
    said = None
    for k in range(cycles):
        begun = Begun(k * period, HERE, HERE, HERE @ planned)
        said = detector.problem(begun, (k + 1) * period, HERE @ done)
    return said


STEP = Pose2D(0.05, 0.0, 0.0)


@pytest.mark.parametrize(
    'done',
    [STEP, Pose2D(0.02, 0.0, 0.0), Pose2D(0.11, 0.01, 0.0), Pose2D(0.04, 0.05, 0.0)],
)
def test_a_robot_that_gets_on_is_not_stuck_however_far_it_gets(done):
    assert problem_after(STEP, done, cycles=6) is None


@pytest.mark.parametrize(
    'done', [Pose2D(0.0, 0.0, 0.0), Pose2D(-0.05, 0.0, 0.0), Pose2D(0.01, 0.05, 0.0)]
)
def test_a_robot_that_does_not_get_on_is_stuck_after_three_cycles(done):
    assert problem_after(STEP, done, cycles=2) is None
    assert 'does not follow its commands: 3 cycles without effect' in problem_after(STEP, done)


def test_short_cycles_without_effect_are_counted_for_longer():
    still = Pose2D(0.0, 0.0, 0.0)
    assert problem_after(STEP, still, cycles=5, period=0.25) is None
    assert '6 cycles without effect' in problem_after(STEP, still, cycles=6, period=0.25)


def test_a_turn_counts_as_a_stride_does():
    turn = Pose2D(0.0, 0.0, 0.4)
    assert problem_after(turn, Pose2D(0.0, 0.0, 0.9), cycles=6) is None
    assert problem_after(turn, Pose2D(0.0, 0.0, -0.1)) is not None
