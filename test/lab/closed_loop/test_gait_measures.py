"""What is measured of a gait is what the robot does, cycle by cycle."""

import itertools
import math

import numpy as np
import pytest

from quad_common.errors import QuadError
from quad_common.planar_pose import STILL, Twist2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.closed_loop import SENSOR_PERIOD, ClosedLoop, DoesNotWalk
from quad_lab.closed_loop.controllers import measuring_controller
from quad_lab.closed_loop.gait_measures import fitted_radius, steady_walk
from quad_lab.closed_loop.loop_record import Record

CUHK = load_robot('cuhk')
TROT = load_gait('trot', CUHK)
STRIDE = BodyMotion(0.05)


def arc(radius, angles, center=(0.0, 0.0)):
    return radius * np.column_stack([np.cos(angles), np.sin(angles)]) + center


@pytest.fixture
def walk():
    """Yield a cuhk that stands, in the simulator without physics."""
    walk = ClosedLoop(CUHK, measuring_controller(CUHK, TROT), 'kinematic')
    yield walk
    walk.close()


def set_off(walk, motion=STRIDE, gait=TROT):
    """Steer, and wait until the first cycle has begun."""
    walk.run(0.1)
    walk.controller.set_twist(motion.rate(gait.cycle_period))
    assert walk.run(2.0, until=lambda: walk.controller.cycle_at(walk.time) is not None)


@pytest.mark.parametrize('radius', [0.1, 0.4, 25.0])
@pytest.mark.parametrize('center', [(0.0, 0.0), (-3.0, 7.0)])
def test_points_on_a_circle_have_its_radius(radius, center):
    for angle in (2.0 * np.pi, 1.0):
        points = arc(radius, np.linspace(0.0, angle, 40), center)
        assert fitted_radius(points) == pytest.approx(radius, rel=1e-6)


def test_three_points_are_enough_for_a_circle():
    assert fitted_radius(np.array([[0.0, 1.0], [1.0, 0.0], [-1.0, 0.0]])) == pytest.approx(1.0)


def test_noise_hardly_changes_the_radius_of_a_circle():
    rng = np.random.default_rng(1)
    for _ in range(20):
        radius = float(rng.uniform(0.2, 2.0))
        points = arc(radius, rng.uniform(0.0, 2.0 * np.pi, 500), rng.uniform(-5.0, 5.0, 2))
        noise = rng.normal(0.0, 0.01 * radius, points.shape)
        assert fitted_radius(points + noise) == pytest.approx(radius, rel=0.005)


def test_a_walk_goes_as_far_as_it_is_steered(walk):
    set_off(walk)
    for _ in range(4):
        walk.next_cycle_end()
    before = walk.next_cycle_end()
    for _ in range(5):
        after = walk.next_cycle_end()
    moved = before.inverse() @ after
    assert moved.x == pytest.approx(5 * STRIDE.forward, rel=0.02)
    assert (moved.y, moved.yaw) == pytest.approx((0.0, 0.0), abs=2e-3)
    assert not walk.record.has_fallen


def test_a_record_has_one_entry_for_each_measurement(walk):
    set_off(walk)
    walk.run(1.0)
    record = walk.record
    assert np.diff(record.times) == pytest.approx(SENSOR_PERIOD)
    for column in ('poses', 'tilts', 'margins', 'slips', 'torques', 'power', 'joints'):
        assert len(getattr(record, column)) == len(record.times)
    assert record.positions.shape == (len(record.times), 2)
    assert np.all(np.isfinite(record.joints))
    # Without physics the body is level.
    assert record.tilt_rms == pytest.approx(0.0, abs=1e-6)


def test_an_empty_record_has_no_tilt():
    assert math.isnan(Record(CUHK).tilt_rms)


def test_a_heading_has_no_jumps(walk):
    set_off(walk, BodyMotion(turn=0.5))
    walk.run(8.0)
    heading = walk.record.heading
    assert abs(heading[-1]) > math.pi
    assert np.abs(np.diff(heading)).max() < 0.2


def test_cycle_ends_come_one_period_after_the_other_and_never_twice(walk):
    # Neither the period of 0.45 s nor the cycles' begin fits the measurements' 0.02 s.
    assert TROT.cycle_period == 0.45
    assert walk.simulation.time_step == 0.005
    set_off(walk)
    times, poses = [], []
    for _ in range(30):
        pose = walk.next_cycle_end()
        times.append(walk.time)
        poses.append(pose)
    assert np.diff(times) == pytest.approx(TROT.cycle_period, abs=1e-6)
    for a, b in itertools.pairwise(poses[4:]):
        assert (a.inverse() @ b).x == pytest.approx(STRIDE.forward, rel=0.02)


