"""What a robot cannot do is refused, and what falls silent is missing."""

import numpy as np
import pytest

from quad_common.errors import InvalidMessage
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.state.leg_odometry import LegOdometry
from quad_gait.state.sensor_inputs import RANGE_MARGIN, InputOptions, JointReadings, SensorInputs

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
ORIGIN = Pose2D(0.0, 0.0, 0.0)


def readings(time, positions=POSTURE, velocities=None, efforts=None):
    return JointReadings(np.array(positions), velocities, efforts, time)


def rolled(angle):
    return np.array([np.sin(angle / 2.0), 0.0, 0.0, np.cos(angle / 2.0)])


def standing_inputs(until=1.0, **options):
    inputs = SensorInputs(ROBOT, InputOptions(**options))
    for time in np.arange(until - 1.0, until + 1e-9, 0.02):
        inputs.take_joints(readings(time))
        inputs.take_odometry(time, ORIGIN, LEVEL)
    return inputs


@pytest.mark.parametrize('name', available_robots())
def test_every_joint_may_be_anywhere_in_its_range_and_a_little_beyond(name):
    robot = load_robot(name)
    for bound, sign in ((robot.lower, -1.0), (robot.upper, 1.0)):
        for margin, fits in ((0.0, True), (0.99, True), (1.01, False)):
            positions = bound.reshape(-1) + sign * margin * RANGE_MARGIN
            inputs = SensorInputs(robot)
            if fits:
                assert inputs.take_joints(readings(0.0, positions))
            else:
                with pytest.raises(InvalidMessage, match='rad; its range is'):
                    inputs.take_joints(readings(0.0, positions))


@pytest.mark.parametrize('value', [7.85, 1e308, -1e154, np.nan])
def test_a_wrapped_or_absurd_encoder_is_refused_for_as_long_as_it_lasts(value):
    inputs = standing_inputs()
    wrong = POSTURE.copy()
    wrong[3] = value
    for time in np.arange(1.02, 3.0, 0.02):
        with pytest.raises(InvalidMessage, match='rf_hip_yaw_joint'):
            inputs.take_joints(readings(time, wrong))
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
        assert np.array_equal(now.joint_positions, POSTURE)
    assert 'rf_hip_yaw_joint is at' in now.problem
    assert 'does its encoder count turns?' in now.problem
    assert inputs.take_joints(readings(3.0))
    assert inputs.take_odometry(3.0, ORIGIN, LEVEL).problem == ''


@pytest.mark.parametrize(('what', 'words'), [('velocities', 'velocity of'), ('efforts', 'effort')])
def test_velocities_and_efforts_that_no_joint_has_are_refused(what, words):
    values = np.zeros(12)
    values[5] = 1e308
    with pytest.raises(InvalidMessage, match=words):
        SensorInputs(ROBOT).take_joints(readings(0.0, **{what: values}))


def test_a_joint_that_leaps_is_refused_and_believed_when_it_stays():
    inputs = standing_inputs()
    elsewhere = POSTURE + 0.7
    refusals, moved = [], []
    for time in np.arange(1.02, 2.0, 0.02):
        try:
            inputs.take_joints(readings(time, elsewhere))
        except InvalidMessage as error:
            refusals.append(str(error))
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
        moved.append(now.was_moved)
    assert 8 <= len(refusals) <= 12
    assert all('would have turned by 0.700 rad' in refusal for refusal in refusals)
    assert sum(moved) == 1
    assert np.array_equal(now.joint_positions, elsewhere)


def test_without_joint_states_a_measurement_says_since_when():
    inputs = standing_inputs(joint_timeout=0.21)
    for time in np.arange(1.02, 2.0, 0.02):
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
        assert bool(now.problem) == (time - 1.0 > 0.21)
    assert now.problem == 'no joint states for 1.0 s'
    assert SensorInputs(ROBOT).take_odometry(0.0, ORIGIN, LEVEL).problem == 'no joint states yet'


def test_joint_states_without_a_stamp_are_missed_as_well():
    inputs = SensorInputs(ROBOT)
    for time in np.arange(0.0, 1.01, 0.02):
        inputs.take_joints(readings(None))
        assert inputs.take_odometry(time, ORIGIN, LEVEL).problem == ''
    for time in np.arange(1.02, 2.0, 0.02):
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
    assert now.problem == 'no joint states for 1.0 s'
    inputs.take_joints(readings(None))
    assert inputs.take_odometry(2.0, ORIGIN, LEVEL).problem == ''


def test_odometry_that_is_the_first_to_come_after_a_pause_does_not_make_joints_missing():
    inputs = standing_inputs()
    for time in (2.0, 2.02):
        assert inputs.take_odometry(time, ORIGIN, LEVEL).problem == ''
    inputs.take_joints(readings(2.02))
    assert inputs.take_odometry(2.04, ORIGIN, LEVEL).problem == ''


