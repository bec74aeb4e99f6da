"""What goes wrong is taken by one guard at a time, the most urgent first."""

import numpy as np
import pytest
from told_supervisor import ToldSupervisor, measurement

from quad_common.errors import EmergencyStopOn, RobotIsLame, RobotStaysStill
from quad_common.plan import Plan
from quad_common.planar_pose import Twist2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.faults.joint_fault import JointFault

ROBOT = load_robot('titan_viii')
AHEAD = Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0)
FAULT = JointFault(7, ROBOT.joint_names[7], 'free', 0.0, 0.1, None, 0.0, is_slack=True)
SILENCE = 'no joint states for 1.0 s'


class Robot:
    """A robot that stands and follows nothing; what else is wrong with it can be set."""

    def __init__(self):
        gait = load_gait('crawl', ROBOT)
        options = SupervisorOptions(watches_joints=False)
        self.supervisor = ToldSupervisor(ROBOT, gait, turning_gait_for(gait, ROBOT), options)
        self.time = 0.0

    def step(self, **changes):
        """Take a measurement; return the trajectory."""
        self.time += 0.02
        return self.supervisor.update(measurement(ROBOT, self.time, **changes))

    def run(self, seconds, **changes):
        """Take measurements; return the trajectories."""
        given = [self.step(**changes) for _ in range(round(seconds / 0.02))]
        return [trajectory for trajectory in given if trajectory is not None]

    def fail(self):
        """Let a joint fail."""
        self.supervisor._joints.watch = lambda state: None
        self.supervisor._joints.fault = FAULT

    @property
    def activity(self):
        return self.supervisor.activity


@pytest.fixture
def robot():
    robot = Robot()
    robot.run(0.5)
    return robot


def test_a_body_that_rolls_on_after_a_fall_is_told_of_a_few_times(robot):
    said = []
    for degrees in np.linspace(31.0, 170.0, 200):
        robot.step(tilt=np.radians(degrees))
        said.append(robot.supervisor.reason)
    kinds = list(dict.fromkeys(said))
    assert 3 <= len(kinds) <= 5
    assert kinds[0] == 'the robot has fallen: the body is tilted by 31 degrees'
    assert 'tilted by 1' in kinds[-1]


def test_a_frozen_robot_that_tilts_or_whose_joint_fails_is_left_as_it_is(robot):
    robot.supervisor.freeze()
    robot.fail()
    assert robot.run(1.0, tilt=1.2) == []
    assert robot.activity is Activity.EMERGENCY_STOP


def test_after_the_release_a_joint_that_fails_moves_nothing_but_a_fall_is_noticed(robot):
    robot.supervisor.freeze()
    robot.supervisor.release()
    robot.fail()
    assert robot.run(1.0) == []
    assert robot.activity is Activity.STOPPED
    assert len(robot.run(1.0, tilt=1.2)) == 1
    assert robot.activity is Activity.FALLEN


def test_stand_ends_the_wait_after_an_emergency_stop_and_says_so(robot):
    robot.supervisor.freeze()
    with pytest.raises(EmergencyStopOn):
        robot.supervisor.stand()
    robot.supervisor.release()
    with pytest.raises(RobotStaysStill, match='it waits for stand'):
        robot.supervisor.sit()
    robot.run(0.1)
    robot.supervisor.stand()
    robot.run(0.1)
    assert robot.activity is Activity.STANDING


def test_an_emergency_stop_that_is_not_on_is_not_released(robot):
    assert robot.supervisor.release() == 'the emergency stop was not on'
    robot.step()
    assert robot.activity is Activity.STANDING


def test_before_anything_is_known_of_the_joints_an_emergency_stop_commands_nothing():
    robot = Robot()
    assert robot.supervisor.freeze() is None
    assert robot.activity is Activity.EMERGENCY_STOP
    assert robot.run(1.0) == []


def test_a_fall_is_answered_once(robot):
    assert len(robot.run(2.0, tilt=1.0)) == 1
    assert robot.run(2.0) == []
    assert robot.activity is Activity.FALLEN
    assert 'is upright again' in robot.supervisor.reason


def test_a_robot_that_lies_says_what_is_to_be_done_before_it_stands(robot):
    robot.run(0.1, tilt=1.0)
    assert 'tilted by 57 degrees: set it upright' in robot.supervisor.stand()
    robot.run(0.1, tilt=1.0)
    assert robot.activity is Activity.FALLEN
    robot.run(0.1)
    assert 'stands in its initial posture' in robot.supervisor.stand()
    robot.run(0.1)
    assert robot.activity is Activity.STANDING


def test_of_a_robot_that_lies_on_the_ground_no_joint_is_found_to_fail(robot):
    robot.run(0.1, tilt=1.0)
    robot.fail()
    robot.run(0.5)
    assert robot.activity is Activity.FALLEN


def test_a_lame_robot_refuses_wishes_with_the_joints_name(robot):
    robot.fail()
    robot.run(0.1)
    assert robot.activity is Activity.LAME
    robot.supervisor.set_plan(AHEAD)
    assert robot.supervisor.wanted_plan is None
    assert FAULT.name in robot.supervisor.limit
    with pytest.raises(RobotIsLame):
        robot.supervisor.sit()
    assert 'is tried first' in robot.supervisor.stand()


def test_a_lame_robot_that_falls_says_both(robot):
    robot.fail()
    robot.run(0.1)
    robot.run(0.1, tilt=1.0)
    assert robot.activity is Activity.FALLEN
    assert FAULT.name in robot.supervisor.reason
    robot.run(0.1)
    assert robot.activity is Activity.LAME
    assert 'the robot has fallen' in robot.supervisor.reason


def test_a_lame_robot_without_joint_states_says_so_while_they_are_missing(robot):
    robot.fail()
    robot.run(0.1)
    assert robot.run(1.0, problem=SILENCE) == []
    assert robot.supervisor.limit == SILENCE
    robot.run(0.1)
    assert robot.supervisor.limit == ''
    assert robot.activity is Activity.LAME


def test_a_silent_robot_begins_nothing_and_says_why_until_it_hears_again(robot):
    robot.supervisor.set_plan(AHEAD)
    assert robot.run(1.0, problem=SILENCE) == []
    assert (robot.activity, robot.supervisor.reason) == (Activity.WAITING, SILENCE)
    assert len(robot.run(0.1)) == 1
    assert robot.activity is Activity.WALKING


def test_a_robot_whose_joints_were_never_heard_of_waits(robot):
    robot = Robot()
    robot.supervisor.set_plan(AHEAD)
    assert robot.run(0.1, joint_positions=None, joint_velocities=None) == []
    assert robot.activity is Activity.WAITING


def test_while_nobody_executes_trajectories_few_are_given_out():
    robot = Robot()
    supervisor = robot.supervisor
    supervisor._joints._is_watched = True
    given = []
    for _ in range(60):
        supervisor.set_twist(Twist2D(0.05))
        given.append(len(robot.run(0.5)))
    assert supervisor.activity is Activity.NOT_EXECUTED
    assert supervisor.activity.is_terminal
    # Pauses of 2 s, trials of 4 s.
    assert 3 <= sum(given) <= 30 / 6 * 2 + 2
    assert np.all(np.diff(np.flatnonzero(given)) >= 1)
