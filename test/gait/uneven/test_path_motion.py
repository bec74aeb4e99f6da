"""A motion along paths is one that the last gate before the joints lets through, or is refused."""

from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import GaitError, JointLimitExceeded
from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.trajectory_gate import JointLimits, velocities_between
from quad_gait.state.body_placement import BodyPose
from quad_gait.state.stance import Stance
from quad_gait.uneven.path_motion import PlannedPaths, motion_along, motion_back
from quad_gait.uneven.uneven_options import UnevenOptions

ROBOT = load_robot('titan_viii')
JOINTS = ROBOT.initial_joint_angles
STANCE = Stance(
    0.0, BodyPose(np.zeros(3), 0.0, 0.0, 0.0), ROBOT.foot_positions(JOINTS), JOINTS, lambda: None
)


def swing(duration, height, period=0.02):
    """Paths of a foot that rises and comes down again where it was, beneath a body at rest."""
    times = np.linspace(0.0, duration, round(duration / period) + 1)
    feet = np.repeat(STANCE.feet[None], len(times), axis=0)
    feet[:, 0, 2] += height * np.sin(np.pi * times / duration) ** 2
    return PlannedPaths(times, STANCE.body, np.zeros(len(times)), feet)


def test_what_is_not_refused_passes_the_gate_between_its_points_too():
    limits, passed, refused = JointLimits.of(ROBOT), 0, 0
    for duration in np.linspace(0.06, 0.6, 60):
        for height in (0.03, 0.06, 0.1):
            try:
                motion = motion_along(
                    ROBOT, UnevenOptions(), STANCE, None, swing(float(duration), height)
                )
            except GaitError:
                refused += 1
                continue
            count = len(motion.times)
            limits.check(
                motion.times,
                motion.positions.reshape(count, -1),
                motion.velocities.reshape(count, -1),
            )
            passed += 1
    assert passed > 20
    assert refused > 20


@pytest.mark.parametrize('done', [1, 2, 10, 30])
def test_joints_go_back_the_way_they_came_and_pass_the_gate(done):
    options, there = (
        UnevenOptions(),
        motion_along(ROBOT, UnevenOptions(), STANCE, None, swing(0.6, 0.1)),
    )
    way = list(there.positions[: done + 1])
    back = motion_back(ROBOT, options, STANCE, way)
    count = len(back.times)
    positions, velocities = (part.reshape(count, -1) for part in (back.positions, back.velocities))
    JointLimits.of(ROBOT).check(back.times, positions, velocities)
    assert back.positions[0] == pytest.approx(way[-1])
    assert back.positions[-1] == pytest.approx(way[0])
    assert not velocities[[0, -1]].any()
    # Nowhere is it off the way by more than what the joints do within a sample.
    off = np.abs(back.positions[:, None] - np.array(way)).max(axis=(2, 3)).min(axis=1)
    assert off.max() <= np.abs(np.diff(way, axis=0)).max()
    assert back.given == count - 1


def search(speed, period=0.02):
    """Paths of a foot that goes down for the ground until its leg reaches no deeper."""
    times = np.linspace(0.0, 2.0, round(2.0 / period) + 1)
    feet = np.repeat(STANCE.feet[None], len(times), axis=0)
    # It gathers speed within 0.2 s.
    feet[:, 0, 2] -= speed * np.where(times < 0.2, 2.5 * times**2, times - 0.1)
    return PlannedPaths(times, STANCE.body, np.zeros(len(times)), feet, sure=2)


def test_a_search_that_ends_where_the_leg_does_is_given_out_with_the_time_to_come_to_rest():
    limits, fast_ends = JointLimits.of(ROBOT), 0
    for speed in np.linspace(0.08, 0.4, 33):
        try:
            motion = motion_along(ROBOT, UnevenOptions(), STANCE, None, search(float(speed)))
        except JointLimitExceeded:
            # Near the end of its reach a leg must be too fast from some speed on.
            continue
        count = len(motion.times)
        assert count < 101
        positions, velocities = (
            values.reshape(count, -1) for values in (motion.positions, motion.velocities)
        )
        between = np.abs(velocities_between(motion.times, positions, velocities)).max(axis=1)
        fast_ends += between[-1] > 1.05 * float(ROBOT.velocity.max()) >= between[:-1].max()
        given = replace(motion, given=count - 1).trajectory(0.06)
        limits.check(given.times, given.positions, given.velocities)
    assert fast_ends > 0


def test_a_search_of_a_leg_that_reaches_one_sample_farther_is_a_motion_all_the_same():
    paths = search(0.1)
    feet = paths.feet.copy()
    # From the second sample on the foot is where no leg gets.
    feet[2:, 0, 2] -= 2.0
    motion = motion_along(ROBOT, UnevenOptions(), STANCE, None, replace(paths, feet=feet))
    assert len(motion.times) == 2
    JointLimits.of(ROBOT).check(
        motion.times, motion.positions.reshape(2, -1), motion.velocities.reshape(2, -1)
    )