@pytest.mark.parametrize(
    ('behind', 'words'),
    [
        (1000.0, 'joint states are 1000.0 s older than the odometry'),
        (0.5, 'joint states are 0.5 s older than the odometry'),
        (-1000.0, 'joint states are stamped 1000.0 s after the odometry: do their clocks differ?'),
    ],
)
def test_joint_states_of_another_time_than_the_odometry_are_missing_though_they_come(behind, words):
    inputs = SensorInputs(ROBOT)
    for time in np.arange(2000.0, 2001.0, 0.02):
        inputs.take_joints(readings(time - behind))
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
    assert now.problem == words
    # Together they may be of any time, and old ones are forgiven to a machine that has paused.
    inputs = standing_inputs()
    for time in np.arange(1.5, 1.6, 0.02):
        inputs.take_joints(readings(time - 0.48))
        assert inputs.take_odometry(time, ORIGIN, LEVEL).problem == ''


@pytest.mark.parametrize('ahead', [0.0, 3.0, 1000.0])
def test_joint_states_that_fall_silent_are_missed_however_they_were_stamped(ahead):
    inputs = SensorInputs(ROBOT)
    for time in np.arange(0.0, 1.01, 0.02):
        inputs.take_joints(readings(time + ahead))
        inputs.take_odometry(time, ORIGIN, LEVEL)
    for time in np.arange(1.02, 2.0, 0.02):
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
    assert now.problem == 'no joint states for 1.0 s'


@pytest.mark.parametrize('attitude', [None, LEVEL])
@pytest.mark.parametrize(
    ('behind', 'words'),
    [(1000.0, "1000.0 s older than the odometry: odometry's attitude"), (-1000.0, 'clocks differ')],
)
def test_an_imu_of_another_time_than_the_odometry_tells_nothing(behind, words, attitude):
    inputs = standing_inputs(2000.0)
    for time in np.arange(2000.02, 2001.0, 0.02):
        inputs.take_imu(time - behind, attitude, 0.5)
        inputs.take_joints(readings(time))
        inputs.take_odometry(time, ORIGIN, LEVEL)
    assert words in inputs.imu_problem
    assert inputs.imu_at(2000.98) == (None, None)
    for time in np.arange(2001.0, 2002.0, 0.02):
        inputs.take_joints(readings(time))
        inputs.take_odometry(time, ORIGIN, LEVEL)
    assert inputs.imu_problem.startswith('no imu for')


def test_an_imu_that_falls_silent_gives_way_to_the_odometry():
    inputs = standing_inputs(imu_timeout=0.2)
    inputs.take_imu(1.0, rolled(0.1), 0.0)
    assert inputs.take_odometry(1.1, ORIGIN, LEVEL).tilt == pytest.approx(0.1)
    late = inputs.take_odometry(1.3, ORIGIN, LEVEL)
    assert late.tilt == 0.0
    assert np.array_equal(late.orientation, LEVEL)


ATTITUDE, NONE = "odometry's attitude takes its place", 'the body is taken to be level'


@pytest.mark.parametrize(
    ('options', 'words', 'problem'),
    [
        ({}, ATTITUDE, ''),
        ({'needs_attitude': True}, ATTITUDE, ''),
        ({'odometry_has_attitude': False}, NONE, ''),
        (
            {'odometry_has_attitude': False, 'needs_attitude': True},
            'odometry by legs does not tell roll and pitch',
            'no imu for 0.',
        ),
    ],
)
def test_a_silent_imu_is_said_and_stops_only_a_robot_that_needs_it(options, words, problem):
    inputs = standing_inputs(**options)
    said = []
    for time in np.arange(1.02, 2.0, 0.02):
        inputs.take_joints(readings(time))
        if time < 1.2:
            inputs.take_imu(time, LEVEL, 0.5)
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
        said.append(inputs.imu_problem)
        assert bool(now.problem) == (bool(problem) and bool(inputs.imu_problem))
    assert [bool(sentence) for sentence in said].index(True) == pytest.approx(19, abs=1)
    assert said[-1].startswith('no imu for 0.8 s')
    assert words in said[-1]
    assert now.problem.startswith(problem)
    assert inputs.imu_at(1.98) == (None, None)
    inputs.take_imu(2.0, LEVEL, 0.5)
    assert inputs.take_odometry(2.0, ORIGIN, LEVEL).problem == inputs.imu_problem == ''
    assert inputs.imu_at(2.0)[1] == 0.5


@pytest.mark.parametrize(
    ('has_attitude', 'is_needed'), [(True, True), (False, False), (False, True)]
)
def test_an_imu_that_never_came_is_missed_where_nothing_else_tells_the_attitude(
    has_attitude, is_needed
):
    options = InputOptions(odometry_has_attitude=has_attitude, needs_attitude=is_needed)
    inputs, first = SensorInputs(ROBOT, options), None
    for time in np.arange(1.0, 4.0, 0.02):
        inputs.take_joints(readings(time))
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
        if inputs.imu_problem:
            first = time if first is None else first
            assert inputs.imu_problem.startswith('no imu yet')
            assert bool(now.problem) is is_needed
        else:
            assert now.problem == ''
    if has_attitude:
        assert first is None
    else:
        assert 1.9 < first < 2.2
        inputs.take_imu(4.0, LEVEL, 0.0)
        assert inputs.take_odometry(4.0, ORIGIN, LEVEL).problem == inputs.imu_problem == ''


