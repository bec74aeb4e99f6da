"""Leg odometry against motions that are known exactly, and against the physics."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from quad_common.errors import InvalidMessage
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import generate_cycle
from quad_gait.state.leg_odometry import LONGEST_HOLD, LegOdometry

TITAN = load_robot('titan_viii')
# The same robot on points instead of balls: its feet stay where they stand, exactly.
POINTED = replace(TITAN, links={**TITAN.links, 'foot': replace(TITAN.links['foot'], radius=0.0)})
ORIGIN = Pose2D(0.0, 0.0, 0.0)
DT = 0.02

MOTIONS = {
    'crawl': ('crawl', BodyMotion(forward=0.15)),
    'backward': ('crawl', BodyMotion(forward=-0.1)),
    'sideways': ('crawl', BodyMotion(left=0.05)),
    'arc': ('crawl', BodyMotion(forward=0.1, left=0.02, turn=0.2)),
    'turning in place': ('turn', BodyMotion(turn=0.6)),
    'on the spot': ('crawl', BodyMotion()),
}

each_motion = pytest.mark.parametrize('motion', MOTIONS)
each_sense = pytest.mark.parametrize('senses', ['orientation', 'yaw rate', 'feet alone'])


@cache
def cycle_of(robot_on, motion):
    gait, body_motion = MOTIONS[motion]
    robot = {'points': POINTED, 'balls': TITAN}[robot_on]
    return robot, generate_cycle(robot, load_gait(gait), body_motion)


def worst_error(robot, cycle, senses, knows_contacts=True):
    """Walk a cycle just as planned; largest error at any time, and the rolling of a foot [m]."""
    odometry = LegOdometry(robot)
    rates = np.gradient(cycle.body[:, 2], cycle.times)
    worst = np.zeros(3)
    for k, time in enumerate(cycle.times):
        pose = odometry.update(
            time,
            cycle.joint_positions[k].reshape(-1),
            cycle.in_contact[k] if knows_contacts else None,
            quaternion(0.0, 0.0, cycle.body[k, 2]) if senses == 'orientation' else None,
            rates[k] if senses == 'yaw rate' else None,
        )
        worst = np.maximum(worst, np.abs(difference(pose, Pose2D(*cycle.body[k]))))
    distances = np.linalg.norm(np.diff(cycle.feet[..., :2], axis=0), axis=2)
    standing = cycle.in_contact[1:] & cycle.in_contact[:-1]
    return worst, np.where(standing, distances, 0.0).sum(axis=0).max()


def rotation(roll, pitch, yaw):
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def quaternion(roll, pitch, yaw):
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in (roll, pitch, yaw))
    return np.array(
        [
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ]
    )


def joints_for(place, angles, feet):
    """Joint angles, shape (12,), of a body at a place with its feet at places in the world."""
    return POINTED.joint_angles((feet - place) @ rotation(*angles)).reshape(-1)


def swaying_body(times):
    """Places (n, 3) and roll, pitch, yaw (n, 3) of a body that sways in every direction it can."""
    waves = np.stack([np.sin(2.0 * times + k) - math.sin(k) for k in range(6)], axis=1)
    places = 0.03 * waves[:, :3] + [0.0, 0.0, POINTED.standing_height]
    return places, [0.05, 0.06, 0.15] * waves[:, 3:]


def walk(duty_factor, speed=0.1, turn=0.1, period=1.0, offsets=(0.0, 0.5, 0.5, 0.0), count=200):
    """Samples of a steady walk: joint angles, contacts and poses at each instant."""
    times = DT * np.arange(count)
    samples = []
    feet = POINTED.neutral_feet + [0.0, 0.0, POINTED.standing_height]
    stood = np.zeros(4, dtype=bool)
    for time in times:
        x, y, yaw = BodyMotion(speed, 0.0, turn).pose_at(np.array(time))
        pose = Pose2D(float(x), float(y), float(yaw))
        neutral = pose.transform(POINTED.neutral_feet + [0.0, 0.0, POINTED.standing_height])
        stands = np.array([(time / period - offset) % 1.0 < duty_factor for offset in offsets])
        for k in range(4):
            if not stands[k]:
                feet[k] = neutral[k] + [0.04, 0.01, 0.03]
            elif not stood[k]:
                feet[k] = neutral[k]
        stood = stands
        place = np.array([pose.x, pose.y, POINTED.standing_height])
        samples.append((time, joints_for(place, (0.0, 0.0, pose.yaw), feet), stands, pose))
    return samples


def difference(a, b):
    return np.array([a.x - b.x, a.y - b.y, wrap_angle(a.yaw - b.yaw)])


@each_motion
@each_sense
def test_on_points_a_cycle_walked_as_planned_gives_back_the_bodys_motion(motion, senses):
    worst, rolled = worst_error(*cycle_of('points', motion), senses)
    assert rolled == pytest.approx(0.0, abs=1e-12)
    # The trapezoidal rule integrates the rate of turning between two samples.
    assert worst.max() < (1e-3 if senses == 'yaw rate' else 1e-9)


@each_motion
@each_sense
def test_on_balls_it_is_as_exact_as_their_rolling_is_planned(motion, senses):
    worst, rolled = worst_error(*cycle_of('balls', motion), senses)
    # A foot rolls for 8 to 17 mm, planned to a few percent of it.
    assert 5e-3 < rolled < 0.02
    assert worst[:2].max() < min(0.04 * rolled, 3e-4)
    # The same error at a foot, 0.3 m off the center, as an angle.
    assert worst[2] < 1e-3


@pytest.mark.sweep(kept=8)
@each_motion
@each_sense
@pytest.mark.parametrize('robot_on', ['points', 'balls'])
def test_without_contacts_a_cycle_is_known_to_a_few_tenths_of_a_millimetre(
    motion, senses, robot_on
):
    # A foot that rises, or comes down, is on the ground a few instants too long.
    worst, _ = worst_error(*cycle_of(robot_on, motion), senses, knows_contacts=False)
    assert worst[:2].max() < 5e-4
    assert worst[2] < 1.5e-3


def test_all_feet_down_and_swaying_gives_the_sway_in_all_six_directions():
    times = DT * np.arange(200)
    places, angles = swaying_body(times)
    feet = POINTED.neutral_feet + [0.0, 0.0, POINTED.standing_height]
    odometry = LegOdometry(POINTED)
    for time, place, rpy in zip(times, places, angles):
        joints = joints_for(place, rpy, feet)
        pose = odometry.update(time, joints, orientation=quaternion(*rpy))
        assert difference(pose, Pose2D(place[0], place[1], rpy[2])) == pytest.approx(
            np.zeros(3), abs=1e-9
        )
        assert odometry.height == pytest.approx(place[2], abs=1e-9)


def test_standing_still_stays_there_for_ever():
    odometry = LegOdometry(TITAN)
    odometry.reset(Pose2D(1.0, 2.0, 3.0))
    for k in range(500):
        pose = odometry.update(DT * k, TITAN.initial_joint_angles.reshape(-1))
    assert difference(pose, Pose2D(1.0, 2.0, 3.0)) == pytest.approx(np.zeros(3), abs=1e-12)
    assert odometry.twist == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert odometry.height == pytest.approx(TITAN.standing_height)
    assert odometry.covariance == pytest.approx(np.zeros((3, 3)), abs=1e-12)


def test_the_balls_of_the_feet_roll_as_the_calves_lean():
    # Swaying to the left, the leg planes stay: each ball rolls by what its calf leans.
    left = np.linspace(0.0, 0.05, 51)
    feet = TITAN.neutral_feet - left[:, None, None] * [0.0, 1.0, 0.0]
    q = TITAN.joint_angles(feet)
    assert np.abs(q[..., 0]).max() < 1e-12
    calf_down = q[-1, :, 1] + q[-1, :, 2] - q[0, :, 1] - q[0, :, 2]
    # Where a left calf's angle grows its knee goes outward: to the left, over the foot.
    lean = calf_down * [1.0, -1.0, 1.0, -1.0]
    assert np.all(lean > 0.1)
    odometry = LegOdometry(TITAN)
    for k, joints in enumerate(q):
        pose = odometry.update(DT * k, joints.reshape(-1), orientation=(0.0, 0.0, 0.0, 1.0))
    rolled = TITAN.foot_radius * lean.mean()
    assert pose.y == pytest.approx(0.05 + rolled, abs=1e-6)
    assert (pose.x, pose.yaw) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_body_that_rolls_over_its_stiff_legs_rolls_their_balls():
    # Body and legs tilt as one by a about x: the feet's centers move by r (a x z) = -r a
    # along y, and one pair of feet stays down.
    joints = TITAN.initial_joint_angles.reshape(-1)
    left = TITAN.neutral_feet[0]
    odometry = LegOdometry(TITAN)
    only_left = [True, False, True, False]
    a = 0.2
    for k, roll in enumerate(np.linspace(0.0, a, 101)):
        pose = odometry.update(DT * k, joints, only_left, quaternion(roll, 0.0, 0.0))
    turned = rotation(a, 0.0, 0.0) @ left
    assert pose.y == pytest.approx(left[1] - TITAN.foot_radius * a - turned[1], abs=1e-6)
    assert (pose.x, pose.yaw) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert odometry.height == pytest.approx(TITAN.foot_radius - turned[2])


@pytest.mark.parametrize('duty_factor', [0.9, 0.75, 0.6, 0.54])
@pytest.mark.parametrize('has_imu', [True, False])
def test_the_walk_is_found_with_two_three_or_four_feet_down(duty_factor, has_imu):
    odometry = LegOdometry(POINTED)
    for time, joints, stands, truth in walk(duty_factor):
        imu = quaternion(0.0, 0.0, truth.yaw) if has_imu else None
        pose = odometry.update(time, joints, stands, imu)
        assert difference(pose, truth) == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.parametrize(
    ('duty_factor', 'offsets', 'has_imu'),
    [
        (0.46, (0.0, 0.5, 0.5, 0.0), True),
        (0.46, (0.0, 0.5, 0.5, 0.0), False),
        # On one foot at a time only the imu tells the heading.
        (0.29, (0.0, 0.25, 0.5, 0.75), True),
        (0.22, (0.0, 0.25, 0.5, 0.75), True),
    ],
    ids=['flying trot', 'flying trot by the feet', 'one foot at a time', 'with leaps between'],
)
def test_at_low_duty_factors_the_last_velocity_bridges_the_gaps(duty_factor, offsets, has_imu):
    odometry = LegOdometry(POINTED)
    for time, joints, stands, truth in walk(duty_factor, offsets=offsets):
        imu = quaternion(0.0, 0.0, truth.yaw) if has_imu else None
        pose = odometry.update(time, joints, stands, imu)
        assert difference(pose, truth) == pytest.approx(np.zeros(3), abs=1e-6)


def test_in_the_air_the_velocity_is_held_for_a_moment_only():
    odometry = LegOdometry(POINTED)
    samples = walk(1.0, turn=0.0, count=20)
    for time, joints, stands, _ in samples:
        pose = odometry.update(time, joints, stands)
    assert odometry.twist == pytest.approx((0.1, 0.0, 0.0), abs=1e-9)
    start = pose
    wiggle = np.random.default_rng(1)
    for k in range(1, 30):
        moving = joints + wiggle.uniform(-0.1, 0.1, 12)
        pose = odometry.update(time + k * DT, moving, np.zeros(4, dtype=bool))
        held = min(k * DT, LONGEST_HOLD)
        assert difference(pose, start) == pytest.approx([0.1 * held, 0.0, 0.0], abs=1e-9)
        speed = 0.1 if k * DT < LONGEST_HOLD + DT / 2.0 else 0.0
        assert odometry.twist[0] == pytest.approx(speed, abs=1e-9)
    # Standing again it begins where it is.
    for k in range(30, 33):
        again = odometry.update(time + k * DT, joints, np.ones(4, dtype=bool))
    assert difference(again, pose) == pytest.approx(np.zeros(3), abs=1e-12)
    assert odometry.twist == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_a_velocity_that_is_known_better_takes_the_place_of_the_feet():
    odometry = LegOdometry(POINTED)
    samples = walk(1.0, turn=0.0, count=21)
    for time, joints, stands, _ in samples[:11]:
        odometry.update(time, joints, stands)
    start = odometry.pose
    for time, joints, stands, _ in samples[11:]:
        pose = odometry.update(time, joints, stands, velocity=(0.3, -0.2))
    assert difference(pose, start) == pytest.approx([3.0 * DT, -2.0 * DT, 0.0], abs=1e-9)
    assert odometry.twist == pytest.approx((0.3, -0.2, 0.0), abs=1e-9)
    assert odometry.height == pytest.approx(POINTED.standing_height)


@each_sense
@pytest.mark.parametrize('sense_of_turn', [1.0, -1.0])
def test_the_heading_wraps_at_half_a_turn(senses, sense_of_turn):
    odometry = LegOdometry(POINTED)
    start = Pose2D(0.5, -0.5, sense_of_turn * (math.pi - 0.2))
    odometry.reset(start)
    rate = sense_of_turn * 0.1
    for time, joints, stands, truth in walk(0.75, turn=rate, count=300):
        expected = start @ truth
        imu = quaternion(0.0, 0.0, expected.yaw) if senses == 'orientation' else None
        gyro = rate if senses == 'yaw rate' else None
        pose = odometry.update(time, joints, stands, imu, gyro)
        assert -math.pi <= pose.yaw < math.pi
        assert difference(pose, expected) == pytest.approx(np.zeros(3), abs=1e-9)
        if time > 0.0:
            assert odometry.twist[2] == pytest.approx(rate, abs=1e-7)
    assert pose.yaw * start.yaw < 0.0


def test_the_twist_is_in_the_bodys_axes():
    odometry = LegOdometry(POINTED)
    odometry.reset(Pose2D(0.0, 0.0, 2.0))
    for time, joints, stands, _ in walk(0.75, speed=0.08, turn=0.3):
        odometry.update(time, joints, stands)
        if time > 0.0:
            assert odometry.twist == pytest.approx((0.08, 0.0, 0.3), abs=1e-4)


def test_where_the_imu_says_north_is_does_not_matter():
    poses = []
    for north in (0.0, 3.0):
        odometry = LegOdometry(POINTED)
        for time, joints, stands, truth in walk(0.75):
            imu = quaternion(0.0, 0.0, truth.yaw + north)
            pose = odometry.update(time, joints, stands, -imu if north else imu)
        poses.append(pose)
    assert difference(*poses) == pytest.approx(np.zeros(3), abs=1e-9)


def test_an_imu_that_falls_silent_is_done_without():
    odometry = LegOdometry(POINTED)
    for k, (time, joints, stands, truth) in enumerate(walk(0.75)):
        imu = quaternion(0.0, 0.0, truth.yaw + 1.0) if (k // 20) % 2 else None
        pose = odometry.update(time, joints, stands, imu)
        assert difference(pose, truth) == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.parametrize('jump', [0.0, -1.0, -1e-9, 0.6, 100.0])
def test_time_that_repeats_goes_back_or_jumps_moves_nothing(jump):
    odometry = LegOdometry(POINTED)
    samples = walk(1.0, turn=0.0, count=40)
    for time, joints, stands, _ in samples[:20]:
        pose = odometry.update(time, joints, stands)
    begin = samples[19][0] + jump
    assert odometry.update(begin, samples[25][1], stands) == pose
    # And it goes on from there.
    for k in range(26, 40):
        after = odometry.update(begin + DT * (k - 25), samples[k][1], stands)
    distance = samples[39][3].x - samples[25][3].x
    assert difference(after, pose) == pytest.approx([distance, 0.0, 0.0], abs=1e-9)


def test_a_reset_puts_the_body_at_the_pose_and_at_rest():
    odometry = LegOdometry(POINTED)
    samples = walk(0.75)
    for time, joints, stands, _ in samples[:50]:
        odometry.update(time, joints, stands)
    odometry.reset(Pose2D(5.0, 6.0, 0.7))
    assert odometry.pose == Pose2D(5.0, 6.0, 0.7)
    assert odometry.twist == (0.0, 0.0, 0.0)
    assert not odometry.covariance.any()
    time, joints, stands, _ = samples[80]
    assert odometry.update(time, joints, stands) == Pose2D(5.0, 6.0, 0.7)


def test_the_covariance_grows_with_the_distance_and_across_it_with_the_headings_error():
    odometry = LegOdometry(POINTED)
    last = np.zeros((3, 3))
    for time, joints, stands, _ in walk(0.75, turn=0.0, count=500):
        odometry.update(time, joints, stands)
        covariance = odometry.covariance
        assert (covariance == covariance.T).all()
        assert np.linalg.eigvalsh(covariance).min() >= -1e-15
        assert np.all(np.diag(covariance) >= np.diag(last))
        last = covariance
    assert math.sqrt(last[0, 0]) == pytest.approx(0.02, rel=0.01)
    assert last[1, 1] > 1.2 * last[0, 0]
    by_imu = LegOdometry(POINTED)
    for time, joints, stands, _ in walk(0.75, turn=0.0, count=500):
        by_imu.update(time, joints, stands, (0.0, 0.0, 0.0, 1.0))
    assert by_imu.covariance[2, 2] < 0.1 * last[2, 2]


@pytest.mark.parametrize(
    'what',
    [
        {'time': math.nan},
        {'time': math.inf},
        {'joint_positions': np.full(12, math.nan)},
        {'joint_positions': np.zeros(11)},
        {'in_contact': [True, True]},
        {'orientation': [math.nan, 0.0, 0.0, 1.0]},
        {'orientation': np.zeros(4)},
        {'orientation': [0.0, 0.0, 1.0]},
        {'yaw_rate': math.inf},
    ],
)
def test_what_is_not_finite_or_has_the_wrong_shape_is_refused_and_changes_nothing(what):
    odometry, fresh = LegOdometry(POINTED), LegOdometry(POINTED)
    samples = walk(0.75, count=30)
    for k, (time, joints, stands, _) in enumerate(samples):
        if k == 20:
            arguments = {'time': time - DT / 2.0, 'joint_positions': joints, **what}
            with pytest.raises(InvalidMessage):
                odometry.update(**arguments)
        assert odometry.update(time, joints, stands) == fresh.update(time, joints, stands)


def test_a_reset_to_a_pose_that_is_not_finite_is_refused():
    with pytest.raises(InvalidMessage):
        LegOdometry(TITAN).reset(Pose2D(math.nan, 0.0, 0.0))


@pytest.fixture(scope='module')
def walked():
    """What PyBullet's robot measured, at 50 Hz, in four cycles of the crawl, open loop."""
    pytest.importorskip('pybullet')
    from quad_sim.engines.bullet_simulator import BulletSimulator
    from quad_sim.world.world import world_from_map

    cycle = generate_cycle(TITAN, load_gait('crawl'), BodyMotion(forward=0.2))
    simulator = BulletSimulator(TITAN, world_from_map(None))
    steps = round(cycle.times[-1] / simulator.time_step)
    times = simulator.time_step * np.arange(1, steps + 1)
    positions, velocities = (
        np.stack([np.interp(times, cycle.times, column) for column in joints.reshape(-1, 12).T], 1)
        for joints in (cycle.joint_positions, cycle.joint_velocities)
    )
    observations = [simulator.observe()]
    for _ in range(4):
        for k in range(steps):
            simulator.step(positions[k], velocities[k])
            if (k + 1) % round(DT / simulator.time_step) == 0:
                observations.append(simulator.observe())
    simulator.close()
    return observations


