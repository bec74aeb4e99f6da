"""Laws of what MuJoCo's dry friction drives toward: motors, and the anchors of contacts."""

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_sim.world.world import Obstacle, world_from_map

pytest.importorskip('mujoco')

from quad_sim.engines import mujoco_drives
from quad_sim.engines.mujoco_simulator import MujocoSimulator

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
STILL = np.zeros(12)
FEET = ROBOT.foot_positions(ROBOT.initial_joint_angles)


def over_standing_feet(sway):
    """Joint angles by which the body is displaced by so much over its feet."""
    return ROBOT.joint_angles(FEET - sway).reshape(-1)


# The body sways to and fro, so that the feet are pulled at.
ROCKING = [over_standing_feet([0.01 * np.sin(0.03 * k), 0.0, 0.0]) for k in range(300)]


@pytest.fixture
def make():
    made = []

    def make_one(friction=0.8):
        made.append(MujocoSimulator(ROBOT, world_from_map(None, friction=friction)))
        return made[-1]

    yield make_one
    for simulator in made:
        simulator.close()


def rock(simulator, commands=ROCKING):
    states = []
    for command in commands:
        simulator.step(command, STILL)
        seen = simulator.observe()
        states.append(np.concatenate([seen.position, seen.orientation, seen.joint_efforts]))
    return np.array(states)


def largest(creeps):
    return max(float(np.abs(creep).max()) for creep in creeps.values())


def test_each_standing_foot_is_anchored_and_gives_by_a_seventh_of_a_millimeter(make):
    simulator = make()
    rock(simulator)
    assert len(simulator.drives.creeps) == 4
    assert 1e-9 < largest(simulator.drives.creeps) < 1.5e-4


def test_a_reset_forgets_all_anchors(make):
    simulator = make()
    rock(simulator)
    simulator.reset(Pose2D(0.0, 0.0, 0.0))
    assert simulator.drives.creeps == {}
    assert (rock(simulator) == rock(make())).all()


def test_the_anchor_of_a_foot_that_is_lifted_is_gone_and_the_others_stay(make):
    simulator = make()
    rock(simulator)
    before = simulator.drives.creeps
    feet = FEET.copy()
    feet[0, 2] += 0.03
    # On three feet it would fall over if the body were not above them.
    feet += [0.04, 0.04, 0.0]
    rock(
        simulator, [over_standing_feet([-0.04 * k / 100, -0.04 * k / 100, 0.0]) for k in range(100)]
    )
    rock(simulator, [ROBOT.joint_angles(feet).reshape(-1)] * 100)
    after = simulator.drives.creeps
    assert len(after) == 3
    assert set(after) < set(before)
    # Put down again the foot is anchored anew, where it is.
    rock(simulator, [POSTURE] * 100)
    assert set(simulator.drives.creeps) == set(before)


def test_contacts_stiffen_while_they_last_and_feet_rise_out_of_the_ground(make):
    simulator = make()
    depths = []
    for _ in range(round(10.0 / simulator.time_step)):
        simulator.step(POSTURE, STILL)
        depths.append(-simulator._data.contact.dist.mean() if simulator._data.ncon else 0.0)
    settled, later = depths[round(0.5 / simulator.time_step)], depths[-1]
    # Under the same load they are 3.5 times as stiff in the end.
    assert later < 0.5 * settled
    assert later > 0.2 * settled
    assert simulator._data.ncon == 4


def test_an_anchor_of_a_foot_that_slips_follows_it(make):
    simulator = make(friction=0.2)
    rock(simulator, [POSTURE] * 100)
    # The whole robot slides.
    simulator._data.qvel[0] = 1.0
    pulls = []
    for _ in range(30):
        simulator.step(POSTURE, STILL)
        pulls += [float(np.abs(creep).max()) for creep in simulator.drives.creeps.values()]
    assert 9e-4 < max(pulls) < 1.5001e-3


