"""Laws of the physics: it is repeatable, isolated, and stands and walks as real things do."""

import math

import numpy as np
import pytest

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline, wrap_angle
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_common.rotations import tilt_from_quaternion
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import generate_cycle
from quad_gait.state.measurement import Measurement
from quad_gait.state.state_estimator import StateEstimator
from quad_gait.supervisor import Supervisor
from quad_sim.engines.registry import ENGINES, engines_with, make_simulator
from quad_sim.engines.simulator import GRAVITY, Contact
from quad_sim.simulation import Simulation
from quad_sim.world.world import world_from_map

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
STILL = np.zeros(12)
ORIGIN = Pose2D(0.0, 0.0, 0.0)
FIELDS = (
    'position',
    'orientation',
    'linear_velocity_base_in_base',
    'angular_velocity_base_in_base',
    'specific_force_in_base',
    'joint_positions',
    'joint_velocities',
    'joint_efforts',
)


@pytest.fixture(params=engines_with('has_world'))
def make(request):
    """Make simulators that are closed after the test."""
    pytest.importorskip(ENGINES[request.param].package)
    made = []

    def make_one(grid=None, friction=0.8, **options):
        world = world_from_map(grid, friction=friction)
        made.append(make_simulator(request.param, ROBOT, world, **options))
        return made[-1]

    yield make_one
    for simulator in made:
        simulator.close()


def step(simulator, seconds, joints=POSTURE, speeds=STILL):
    for _ in range(round(seconds / simulator.time_step)):
        simulator.step(joints, speeds)
    return simulator.observe()


def run(simulator, name, motion, start=ORIGIN):
    """Walk one cycle with some time to settle at both ends; return first and last state."""
    simulation = Simulation(simulator, ROBOT, start)
    for _ in range(round(0.2 / simulation.time_step)):
        simulation.step()
    first = simulation.observe()
    gait = load_gait(name)
    gait = gait.mirrored() if motion.turn < 0.0 else gait
    cycle = generate_cycle(ROBOT, gait, motion)
    simulation.accept(cycle.trajectory(ROBOT, simulation.time))
    for _ in range(round(5.4 / simulation.time_step)):
        simulation.step()
        simulation.observe()
    return simulation, first, simulation.observe()


def random_commands(seed, steps):
    """Smooth commands that rock the robot about."""
    rng = np.random.default_rng(seed)
    t = np.arange(steps)[:, None] * 0.005
    rates, sizes = rng.uniform(1.0, 5.0, 12), rng.uniform(-0.15, 0.15, 12)
    return POSTURE + sizes * np.sin(rates * t), sizes * rates * np.cos(rates * t)


def record(simulator, positions, velocities, every=20):
    states = []
    for k, (position, velocity) in enumerate(zip(positions, velocities)):
        simulator.step(position, velocity)
        if k % every == 0:
            seen = simulator.observe()
            states.append(np.concatenate([getattr(seen, name) for name in FIELDS]))
    return np.array(states)


def feet_in_world(seen):
    """Centers of the feet, by forward kinematics from what is observed."""
    x, y, z, w = seen.orientation
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    feet = ROBOT.foot_positions(seen.joint_positions.reshape(4, 3))
    return seen.position + feet @ rotation.T


def test_the_same_commands_give_the_identical_run_bit_for_bit(make):
    commands = random_commands(1, 600)
    assert (record(make(), *commands) == record(make(), *commands)).all()


def test_two_simulators_in_one_process_do_not_touch(make):
    commands, others = random_commands(1, 300), random_commands(2, 300)
    alone = record(make(), *commands, every=1)
    one, other = make(), make()
    together = []
    for k in range(300):
        other.step(others[0][k], others[1][k])
        together.append(record(one, commands[0][k : k + 1], commands[1][k : k + 1])[0])
    assert (np.array(together) == alone).all()
    assert other.observe().position[2] != one.observe().position[2]


def test_closing_one_simulator_leaves_the_other_running(make):
    one, other = make(), make()
    one.close()
    one.close()
    assert step(other, 0.1).position[2] == pytest.approx(ROBOT.standing_height, abs=2e-3)