@each_sense
def test_in_the_physics_it_finds_distance_to_three_percent_and_heading_to_a_degree(walked, senses):
    odometry = LegOdometry(TITAN)
    odometry.reset(walked[0].pose)
    for seen in walked:
        odometry.update(
            seen.time,
            seen.joint_positions,
            orientation=seen.orientation if senses == 'orientation' else None,
            yaw_rate=seen.angular_velocity_base_in_base[2] if senses == 'yaw rate' else None,
        )
    truth = walked[-1].pose
    distance = truth.distance_to(walked[0].pose)
    assert distance > 0.7
    assert odometry.pose.distance_to(truth) < 0.03 * distance
    # Feet that slip a little turn the body unseen: without the imu it is half as good.
    largest = 2.0 if senses == 'feet alone' else 1.0
    assert abs(wrap_angle(odometry.pose.yaw - truth.yaw)) < math.radians(largest)
    assert odometry.height == pytest.approx(walked[-1].position[2], abs=2e-3)


def test_in_the_physics_the_rolling_of_the_feet_counts(walked):
    distances = []
    for robot in (TITAN, POINTED):
        odometry = LegOdometry(robot)
        odometry.reset(walked[0].pose)
        for seen in walked:
            odometry.update(seen.time, seen.joint_positions, orientation=seen.orientation)
        distances.append(odometry.pose.distance_to(walked[0].pose))
    truth = walked[-1].pose.distance_to(walked[0].pose)
    assert abs(distances[0] / truth - 1.0) < 0.01 < abs(distances[1] / truth - 1.0)