def test_an_obstacle_that_comes_leaves_the_feet_standing(make):
    simulator = make()
    rock(simulator)
    before = rock(simulator, ROCKING[-1:] * 50)[-1]
    simulator.put_obstacle('box', Obstacle('box', Pose2D(2.0, 0.0, 0.0), 0.2, 0.2, 0.2))
    simulator.step(ROCKING[-1], STILL)
    assert np.abs(simulator.observe().position - before[:3]).max() < 1e-6
    rock(simulator)
    assert len(simulator.drives.creeps) == 4


def test_a_motor_goes_most_of_the_way_to_the_velocity_that_is_wanted_in_one_step(make):
    simulator = make()
    rock(simulator, [POSTURE] * 100)
    wanted = np.linspace(-0.2, 0.2, 12)
    angles = simulator.observe().joint_positions
    simulator.step(angles, wanted)
    assert simulator.observe().joint_velocities == pytest.approx(2.0 / 2.75 * wanted, abs=8e-3)


def test_no_motor_gives_more_than_its_largest_torque(make):
    simulator = make()
    efforts = [np.abs(rock(simulator, [POSTURE + far] * 3)[:, 7:]) for far in (0.5, -1.0, 30.0)]
    limit = ROBOT.effort.reshape(-1) * (1.0 + 1e-9)
    assert (np.concatenate(efforts) <= limit).all()
    assert (np.concatenate(efforts).max(axis=0) > 0.99 * limit).any()


@pytest.mark.parametrize('bad', [np.nan, np.inf, -np.inf])
def test_a_command_that_is_no_number_is_refused_and_changes_nothing(make, bad):
    simulator, other = make(), make()
    rock(simulator, ROCKING[:50])
    for joint, values in ((3, (POSTURE, STILL)), (11, (STILL, POSTURE))):
        broken = values[0].copy()
        broken[joint] = bad
        arguments = (broken, STILL) if values[0] is POSTURE else (POSTURE, broken)
        with pytest.raises(ParameterError, match='finite'):
            simulator.step(*arguments)
    rock(other, ROCKING[:50])
    assert (rock(simulator) == rock(other)).all()


def test_the_motors_are_the_first_constraints(make):
    simulator = make()
    rock(simulator, [POSTURE])
    efforts = simulator.observe().joint_efforts
    assert simulator.motors.efforts() == pytest.approx(efforts)
    assert efforts.shape == (12,)


def test_a_simulator_compiles_its_loops_before_the_first_step_and_none_later(make):
    simulator = make()
    loops = (mujoco_drives.aim_motors, mujoco_drives.pull_contacts)
    ready = [len(loop.signatures) for loop in loops]
    assert min(ready) > 0
    rock(simulator)
    simulator.put_obstacle('box', Obstacle('box', Pose2D(2.0, 0.0, 0.0), 0.2, 0.2, 0.2))
    rock(simulator)
    assert [len(loop.signatures) for loop in loops] == ready


def test_edges_of_contacts_are_pulled_back_by_how_they_crept_and_out_of_the_ground():
    gain, slip, part, stiffest = laws = np.array([-50.0, 9.0, 0.01, -400.0])
    velocities = np.array([7.0, 0.1, 0.04, 5.0, -5.0])
    distances = np.array([7.0, -0.002, -0.002, -0.001, -0.001])
    contacts = np.array([[1.0, -1.0, 0.0, 0.0], [-100.0, -100.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]])
    references, before = np.ones(5), contacts.copy()
    mujoco_drives.pull_contacts(velocities, distances, references, np.array([3.0]), contacts, laws)
    creep = before[0, 0] + gain * (velocities[1] - velocities[2])
    # The two that are new were not there while their feet came down.
    assert contacts[0] == pytest.approx([creep, -creep, 0.0, 0.0])
    stiffened = before[1] + part * (stiffest - before[1])
    assert contacts[1] == pytest.approx(stiffened)
    assert not contacts[2].any()
    pulls = contacts[0] + stiffened * distances[1:]
    assert references == pytest.approx([4.0, *(1.0 + pulls)])
    mujoco_drives.pull_contacts(velocities, distances, references, np.array([3.0]), contacts, laws)
    # By then they creep, and no anchor pulls by more than it may.
    assert contacts[0, 2:].tolist() == [-slip, slip]
