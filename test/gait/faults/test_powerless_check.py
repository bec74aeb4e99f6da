"""A joint without torque is named although an outdated trajectory would explain where it is."""

import numpy as np
import pytest

from quad_gait.faults.checks.powerless_check import PowerlessCheck, PowerlessOptions

OPTIONS = PowerlessOptions()
STEP = 0.02
ALLOWED = np.full(12, 0.07)
SLACK = np.where(np.arange(12) == 7, 0.045, 0.0)
LATEST = np.linspace(-0.5, 0.5, 12)


def named_after(check, measured, explained, strictness=SLACK, seconds=2.0):
    """Return after which time a joint is named [s], and which; None if none is."""
    for k in range(1, round(seconds / STEP) + 1):
        joint = check.update(
            (LATEST, ALLOWED), (explained, ALLOWED), measured(k * STEP), strictness, STEP
        )
        if joint >= 0:
            return k * STEP, joint
    return None


def off(distance, joint=7, noise=0.005):
    """Return joints on the latest trajectory, but one."""
    rng = np.random.default_rng(1)

    def measured(time):
        positions = LATEST + rng.uniform(-noise, noise, 12)
        positions[joint] += distance
        return positions

    return measured


def outdated(distance):
    """Return what all joints are a little off, and the one that failed as well."""
    there = LATEST + distance * (-1.0) ** np.arange(12)
    there[7] = LATEST[7] + 0.06
    return there


def test_a_joint_that_only_an_outdated_trajectory_explains_is_named():
    time, joint = named_after(PowerlessCheck(), off(0.06), outdated(0.03))
    assert joint == 7
    assert OPTIONS.patience - 1e-9 <= time < 0.3


def test_the_worse_an_outdated_trajectory_fits_the_sooner_it_is_named():
    found = [named_after(PowerlessCheck(), off(0.06), outdated(d)) for d in (0.01, 0.012, 0.04)]
    times = [time for time, _ in found]
    assert times[0] > times[1] > times[2]


def test_an_earlier_trajectory_on_which_the_joints_are_convicts_nobody():
    # The latest one has not come yet, and differs from this one in one joint only.
    earlier = LATEST.copy()
    earlier[7] += 0.06
    assert named_after(PowerlessCheck(), off(0.06), earlier, seconds=20.0) is None


@pytest.mark.parametrize(
    ('measured', 'strictness'),
    [
        # Its motor gives a torque: it may be bent by its load.
        (off(0.06), np.zeros(12)),
        # It is where a drive would not pull.
        (off(0.02), SLACK),
        # The others are not on the latest trajectory for sure.
        (off(0.06, noise=0.06), SLACK),
    ],
)
def test_what_is_not_certain_convicts_nobody(measured, strictness):
    assert named_after(PowerlessCheck(), measured, outdated(0.03), strictness) is None


def test_evidence_against_one_joint_does_not_count_against_another():
    check = PowerlessCheck()
    slack = np.full(12, 0.045)
    for k in range(50):
        measured = off(0.06, joint=k % 2)(0.0)
        explained = (LATEST + 0.03, ALLOWED)
        assert check.update((LATEST, ALLOWED), explained, measured, slack, STEP) < 0
