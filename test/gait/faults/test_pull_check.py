"""A motor that gives no torque although its joint is off its command is noticed; others are not."""

import numpy as np
import pytest

from quad_gait.faults.checks.pull_check import PullCheck, PullOptions

STEP = 0.02
LARGEST = np.full(12, 2.0)
OPTIONS = PullOptions()


def noticed(off, efforts=None, seconds=4.0, turning=0.1):
    """Return the first joint that is named, and when; -1 for none."""
    check = PullCheck(LARGEST)
    for time in np.arange(0.0, seconds, STEP):
        # All joints turn slowly to and fro, each with a phase of its own.
        phases = 1.5 * time + np.linspace(0.0, 3.0, 12)
        commanded = turning * np.sin(phases)
        speeds = turning * 1.5 * np.abs(np.cos(phases))
        error = np.zeros(12)
        error[list(off)] = [off[joint] for joint in off]
        torques = np.zeros(12) if efforts is None else efforts(time)
        joint = check.update(commanded, speeds, commanded + error, torques, STEP)
        if joint >= 0:
            return joint, time
    return -1, seconds


@pytest.mark.parametrize('joint', range(12))
@pytest.mark.parametrize('error', [0.015, -0.02, 0.028])
def test_a_joint_without_torque_is_named_within_a_stride_though_it_is_hardly_off(joint, error):
    named, time = noticed({joint: error})
    assert named == joint
    assert OPTIONS.patience - STEP <= time + STEP < 2.0


def test_a_joint_that_its_motor_pulls_is_sound():
    # As a position drive with the compliance that is taken for granted elsewhere.
    def efforts(time):
        torques = np.zeros(12)
        torques[4] = LARGEST[4] * 0.015 / 0.35
        return torques

    assert noticed({4: -0.015}, efforts)[0] == -1


def test_a_motor_that_pulls_now_and_then_is_sound():
    def efforts(time):
        torques = np.zeros(12)
        torques[4] = 0.02 if time % 0.3 < STEP else 0.0
        return torques

    assert noticed({4: -0.015}, efforts)[0] == -1


@pytest.mark.parametrize('error', [0.0, 0.007])
def test_joints_on_their_commands_need_no_torque(error):
    assert noticed(dict.fromkeys(range(12), error))[0] == -1
    assert noticed({3: error})[0] == -1


def test_several_joints_that_are_off_wait_for_their_trajectory():
    assert noticed({3: 0.015, 7: 0.015})[0] == -1


def test_a_robot_whose_other_joints_rest_is_not_judged():
    assert noticed({3: 0.015}, turning=0.0)[0] == -1


def named_after(breaks, seconds=20.0):
    """Return when a joint is named that is off for 0.06 s, with breaks between; None if never."""
    check, phases = PullCheck(LARGEST), np.linspace(0.0, 3.0, 12)
    for time in np.arange(0.0, seconds, STEP):
        commanded = 0.1 * np.sin(1.5 * time + phases)
        measured = commanded.copy()
        measured[5] += 0.015 if time % (0.06 + breaks) < 0.06 - 1e-9 else 0.0
        speeds = 0.15 * np.abs(np.cos(1.5 * time + phases))
        if check.update(commanded, speeds, measured, np.zeros(12), STEP) == 5:
            return time
    return None


def test_short_breaks_do_not_clear_a_joint_and_long_ones_do():
    assert named_after(0.2) is not None
    assert named_after(0.6) is None
