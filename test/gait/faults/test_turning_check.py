"""A joint that rests while its command turns is noticed near its command; a sound one is not."""

import numpy as np
import pytest

from quad_gait.faults.checks.turning_check import TurningCheck

STEP = 0.02
LARGEST = np.full(12, 2.0)
NO_LOAD = np.full(12, 0.02)


def commands(time, size=0.05, period=0.36):
    """Return small swings to and fro, each joint with a phase of its own."""
    return size * np.sin(2.0 * np.pi * time / period + np.linspace(0.0, 3.0, 12))


def noticed(spoil, seconds=2.0, size=0.05, efforts=NO_LOAD):
    """Return the first joint that is named, and when; -1 for none."""
    check = TurningCheck(LARGEST)
    for time in np.arange(0.0, seconds, STEP):
        asked = commands(time, size)
        joint = check.update(asked, spoil(time, asked.copy()), efforts, STEP)
        if joint >= 0:
            return joint, time
    return -1, seconds


@pytest.mark.parametrize('joint', range(12))
def test_a_joint_that_jams_in_a_small_swing_is_named_within_two_strides(joint):
    stuck_at = commands(0.5)[joint]

    def spoil(time, joints):
        if time >= 0.5:
            joints[joint] = stuck_at
        return joints

    named, time = noticed(spoil)
    assert named == joint
    assert time - 0.5 < 2.0 * 0.36


@pytest.mark.parametrize('offset', [-0.06, 0.0, 0.06])
@pytest.mark.parametrize('delay', [0.0, 0.04])
def test_joints_that_follow_late_or_off_their_commands_turn(offset, delay):
    def spoil(time, joints):
        joints = commands(time - delay)
        joints[3] += offset
        return joints

    assert noticed(spoil)[0] == -1


def test_joints_that_all_rest_wait_for_their_trajectory():
    held = commands(0.5)
    assert noticed(lambda time, joints: joints if time < 0.5 else held)[0] == -1


def test_a_joint_that_its_load_bends_back_is_sound():
    efforts = NO_LOAD.copy()

    def spoil(time, joints):
        if time >= 0.5:
            # All that its command turns on is taken back by a load that comes on with it.
            efforts[2] = 0.02 + (joints[2] - commands(0.5)[2]) / 0.35 * 2.0
            joints[2] = commands(0.5)[2]
        return joints

    assert noticed(spoil, efforts=efforts)[0] == -1


def test_a_joint_that_is_not_asked_to_turn_is_not_missed():
    def spoil(time, joints):
        joints[5] = commands(0.5, 0.01)[5]
        return joints

    assert noticed(spoil, size=0.01)[0] == -1


def test_a_joint_that_came_to_rest_from_high_speed_and_is_bent_by_its_load_is_sound():
    check = TurningCheck(LARGEST)
    told = []
    for k, time in enumerate(np.arange(0.0, 0.5, STEP)):
        asked = commands(time)
        joints = asked.copy()
        # As a knee that lands: ahead of its command in time, at 2 rad/s, then behind by its load.
        asked[5] = max(0.2 - 0.04 * k, 0.0)
        joints[5] = asked[5] - 0.014 if k < 4 else 0.022
        told.append(check.update(asked, joints, NO_LOAD, STEP))
    assert told == [-1] * len(told)
