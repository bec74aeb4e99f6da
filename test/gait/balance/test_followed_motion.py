"""A motion that joints follow in place of the last one is found, and gone on from."""

import math

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.trajectory_executor import TrajectoryExecutor
from quad_common.trajectory.trajectory_gate import JointLimits
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.balanced_motion import BalancedMotion
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.followed_motion import FollowedMotion
from quad_gait.balance.foot_laws import Pace
from quad_gait.balance.joint_motion import JointMotion
from quad_gait.cycle.gait import load_gait

ROBOT = load_robot('cuhk')
GAIT = load_gait('trot', ROBOT).with_period(0.25)
POSTURE = ROBOT.initial_joint_angles
AHEAD = Pace(0.3, 0.0, 0.0)
WALKING = BodyEstimate((0.3, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0)


def ramp(start, size, duration=1.0):
    """A motion of all joints by an angle."""
    times = start + np.linspace(0.0, duration, 11)
    shape = (1, 4, 3)
    positions = np.linspace(0.0, size, 11)[:, None, None] * np.ones(shape)
    return JointMotion(times, positions, np.full((11, 4, 3), size / duration))


def test_joints_that_follow_the_last_motion_or_none_follow_no_earlier_one():
    known = FollowedMotion(BalanceOptions())
    assert known.earlier(1.0, np.zeros((4, 3))) is None
    for k in range(1, 10):
        known.note(ramp(0.0, 0.1 * k))
    assert known.earlier(0.5, np.full((4, 3), 0.46)) is None
    assert known.earlier(0.5, np.full((4, 3), -0.5)) is None


def test_joints_that_follow_an_earlier_motion_are_found_out_after_its_end_too():
    known = FollowedMotion(BalanceOptions())
    first = ramp(0.0, 0.1, 0.5)
    for motion in (first, *(ramp(0.02 * k, 0.8) for k in range(1, 9))):
        known.note(motion)
    assert known.earlier(0.5, np.full((4, 3), 0.102)) is first
    assert known.earlier(0.9, np.full((4, 3), 0.1)) is first


def test_a_motion_that_may_still_arrive_is_not_an_earlier_one():
    known = FollowedMotion(BalanceOptions())
    for size in (0.1, 0.3, 0.5):
        known.note(ramp(0.0, size))
    assert known.earlier(0.5, np.full((4, 3), 0.05)) is None


def test_motions_that_have_not_begun_yet_say_nothing():
    # With a long reaction time joints follow what was given out that long ago.
    known = FollowedMotion(BalanceOptions())
    for k in range(20):
        known.note(ramp(0.1 + 0.02 * k, 0.3 + 0.05 * k))
    joints = ramp(0.1 + 0.02 * 15, 0.3 + 0.05 * 15).at(0.4)[0]
    assert known.earlier(0.4, joints) is None


def jump_after(begins, silence, follows, reaction=0.02):
    """Return how far joints are to go at once after a silence, rms of all [rad]."""
    executor = TrajectoryExecutor(ROBOT.joint_names, POSTURE.reshape(-1), JointLimits.of(ROBOT))
    options = BalanceOptions(reaction_time=reaction)
    motion = BalancedMotion(ROBOT, GAIT, options, 0.0, POSTURE)
    jumps = []
    for time in 0.02 * np.arange(100):
        if follows:
            motion.follow(time, executor.command(time)[0].reshape(4, 3))
        trajectory = motion.update(time, WALKING, AHEAD)
        if trajectory is None or begins <= time < begins + silence:
            continue
        soon = time + reaction
        before, after = executor.command(soon)[0], trajectory.positions_at(np.array([soon]))[0]
        # One that leaps too far is refused.
        executor.accept(trajectory, time)
        jumps.append(np.sqrt(np.mean(np.square(after - before))))
    return max(jumps)


@pytest.mark.parametrize('silence', [0.24, 0.3, 0.5])
def test_after_a_silence_joints_go_on_from_where_they_are(silence):
    instants = 0.8 + 0.02 * np.arange(13)
    jumps = [jump_after(begins, silence, follows=True) for begins in instants]
    others = [jump_after(begins, silence, follows=False) for begins in instants]
    assert np.mean(jumps) < 0.5 * np.mean(others)
    assert max(jumps) < max(others)


@pytest.mark.parametrize('reaction', [0.0, 0.02, 0.05, 0.1])
def test_where_all_arrives_nothing_is_gone_on_from_but_the_last(monkeypatch, reaction):
    found = []
    earlier = FollowedMotion.earlier

    def noted(known, time, joints):
        found.append(earlier(known, time, joints))
        return found[-1]

    monkeypatch.setattr(FollowedMotion, 'earlier', noted)
    jump_after(math.inf, 0.0, follows=True, reaction=reaction)
    assert found == [None] * len(found)