def test_a_standing_robot_stays_where_it_is_and_level(make):
    simulator = make()
    start = Pose2D(1.0, -2.0, 0.7)
    simulator.reset(start)
    seen = step(simulator, 5.0)
    assert seen.pose.distance_to(start) < 2e-3
    assert seen.position[2] == pytest.approx(ROBOT.standing_height, abs=2e-3)
    assert seen.pose.yaw == pytest.approx(0.7, abs=2e-3)
    assert tilt_from_quaternion(seen.orientation) < 1e-3
    assert seen.joint_positions == pytest.approx(POSTURE, abs=2e-3)
    assert (seen.contacts, seen.has_fallen) == ((), False)


def test_the_feet_of_a_standing_robot_are_on_the_ground(make):
    simulator = make()
    simulator.reset(Pose2D(0.5, 0.5, -2.0))
    feet = feet_in_world(step(simulator, 1.0))
    assert feet[:, 2] == pytest.approx(np.full(4, ROBOT.foot_radius), abs=5e-4)
    expected = Pose2D(0.5, 0.5, -2.0).transform(ROBOT.neutral_feet)
    assert feet[:, :2] == pytest.approx(expected[:, :2], abs=2e-3)


def test_at_rest_the_accelerometer_measures_gravity_upward_within_a_percent(make):
    seen = step(make(), 1.0)
    assert seen.specific_force_in_base == pytest.approx([0.0, 0.0, GRAVITY], abs=0.01 * GRAVITY)
    assert seen.angular_velocity_base_in_base == pytest.approx(np.zeros(3), abs=1e-3)
    assert seen.linear_velocity_base_in_base == pytest.approx(np.zeros(3), abs=1e-3)


@pytest.mark.parametrize('yaw', [0.0, 0.5, 1.2, -2.6])
def test_a_standing_robot_does_not_creep_round_whatever_its_heading(make, yaw):
    simulator = make()
    simulator.reset(Pose2D(0.0, 0.0, yaw))
    assert step(simulator, 3.0).pose.yaw == pytest.approx(yaw, abs=1e-4)


@pytest.mark.parametrize(('friction', 'slips'), [(0.0, True), (0.2, True), (0.5, False)])
def test_feet_hold_and_slip_as_coulomb_says(make, friction, slips):
    # All feet push the body forward together: with 0.3 g, more than friction 0.2 can give.
    simulator = make(friction=friction)
    step(simulator, 0.2)
    start = feet_in_world(simulator.observe())[:, 0]
    body = simulator.observe().position[0]
    for k in range(1, 31):
        t = 0.005 * k
        forward = BodyMotion(forward=0.5 * 0.3 * GRAVITY * t * t).end
        feet = ROBOT.neutral_feet - [forward.x, 0.0, 0.0]
        joints = ROBOT.joint_angles(feet)
        velocity = np.tile([-0.3 * GRAVITY * t, 0.0, 0.0], (4, 1))
        speeds = ROBOT.joint_velocities(joints, velocity)
        simulator.step(joints.reshape(-1), speeds.reshape(-1))
    seen = simulator.observe()
    slip = np.abs(feet_in_world(seen)[:, 0] - start).mean()
    assert (slip > 5e-3) == slips
    advance = seen.position[0] - body
    assert advance < 0.5 * (min(friction, 0.3) + 0.1) * GRAVITY * t * t


def test_reset_puts_everything_back_but_the_time(make):
    simulator = make()
    record(simulator, *random_commands(3, 200))
    simulator.reset(Pose2D(3.0, 1.0, 2.0))
    seen = simulator.observe()
    assert seen.time == pytest.approx(1.0)
    assert seen.position == pytest.approx([3.0, 1.0, ROBOT.standing_height], abs=1e-9)
    assert seen.pose.yaw == pytest.approx(2.0)
    assert seen.joint_positions == pytest.approx(POSTURE)
    for name in (name for name in FIELDS if 'velocit' in name):
        assert np.abs(getattr(seen, name)).max() < 1e-12
    assert step(simulator, 1.0).pose.distance_to(Pose2D(3.0, 1.0, 0.0)) < 2e-3


