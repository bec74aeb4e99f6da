"""What begins on arrival passes the last gate, later if the joints need time to its beginning."""

from __future__ import annotations

import numpy as np
import pytest

from quad_common.errors import CommandJumps, CommandOutsideLimits
from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.faults.command_gate import CommandGate

ROBOT = load_robot('titan_viii')
REST = ROBOT.initial_joint_angles.reshape(-1)
FAST = float(ROBOT.velocity.max())


def moving_knee(offset, velocity=0.0, stamp=0.0, lead=0.06):
    """The first knee goes on from an offset to the initial posture, with a velocity first."""
    positions, velocities = np.tile(REST, (2, 1)), np.zeros((2, 12))
    positions[0, 2] += offset
    velocities[0, 2] = velocity
    times = np.array([lead, lead + 0.5])
    return JointTrajectory(ROBOT.joint_names, stamp, times, positions, velocities)


def test_what_can_be_reached_in_its_time_is_given_out_as_it_is():
    trajectory = moving_knee(0.05)
    assert CommandGate(ROBOT).admit(trajectory, 3.0, REST) is trajectory


@pytest.mark.parametrize('velocity', [0.0, 1.0, -1.0])
def test_what_begins_on_arrival_begins_later_where_the_joints_need_longer(velocity):
    gate = CommandGate(ROBOT)
    given = gate.admit(moving_knee(-0.3, velocity), 3.0, REST)
    assert 0.06 < given.times[0] < 0.3
    assert np.diff(given.times) == pytest.approx([0.5])
    way = np.array([gate.command(t, REST)[0][2] for t in np.arange(3.0, 3.3, 0.001)])
    assert np.abs(np.diff(way)).max() <= 1.05 * FAST * 0.001 + 1e-9


def test_what_has_a_time_of_its_own_is_refused_where_it_cannot_be_kept():
    with pytest.raises(CommandOutsideLimits):
        CommandGate(ROBOT).admit(moving_knee(-0.3, stamp=3.0), 3.0, REST)


def test_what_leaves_the_limits_is_refused_however_much_later_it_would_begin():
    gate = CommandGate(ROBOT)
    with pytest.raises(CommandOutsideLimits):
        gate.admit(moving_knee(-9.0), 3.0, REST)
    # It has changed nothing.
    assert gate.command(3.1, REST)[0] == pytest.approx(REST)


def test_joints_that_follow_an_earlier_trajectory_may_go_on_from_there():
    gate = CommandGate(ROBOT)
    first = gate.admit(moving_knee(0.0, stamp=3.0), 3.0, REST)
    gate.admit(moving_knee(-0.3, stamp=3.5, lead=0.5), 3.5, REST)
    # At rest by the first, as the second has not arrived.
    on = moving_knee(0.0, stamp=4.0, lead=0.0)
    with pytest.raises(CommandJumps):
        gate.admit(on, 4.0, REST)
    gate.go_back_to(first)
    assert gate.admit(on, 4.0, REST) is on
    with pytest.raises(CommandJumps):
        gate.admit(moving_knee(-0.3, stamp=4.02, lead=0.0), 4.02, REST)
