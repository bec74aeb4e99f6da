"""The simulator refuses a malformed joint trajectory with a reason, and holds still."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Duration, Time
from harness import ERROR, Bench
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from quad_common.robot import load_robot

pytestmark = pytest.mark.ros

ROBOT = load_robot('titan_viii')
NAMES = list(ROBOT.joint_names)
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
MOVED = POSTURE + 0.1


def trajectory(names=NAMES, positions=MOVED, velocities=(), times=(1,), stamp=0) -> JointTrajectory:
    """To one posture, from the time of arrival unless a stamp [s] is given."""
    message = JointTrajectory(joint_names=list(names))
    message.header.stamp = Time(sec=stamp)
    message.points = [
        JointTrajectoryPoint(
            positions=list(positions), velocities=list(velocities), time_from_start=Duration(sec=t)
        )
        for t in times
    ]
    return message


REFUSED = {
    'times before the start': (trajectory(times=(-1, 1)), 'must rise, from zero or later'),
    'unknown joint': (trajectory(['tail_joint', *NAMES[1:]]), "there is no joint 'tail_joint'"),
    'missing joint': (trajectory(NAMES[1:], MOVED[1:]), f'leaves out {NAMES[0]}'),
    'joint named twice': (trajectory([NAMES[1], *NAMES[1:]]), 'names a joint twice'),
    'no joints': (trajectory([], []), 'names no joints'),
    'no points': (trajectory(times=()), 'has 0 points'),
    'too few positions': (trajectory(positions=MOVED[1:]), 'has 11 positions'),
    'too many velocities': (trajectory(velocities=[0.0] * 13), '13 velocities for 12 joints'),
    'not a number': (trajectory(positions=[math.nan, *MOVED[1:]]), 'positions that are not finite'),
    'infinite velocity': (trajectory(velocities=[math.inf] * 12), 'velocities that are not finite'),
    'times that fall': (trajectory(times=(2, 1)), 'must rise'),
    'too late': (trajectory(stamp=1), 'the trajectory ended at 2.000 s'),
}


def test_a_bad_trajectory_is_refused_and_a_good_one_after_it_is_executed(bench: Bench):
    bench.start('sim_node')
    bench.wait_until('more than two seconds have passed', lambda: bench.time > 3.0)

    def postures() -> np.ndarray:
        names = bench.joint_states.name
        return np.array([bench.joint_states.position[names.index(name)] for name in NAMES])

    publisher = bench.publisher(JointTrajectory, 'joint_trajectory')
    for message, words in REFUSED.values():
        with bench.expects('sim_node', words, level=ERROR):
            publisher.publish(message)
        np.testing.assert_allclose(postures(), POSTURE, atol=1e-9)
    since = bench.elapsed
    bench.wait_until('two seconds go by', lambda: bench.elapsed > since + 2.0)
    np.testing.assert_allclose(postures(), POSTURE, atol=1e-9)

    publisher.publish(trajectory())
    bench.wait_until(
        'the good trajectory is executed', lambda: np.abs(postures() - MOVED).max() < 1e-6
    )
    bench.wait_for_status('sim_node', 'running')