@pytest.mark.parametrize(
    ('pose', 'attitude', 'words'),
    [
        (Pose2D(1.0, 0.0, 0.0), LEVEL, 'would have moved by 1 m'),
        (Pose2D(0.0, 0.0, 2.0), LEVEL, 'would have turned by 115 degrees'),
        (ORIGIN, rolled(1.4), 'would have turned by 80 degrees'),
        (Pose2D(1e300, 0.0, 0.0), LEVEL, 'would have moved'),
    ],
)
def test_a_single_pose_that_no_body_reaches_is_refused(pose, attitude, words):
    inputs = standing_inputs()
    with pytest.raises(InvalidMessage, match=words):
        inputs.take_odometry(1.02, pose, attitude)
    now = inputs.take_odometry(1.04, ORIGIN, LEVEL)
    assert (now.pose, now.tilt, now.was_moved) == (ORIGIN, 0.0, False)


def test_a_robot_that_was_put_elsewhere_is_believed_after_a_moment():
    inputs = standing_inputs()
    there = Pose2D(3.0, 1.0, 1.0)
    moved_at = None
    for time in np.arange(1.02, 2.0, 0.02):
        inputs.take_joints(readings(time))
        try:
            now = inputs.take_odometry(time, there, LEVEL)
        except InvalidMessage:
            continue
        moved_at = time if now.was_moved else moved_at
    assert moved_at == pytest.approx(1.22, abs=0.03)
    assert now.pose == there


def test_leg_odometry_forgets_an_absurd_joint_at_once():
    odometry = LegOdometry(ROBOT)
    for time in (0.0, 0.02, 0.04):
        odometry.update(time, POSTURE)
    wrong = POSTURE.copy()
    wrong[4] = 1e308
    with pytest.raises(InvalidMessage, match='20 are the most'):
        odometry.update(0.06, wrong)
    odometry.update(0.08, POSTURE)
    assert odometry.pose.distance_to(ORIGIN) < 1e-12
    assert np.isfinite(odometry.covariance).all()


def test_readings_without_a_stamp_among_stamped_ones_are_refused():
    inputs = standing_inputs()
    inputs.take_imu(1.0, LEVEL, 0.0)
    inputs.take_odometry(1.02, ORIGIN, LEVEL)
    with pytest.raises(InvalidMessage, match='no stamp, and those before it have one'):
        inputs.take_imu(None, np.array([1.0, 0.0, 0.0, 0.0]), 0.0)
    moved = POSTURE.copy()
    moved[4] += 0.2
    with pytest.raises(InvalidMessage, match='no stamp'):
        inputs.take_joints(readings(None, moved))
    now = inputs.take_odometry(1.04, ORIGIN, LEVEL)
    assert now.tilt == 0.0
    assert np.array_equal(now.joint_positions, POSTURE)
    inputs.take_imu(1.04, rolled(0.01), 0.0)
    assert inputs.take_odometry(1.06, ORIGIN, LEVEL).tilt == pytest.approx(0.01)


def test_a_driver_that_stamps_no_longer_is_believed_after_a_silence():
    inputs = standing_inputs()
    for time in np.arange(1.02, 1.5, 0.02):
        inputs.take_odometry(time, ORIGIN, LEVEL)
    assert inputs.take_joints(readings(None))
    assert inputs.take_odometry(1.5, ORIGIN, LEVEL).problem == ''


@pytest.mark.parametrize('needs_attitude', [False, True])
def test_an_imu_without_orientation_tells_no_attitude(needs_attitude):
    options = {'odometry_has_attitude': False, 'needs_attitude': needs_attitude}
    inputs = SensorInputs(ROBOT, InputOptions(**options))
    for time in np.arange(0.02, 2.0, 0.02):
        inputs.take_joints(readings(time))
        inputs.take_imu(time, None, 0.1)
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
    assert inputs.imu_problem.startswith('no orientation by the imu yet')
    assert bool(now.problem) is needs_attitude
    # What it does tell counts.
    assert inputs.imu_at(1.98) == (None, 0.1)
    for time in np.arange(2.0, 2.2, 0.02):
        inputs.take_joints(readings(time))
        inputs.take_imu(time, LEVEL, 0.1)
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
    assert inputs.imu_problem == now.problem == ''
    for time in np.arange(2.2, 3.0, 0.02):
        inputs.take_joints(readings(time))
        inputs.take_imu(time, None, 0.1)
        now = inputs.take_odometry(time, ORIGIN, LEVEL)
    assert inputs.imu_problem.startswith('no orientation by the imu for 0.8 s')