@pytest.mark.parametrize('period', [0.437, 0.8 / 1.7])
def test_cycles_that_end_between_two_steps_of_physics_end_once_as_well(period):
    gait = TROT.with_period(period)
    walk = ClosedLoop(CUHK, measuring_controller(CUHK, gait), 'kinematic')
    try:
        set_off(walk, BodyMotion(0.03), gait)
        times = []
        for _ in range(30):
            walk.next_cycle_end()
            times.append(walk.time)
    finally:
        walk.close()
    step = walk.simulation.time_step
    # Each end is met within half a step, and that does not add up.
    assert np.diff(times) == pytest.approx(period, abs=step + 1e-9)
    assert times[-1] - times[0] == pytest.approx(29 * period, abs=step + 1e-9)


def test_each_cycle_ends_when_it_was_planned_to(walk):
    set_off(walk)
    for _ in range(30):
        scheduled = walk.controller.cycle_at(walk.time + walk.simulation.time_step)
        walk.next_cycle_end()
        assert walk.time == pytest.approx(scheduled.end, abs=1e-6)


def test_measurements_keep_their_pace_whatever_the_cycles(walk):
    set_off(walk)
    for _ in range(10):
        walk.next_cycle_end()
    walk.run(0.5)
    assert np.diff(walk.record.times) == pytest.approx(SENSOR_PERIOD)


def test_run_ends_after_its_time_or_when_it_comes_true(walk):
    assert walk.run(0.5) is False
    assert walk.time == pytest.approx(0.5)
    assert walk.run(5.0, until=lambda: walk.time > 1.0) is True
    assert walk.time == pytest.approx(1.0, abs=SENSOR_PERIOD + 0.01)
    before = walk.time
    assert walk.run(0.0) is False
    assert walk.time == before


def test_who_listens_hears_each_observation(walk):
    heard = []
    walk.on_observation.append(lambda seen: heard.append(seen.time))
    walk.run(0.5)
    assert heard == walk.record.times


def test_a_robot_of_whom_nothing_is_wanted_does_not_walk(walk):
    with pytest.raises(DoesNotWalk, match='the robot does not walk: no plan to follow') as caught:
        walk.next_cycle_end()
    assert isinstance(caught.value, QuadError)
    assert walk.time > 5.0


def test_a_robot_that_is_steered_to_stand_does_not_walk(walk):
    walk.run(0.1)
    walk.controller.set_twist(STILL)
    with pytest.raises(DoesNotWalk, match='steered to stand'):
        walk.next_cycle_end()


def test_a_robot_that_is_stopped_ends_its_cycle_and_walks_no_more(walk):
    set_off(walk)
    walk.next_cycle_end()
    walk.controller.stop()
    # The cycle that runs, and one that brings the body to rest.
    for _ in range(2):
        walk.next_cycle_end()
    with pytest.raises(DoesNotWalk):
        walk.next_cycle_end()
    assert walk.controller.cycle_at(walk.time) is None


def test_two_walks_do_not_touch(walk):
    other = ClosedLoop(CUHK, measuring_controller(CUHK, TROT), 'kinematic')
    try:
        set_off(walk)
        walk.run(1.0)
        assert other.time == 0.0
        assert other.record.times == []
    finally:
        other.close()


def test_steering_for_measuring_never_times_out(walk):
    set_off(walk)
    walk.run(20.0)
    assert walk.controller.cycle_at(walk.time) is not None


def test_a_steady_walk_is_measured_in_physics():
    pytest.importorskip('pybullet')
    seen = steady_walk(CUHK, TROT, BodyMotion(1.0), 4.0)
    assert seen.asked.forward > 0.0
    assert (seen.asked.left, seen.asked.turn) == (0.0, 0.0)
    assert seen.done.forward == pytest.approx(seen.asked.forward, rel=0.1)
    assert not seen.has_fallen
    assert seen.is_finite
    assert seen.joints_in_range
    assert 0.0 <= seen.drift < 0.1
    assert 0.0 <= seen.veer < 0.5
    assert 0.0 < seen.slip < seen.asked.forward
    assert 0.0 < seen.tilt_rms < 0.1
    assert 0.0 < seen.torque_rms < np.max(CUHK.effort)
    assert 0.0 < seen.transport_cost < 5.0


def test_a_steady_walk_of_nothing_does_not_walk():
    pytest.importorskip('pybullet')
    with pytest.raises(DoesNotWalk, match='steered to stand'):
        steady_walk(CUHK, TROT, BodyMotion(1.0), 1.0, asked=BodyMotion())


def test_the_controller_for_measuring_turns_with_the_gait_that_gait_node_takes():
    turn = Twist2D(0.0, 0.0, 1.0)
    assert measuring_controller(CUHK, TROT).gait_pair.of_twist(turn).gait == TROT
    crawl = load_gait('crawl', CUHK)
    assert measuring_controller(CUHK, crawl).gait_pair.of_twist(turn).gait == load_gait(
        'turn', CUHK
    )