@pytest.mark.parametrize('absurd', [1e6, 1e150, -1e308])
@pytest.mark.filterwarnings('error')
def test_absurd_commands_leave_no_number_that_is_none_and_a_reset_cures_all(
    make, absurd, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    simulator = make()
    seen = step(simulator, 0.2, np.full(12, absurd))
    assert all(np.isfinite(getattr(seen, name)).all() for name in FIELDS)
    simulator.reset(ORIGIN)
    assert step(simulator, 0.5).position[2] == pytest.approx(ROBOT.standing_height, abs=0.005)
    # Nor does an engine leave a file behind.
    assert list(tmp_path.iterdir()) == []


def test_joints_follow_their_commands(make):
    simulator = make()
    positions, velocities = random_commands(4, 400)
    for position, velocity in zip(positions, velocities):
        simulator.step(position, velocity)
    seen = simulator.observe()
    assert seen.joint_positions == pytest.approx(positions[-1], abs=0.02)
    assert seen.joint_velocities == pytest.approx(velocities[-1], abs=0.1)


def test_the_velocity_of_the_base_is_the_derivative_of_its_position(make):
    simulator = make(time_step=0.001)
    simulator.reset(Pose2D(0.0, 0.0, 1.0))
    positions, velocities = random_commands(5, 200)
    for k in range(199):
        simulator.step(positions[k], velocities[k])
    before = simulator.observe()
    simulator.step(positions[199], velocities[199])
    seen = simulator.observe()
    rate = (seen.position - before.position) / 0.001
    assert np.linalg.norm(rate) > 0.01
    yaw = seen.pose.yaw
    c, s = math.cos(yaw), math.sin(yaw)
    level = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ rate
    # The body is almost level: what tilt there is accounts for the difference.
    tolerance = 1e-3 + 2.0 * tilt_from_quaternion(seen.orientation) * np.linalg.norm(rate)
    assert seen.linear_velocity_base_in_base == pytest.approx(level, abs=tolerance)


def test_a_robot_that_is_pushed_over_has_fallen(make):
    # The left legs stand up straight while the right ones are folded away.
    simulator = make()
    joints = np.tile([0.0, 1.45, 0.1], (4, 1))
    joints[[1, 3]] = [0.0, -1.4, 0.5]
    seen = step(simulator, 3.0, joints.reshape(-1))
    assert seen.has_fallen
    assert tilt_from_quaternion(seen.orientation) > math.radians(45.0)
    assert any(contact.other == 'ground' for contact in seen.contacts)


def test_a_robot_that_lies_on_the_ground_says_with_what_it_touches_it(make):
    seen = step(make(), 2.0, np.tile([0.0, -1.4, 0.5], 4))
    assert seen.position[2] < 0.5 * ROBOT.standing_height
    touching = {contact.link for contact in seen.contacts if contact.other == 'ground'}
    assert touching & {'base_link', *(f'{leg}_hip' for leg in LEGS)}


def box_at(x, y, size=0.3):
    """Map with one square obstacle whose lower left corner is given."""
    cells = np.zeros((9, 9), np.int8)
    cells[3:6, 3:6] = 100
    return OccupancyGrid(cells, size / 3.0, Pose2D(x - size, y - size, 0.0))


def test_a_foot_that_touches_an_obstacle_is_told(make):
    # The left front foot's ball ends at y = 0.316; the box begins at 0.312.
    seen = step(make(box_at(0.05, 0.312)), 0.005)
    assert Contact('lf_foot', 'obstacle') in seen.contacts
    assert {contact.link for contact in seen.contacts} <= {'lf_foot', 'lf_calf'}
    assert not seen.has_fallen


def test_beside_an_obstacle_nothing_touches(make):
    assert step(make(box_at(0.05, 0.33)), 0.5).contacts == ()


def test_an_obstacle_stops_a_leg_and_is_told(make):
    # The left front leg reaches out to where the box begins at y = 0.33.
    joints = POSTURE.copy()
    joints[1], joints[2] = -0.3, 1.2
    ends = {}
    for name, grid in (('blocked', box_at(0.05, 0.33)), ('free', None)):
        simulation = Simulation(make(grid), ROBOT, ORIGIN)
        simulation.accept(
            JointTrajectory(ROBOT.joint_names, 0.0, np.array([0.5]), joints[None], STILL[None])
        )
        farthest = 0.0
        for _ in range(150):
            simulation.step()
            farthest = max(farthest, feet_in_world(simulation.observe())[0, 1])
        ends[name] = farthest, {contact.other for contact in simulation.contacts_seen}
    assert ends['free'][0] > 0.38
    assert ends['blocked'][0] < 0.33
    assert (ends['free'][1], ends['blocked'][1]) == (set(), {'obstacle'})


@pytest.mark.sweep(kept=3)
@pytest.mark.parametrize(
    ('name', 'motion'),
    [
        ('crawl', BodyMotion(forward=ROBOT.largest_stride)),
        ('crawl', BodyMotion(forward=0.1)),
        ('turn', BodyMotion(turn=ROBOT.largest_turn)),
        ('turn', BodyMotion(turn=-ROBOT.largest_turn)),
    ],
    ids=['crawl', 'short crawl', 'left', 'right'],
)
def test_a_cycle_advances_about_as_far_as_commanded(make, name, motion):
    simulation, first, last = run(make(), name, motion, Pose2D(1.0, 2.0, 0.5))
    moved = first.pose.inverse() @ last.pose
    assert moved.x == pytest.approx(motion.forward, abs=max(0.1 * motion.forward, 0.01))
    assert moved.y == pytest.approx(0.0, abs=0.01)
    assert moved.yaw == pytest.approx(motion.turn, abs=max(0.1 * abs(motion.turn), 0.02))
    assert (simulation.contacts_seen, simulation.has_fallen) == (set(), False)
    assert tilt_from_quaternion(last.orientation) < math.radians(1.0)


def test_a_turn_to_the_right_mirrors_a_turn_to_the_left(make):
    turns = []
    for side in (1.0, -1.0):
        _, first, last = run(make(), 'turn', BodyMotion(turn=side * 0.5))
        moved = first.pose.inverse() @ last.pose
        turns.append((moved.x, side * moved.y, side * moved.yaw))
    assert turns[0] == pytest.approx(turns[1], abs=0.02)


@pytest.mark.sweep(kept=1)
def test_a_short_walk_round_a_corner_arrives(make):
    plan = Plan.through([[0.0, 0.0], [0.5, 0.0], [0.5, 0.4]], math.pi / 2)
    simulation = Simulation(make(), ROBOT, ORIGIN)
    controller = Supervisor(ROBOT, load_gait('crawl'), load_gait('turn'), SupervisorOptions())
    controller.set_plan(plan)
    estimator = StateEstimator(ROBOT)
    for k in range(round(100.0 / simulation.time_step)):
        if k % 10 == 0:
            seen = simulation.observe()
            measurement = Measurement(
                seen.time,
                seen.pose,
                tilt_from_quaternion(seen.orientation),
                seen.joint_positions,
                seen.joint_velocities,
            )
            trajectory = controller.update(estimator.judge(measurement))
            if trajectory is not None:
                simulation.accept(trajectory)
            assert distance_to_polyline((seen.pose.x, seen.pose.y), plan.corners) < 0.12
        if controller.activity is Activity.ARRIVED:
            break
        simulation.step()
    assert controller.activity is Activity.ARRIVED
    end, goal = seen.pose, plan.poses[-1]
    assert end.distance_to(goal) < 0.025
    assert abs(wrap_angle(end.yaw - goal.yaw)) < math.radians(2.5)
    assert (simulation.contacts_seen, simulation.has_fallen) == (set(), False)


@pytest.mark.parametrize('kind', ['free', 'stuck'])
def test_a_failed_joint_gives_no_torque_or_holds_its_angle_until_a_reset(make, kind):
    simulator = make()
    # Without its pitch drive a leg gives way, and is no help.
    pitch = ROBOT.joint_index('lf_hip_pitch_joint')
    step(simulator, 0.5)
    simulator.fail_joint(pitch, kind)
    squat = POSTURE.copy()
    squat[1::3], squat[2::3] = -0.15, 1.72
    for _ in range(100):
        simulator.step(squat, np.zeros(12))
    seen = simulator.observe()
    if kind == 'free':
        assert seen.joint_efforts[pitch] == 0.0
    else:
        assert seen.joint_positions[pitch] == pytest.approx(0.0, abs=0.02)
        assert seen.joint_efforts[pitch] != 0.0
    assert seen.joint_positions[pitch + 3] == pytest.approx(-0.15, abs=0.02)
    simulator.reset(ORIGIN)
    for _ in range(100):
        simulator.step(squat, np.zeros(12))
    seen = simulator.observe()
    assert seen.joint_positions == pytest.approx(squat, abs=0.02)
    assert tilt_from_quaternion(seen.orientation) < 0.01
