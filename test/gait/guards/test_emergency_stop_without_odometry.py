"""An emergency stop while odometry is silent: joints stop where they are commanded by then."""

import numpy as np
import pytest

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.trajectory_executor import TrajectoryExecutor
from quad_common.trajectory.trajectory_gate import JointLimits, check_command
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.state.sensor_inputs import JointReadings
from quad_gait.state.state_estimator import StateEstimator
from quad_gait.supervisor import Supervisor
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.simulation import Simulation

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


class Walk:
    """A robot that walks straight on, joints and odometry being heard or not."""

    def __init__(self, name, gait):
        self.robot = robot = load_robot(name)
        walking = load_gait(gait, robot)
        turning = turning_gait_for(walking, robot)
        self.supervisor = Supervisor(robot, walking, turning, SupervisorOptions())
        self.estimator = StateEstimator(robot)
        self.simulation = Simulation(KinematicSimulator(robot, 0.02), robot, Pose2D(0.0, 0.0, 0.0))
        self.supervisor.set_plan(Plan.through([[0.0, 0.0], [3.0, 0.0]], 0.0))
        limits = JointLimits.of(robot)
        posture = self.simulation.observe().joint_positions
        self.executor = TrajectoryExecutor(robot.joint_names, posture, limits)

    def run(self, duration, has_odometry=True, has_joints=True):
        end = self.simulation.time + duration
        while self.simulation.time < end - 1e-9:
            seen = self.simulation.observe()
            if has_joints:
                self.estimator.take_joints(
                    JointReadings(seen.joint_positions, seen.joint_velocities, None, seen.time)
                )
            if has_odometry:
                state = self.estimator.take_odometry(seen.time, seen.pose, LEVEL)
                trajectory = None if state is None else self.supervisor.update(state)
                if trajectory is not None:
                    self.simulation.accept(trajectory)
                    self.executor.accept(trajectory, self.simulation.time)
            self.simulation.step()

    def run_until_it_walks(self):
        while self.supervisor.activity is not Activity.WALKING:
            self.run(0.02)


@pytest.mark.parametrize(
    ('name', 'gait', 'silence'),
    [
        ('titan_viii', 'crawl', 0.3),
        ('titan_viii', 'crawl', 1.0),
        ('titan_viii', 'trot', 0.5),
        ('genibo', 'trot', 0.5),
    ],
)
@pytest.mark.parametrize('has_joints', [True, False])
def test_joints_stop_within_their_limits(name, gait, silence, has_joints):
    walk = Walk(name, gait)
    walk.run_until_it_walks()
    walk.run(0.7)
    last = walk.simulation.time
    walk.run(silence, has_odometry=False, has_joints=has_joints)
    now = walk.simulation.time
    time, joints = walk.estimator.newest
    # What no joint states tell is told by the node's clock.
    time += 0.0 if has_joints else now - last
    assert time == pytest.approx(now, abs=0.0401)
    command = walk.executor.command(now)
    hold = walk.supervisor.freeze(time, joints)
    check_command(JointLimits.of(walk.robot), hold, now, *command)


def test_a_robot_that_has_come_to_rest_without_odometry_is_not_moved():
    walk = Walk('titan_viii', 'crawl')
    walk.run_until_it_walks()
    walk.run(0.9)
    walk.run(9.0, has_odometry=False)
    before = walk.simulation.observe()
    assert np.abs(before.joint_velocities).max() < 1e-6
    hold = walk.supervisor.freeze(*walk.estimator.newest)
    assert hold.positions[0] == pytest.approx(before.joint_positions, abs=1e-6)


def test_joints_hold_also_where_there_never_was_odometry():
    walk = Walk('titan_viii', 'crawl')
    walk.run(0.1, has_odometry=False)
    hold = walk.supervisor.freeze(*walk.estimator.newest)
    assert hold.positions[0] == pytest.approx(walk.simulation.observe().joint_positions)
    assert walk.supervisor.activity is Activity.EMERGENCY_STOP


def test_time_goes_on_by_the_joints_whatever_their_clock():
    robot = load_robot('titan_viii')
    estimator = StateEstimator(robot)
    assert estimator.newest == (None, None)
    posture = robot.initial_joint_angles.reshape(-1)
    estimator.take_joints(JointReadings(posture, None, None, 1000.0))
    estimator.take_odometry(5.0, Pose2D(0.0, 0.0, 0.0), LEVEL)
    assert estimator.newest[0] == 5.0
    estimator.take_joints(JointReadings(posture, None, None, 1000.3))
    assert estimator.newest[0] == pytest.approx(5.3)
    estimator.take_odometry(5.35, Pose2D(0.0, 0.0, 0.0), LEVEL)
    assert estimator.newest[0] == pytest.approx(5.35)