@pytest.mark.parametrize('depth', [0.02, 0.4])
def test_beyond_what_is_sure_a_foot_goes_as_deep_as_its_leg_reaches(depth):
    times, sure = np.linspace(0.0, 4.0, 201), 20
    feet = np.repeat(STANCE.feet[None], len(times), axis=0)
    feet[:, 2, 2] -= depth * times / times[-1]
    paths = PlannedPaths(times, STANCE.body, np.zeros(len(times)), feet, sure)
    motion = motion_along(ROBOT, UnevenOptions(), STANCE, None, paths)
    count = len(motion.times)
    assert sure < count
    # Sample by sample, it is the same.
    alone = np.concatenate([ROBOT.joint_angles(place[None]) for place in feet[:count]])
    assert np.allclose(motion.positions, alone, rtol=0.0, atol=1e-12)
    assert (count == len(times)) == (depth < 0.1)
    if count < len(times):
        with pytest.raises(GaitError):
            ROBOT.joint_angles(feet[count])


def stretched(beyond):
    """A stance whose left front knee load has pulled out of its range by an angle."""
    joints = JOINTS.copy()
    joints[0, 2] = ROBOT.lower[0, 2] - beyond
    return replace(STANCE, feet=ROBOT.foot_positions(joints), joint_positions=joints)


def still(stance, lower=0.0):
    """Paths of feet that stand, the left front one of which goes down by a distance [m]."""
    times = np.linspace(0.0, 1.0, 51)
    feet = np.repeat(stance.feet[None], len(times), axis=0)
    feet[:, 0, 2] -= lower * np.sin(0.5 * np.pi * times) ** 2
    return PlannedPaths(times, stance.body, np.zeros(len(times)), feet)


@pytest.mark.parametrize('is_commanded', [True, False])
def test_a_leg_that_load_stretches_beyond_a_joints_range_moves_on_within_the_range(is_commanded):
    stance = stretched(0.01)
    in_range = np.clip(stance.joint_positions, ROBOT.lower, ROBOT.upper)
    commanded = in_range if is_commanded else None
    motion = motion_along(ROBOT, UnevenOptions(), stance, commanded, still(stance))
    ROBOT.check_joint_limits(motion.positions)
    np.testing.assert_allclose(motion.positions[:, 0, 2], ROBOT.lower[0, 2], atol=1e-9)
    np.testing.assert_allclose(motion.positions[:, 1:], JOINTS[None, 1:].repeat(51, 0), atol=1e-9)


def test_what_stretches_a_leg_farther_than_load_has_is_refused():
    stance = stretched(0.01)
    with pytest.raises(GaitError):
        motion_along(ROBOT, UnevenOptions(), stance, None, still(stance, lower=0.02))
    far = stretched(0.1)
    with pytest.raises(JointLimitExceeded):
        motion_along(ROBOT, UnevenOptions(), far, None, still(far))


def stretching(knee, duration):
    """Stance and paths in which the left front knee alone turns from an angle to others [rad]."""
    joints = np.repeat(JOINTS[None], len(knee), axis=0)
    joints[:, 0, 2] = knee
    feet = ROBOT.foot_positions(joints)
    stance = replace(STANCE, feet=feet[0], joint_positions=joints[0])
    times = np.linspace(0.0, duration, len(knee))
    return stance, PlannedPaths(times, stance.body, np.zeros(len(times)), feet)


def test_a_leg_whose_drive_lags_is_stretched_to_the_end_of_its_range_and_no_farther():
    end = ROBOT.lower[0, 2]
    stance, paths = stretching(end + np.interp(np.arange(26), [0, 10], [0.05, 0.005]), 0.5)
    commanded = stance.joint_positions.copy()
    commanded[0, 2] = end
    motion = motion_along(ROBOT, UnevenOptions(), stance, commanded, paths)
    ROBOT.check_joint_limits(motion.positions)
    assert motion.positions[0, 0, 2] == end
    assert motion.positions[-1, 0, 2] == pytest.approx(end + 0.005)


def test_a_search_ends_where_a_fast_joint_would_overshoot_its_range_if_something_replaced_it():
    end, options = ROBOT.lower[0, 2], UnevenOptions()
    # The last sample is fast, and near the end of the range.
    knee = end + np.array([0.5, 0.49, 0.48, 0.45, 0.4, 0.3, 0.2, 0.1, 0.005])
    stance, paths = stretching(knee, 0.16)
    motion = motion_along(ROBOT, options, stance, None, replace(paths, sure=3))
    assert 3 <= len(motion.times) < len(knee)
    for last in range(3, len(motion.times)):
        place, speed = motion.positions[last, 0, 2], (knee[last] - knee[last - 1]) / 0.02
        # A cubic that begins with that speed and ends at rest, where it began.
        s = np.linspace(0.0, 1.0, 101)
        course = place + options.reaction_time * speed * s * (1.0 - s) ** 2
        assert course.min() > end - 1e-9
    # What is sure is not left out.
    whole = motion_along(ROBOT, options, stance, None, replace(paths, sure=len(knee)))
    assert len(whole.times) == len(knee)
