"""What gait_node reports, and whether it misses its planner."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from told_supervisor import ToldSupervisor, measurement

from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.status import Level
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.following.gait_pair import GaitPair
from quad_gait.gait_status import GaitStatus
from quad_gait.parameters import GaitParameters
from quad_gait.planner_watch import PlannerWatch
from quad_gait.state.body_placement import BodyPose
from quad_gait.state.sensor_inputs import JointReadings
from quad_gait.state.stance import Stance
from quad_gait.supervisor import Supervisor

ROBOT = load_robot('titan_viii')
ORIGIN = Pose2D(0.0, 0.0, 0.0)


class Clock:
    """A clock that is set by hand."""

    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


# The planner


def test_a_planner_without_a_heartbeat_is_not_missed(clock):
    watch = PlannerWatch(3.0, clock)
    clock.now = 100.0
    assert watch.problem == ''


def test_a_planner_is_missed_until_it_lives_again_or_another_plan_comes(clock):
    watch = PlannerWatch(3.0, clock)
    watch.take_heartbeat()
    clock.now = 3.0
    assert watch.problem == ''
    clock.now = 3.1
    assert 'no heartbeat of the planner for 3 s' in watch.problem
    watch.take_heartbeat()
    assert watch.problem == ''
    clock.now = 7.0
    watch.take_plan()
    assert watch.problem == ''


def test_a_plan_of_a_living_planner_leaves_it_watched(clock):
    watch = PlannerWatch(3.0, clock)
    watch.take_heartbeat()
    watch.take_plan()
    clock.now = 4.0
    assert watch.problem


def test_a_planner_that_is_not_watched_is_never_missed(clock):
    watch = PlannerWatch(0.0, clock)
    watch.take_heartbeat()
    clock.now = 1e6
    assert watch.problem == ''


# The status


class Robot:
    def __init__(self, clock):
        gait = load_gait('crawl', ROBOT)
        self.supervisor = ToldSupervisor(
            ROBOT, gait, turning_gait_for(gait, ROBOT), SupervisorOptions()
        )
        estimator = self.supervisor.estimator
        self.status = GaitStatus(self.supervisor, estimator, GaitParameters(), clock)

    def said(self, clock_problem=None, *notes):
        return self.status.status(clock_problem, *notes)


@pytest.fixture
def robot(clock):
    return Robot(clock)


def test_a_clock_that_stands_still_is_said_first(robot):
    status = robot.said('no clock')
    assert (status.level, status.message) == (Level.STALE, 'no clock')


def test_odometry_that_is_missing_or_stands_still_is_said(robot, clock):
    assert "no odometry: waiting for it on 'odom'" in robot.said().message
    robot.status.take_odometry(is_new=True)
    assert 'odometry' not in robot.said().message
    clock.now = 1.1
    assert robot.said().message.startswith('no odometry')
    robot.status.take_odometry(is_new=False)
    assert robot.said().message.startswith('stale odometry')


def test_what_the_robot_does_is_said_with_its_level_and_values(robot):
    robot.status.take_odometry(is_new=True)
    robot.supervisor.update(measurement(ROBOT, 1.0))
    status = robot.said()
    assert (status.level, status.message) == (Level.OK, 'standing: no plan to follow')
    assert status.values['activity'] == Activity.STANDING.value
    robot.supervisor.update(measurement(ROBOT, 1.1, tilt=1.0))
    assert robot.said().level is Level.ERROR
    assert robot.said().message.startswith('fallen: ')


def test_the_most_that_the_gait_does_is_told(robot):
    robot.status.take_odometry(is_new=True)
    robot.supervisor.update(measurement(ROBOT, 1.0))
    values = robot.said().values
    assert values['cycle_period'] == '5.000'
    for name, motion in (
        ('largest_forward', BodyMotion(forward=1.0)),
        ('largest_left', BodyMotion(left=1.0)),
    ):
        limits = robot.supervisor.gait_pair.walking
        asked = motion.scaled(float(values[name]) * limits.period)
        assert limits.largest_scale(asked) == pytest.approx(1.0, rel=5e-3)
    turning = robot.supervisor.gait_pair.turning
    asked = BodyMotion(turn=float(values['largest_turn']) * turning.period)
    assert turning.largest_scale(asked) == pytest.approx(1.0, rel=5e-3)


def test_nav2s_controller_asks_for_three_quarters_of_what_cuhks_trot_does_at_most():
    path = Path(__file__).parents[2] / 'config' / 'nav2_controller.yaml'
    asked = yaml.safe_load(path.read_text(encoding='utf-8'))['controller_server']['ros__parameters']
    cuhk = load_robot('cuhk')
    trot = load_gait('trot', cuhk)
    most = GaitPair(cuhk, trot, trot, 0.01).largest_speeds
    follow = asked['FollowPath']
    assert 0.6 * most.forward < follow['desired_linear_vel'] <= 0.75 * most.forward
    assert follow['rotate_to_heading_angular_vel'] <= 0.75 * most.turn
    assert asked['controller_frequency'] * trot.cycle_period <= 2.5


def test_notes_make_a_warning(robot):
    robot.status.take_odometry(is_new=True)
    robot.supervisor.update(measurement(ROBOT, 1.0))
    assert robot.said(None, '', '').level is Level.OK
    status = robot.said(None, 'the last correction is 9 s old', '')
    assert status.level is Level.WARN
    assert status.message.endswith('; the last correction is 9 s old')


def test_a_wrong_height_map_is_a_warning(robot):
    robot.status.take_odometry(is_new=True)
    robot.supervisor.update(measurement(ROBOT, 1.0))
    level = HeightMap.level((-2.0, -2.0, 2.0, 2.0), 0.02)
    body = BodyPose(np.zeros(3), 0.0, 0.0, 0.0)
    feet = ROBOT.neutral_feet + np.outer([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.06])
    stance = Stance(1.0, body, feet, ROBOT.initial_joint_angles, lambda: None)
    assert robot.status.has_changed(ORIGIN)
    robot.supervisor.felt_ground.note_contact(0, stance, level)
    assert robot.status.has_changed(ORIGIN)
    assert robot.said().level is Level.WARN
    assert 'the height map does not show what the feet met' in robot.said().message


@pytest.mark.parametrize('efforts', [None, np.zeros(12)])
@pytest.mark.parametrize('ground', ['uneven', 'flat'])
def test_feet_that_cannot_feel_uneven_ground_are_a_warning(robot, clock, ground, efforts):
    estimator = robot.supervisor.estimator
    status = GaitStatus(robot.supervisor, estimator, GaitParameters(ground=ground), clock)
    status.take_odometry(is_new=True)
    robot.supervisor.update(measurement(ROBOT, 1.0))
    joints = ROBOT.initial_joint_angles.reshape(-1)
    for count in range(50):
        assert 'efforts' not in status.status(None).message
        estimator.take_joints(JointReadings(joints, None, efforts, 1.0 + 0.02 * count))
    said = status.status(None)
    numb = said.message.endswith('; joint states have no efforts: feet do not feel the ground')
    assert numb == (ground == 'uneven') == (said.level is Level.WARN)
    estimator.take_joints(JointReadings(joints, None, np.full(12, 0.1), 2.0))
    assert status.status(None).level is Level.OK


def test_a_change_is_told_once(robot):
    robot.supervisor.update(measurement(ROBOT, 1.0))
    assert robot.status.has_changed(ORIGIN)
    robot.supervisor.update(measurement(ROBOT, 1.1))
    assert not robot.status.has_changed(ORIGIN)
    robot.supervisor.update(measurement(ROBOT, 1.2, tilt=1.0))
    assert robot.status.has_changed(ORIGIN)


# Made of parameters


@pytest.mark.parametrize('ground', ['flat', 'uneven'])
def test_a_supervisor_is_made_of_the_nodes_parameters(ground):
    parameters = GaitParameters(ground=ground, settle_time=0.35, cmd_vel_timeout=2.0)
    supervisor = Supervisor.from_parameters(parameters, ROBOT)
    assert supervisor.gait.name == 'crawl'
    options = parameters.supervisor_options
    assert (options.settle_time, options.twist_timeout) == (0.35, 2.0)
    assert (options.uneven is None) == (ground == 'flat')


def test_leg_odometry_starts_at_its_origin_where_it_is_the_robots_pose():
    assert GaitParameters(odom_topic='odom/legs').estimator_options.starts_at_origin
    assert GaitParameters(leg_odometry_start='origin').estimator_options.starts_at_origin
    assert not GaitParameters().estimator_options.starts_at_origin
