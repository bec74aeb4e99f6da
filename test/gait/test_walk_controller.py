"""The controller walks a robot from what it measures, one trajectory after the other."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline, wrap_angle
from quad_common.robot import load_robot
from quad_gait.body_motion import BodyMotion
from quad_gait.gait import load_gait
from quad_gait.gait_generator import generate_cycle
from quad_gait.walk_controller import Activity, ControllerOptions, Measurement, WalkController
from quad_sim.kinematic_simulator import KinematicSimulator
from quad_sim.simulation import Simulation
from quad_sim.simulator import tilt_of

ROBOT = load_robot('titan_viii')
CRAWL, TURN = load_gait('crawl'), load_gait('turn')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
ORIGIN = Pose2D(0.0, 0.0, 0.0)

AHEAD = Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0)
CORNER = Plan.through([[0.0, 0.0], [0.6, 0.0], [0.6, 0.4]], math.pi / 2)


def make_controller(**options):
    return WalkController(ROBOT, CRAWL, TURN, ControllerOptions(**options))


def standing(time, pose=ORIGIN, **changes):
    """What is measured of a robot that stands in its initial posture."""
    measurement = Measurement(time, pose, 0.0, POSTURE.copy(), np.zeros(12))
    return replace(measurement, **changes)


def measured(simulation):
    seen = simulation.observe()
    tilt = tilt_of(seen.orientation)
    return Measurement(seen.time, seen.pose, tilt, seen.joint_positions, seen.joint_velocities)


class Walk:
    """A controller and a simulated robot, with a record of all that happened."""

    def __init__(self, start=ORIGIN, **options):
        simulator = KinematicSimulator(ROBOT, 0.01)
        self.simulation = Simulation(simulator, ROBOT, start)
        self.controller = make_controller(**options)
        self.trajectories = []
        self.told_at = []
        self.activities = []
        self.poses = []

    def step(self):
        now = measured(self.simulation)
        trajectory = self.controller.update(now)
        if trajectory is not None:
            self.simulation.accept(trajectory)
            self.trajectories.append(trajectory)
            self.told_at.append(now.time)
        self.poses.append(now.pose)
        if not self.activities or self.activities[-1] is not self.controller.activity:
            self.activities.append(self.controller.activity)
        self.simulation.step()

    def run(self, until, seconds=200.0):
        """Step until a condition holds."""
        for _ in range(round(seconds / self.simulation.time_step)):
            if until():
                return
            self.step()
        pytest.fail(f'still {self.controller.activity} after {seconds} s')

    def run_for(self, seconds):
        for _ in range(round(seconds / self.simulation.time_step)):
            self.step()

    def arrives(self):
        self.run(lambda: self.controller.activity is Activity.ARRIVED)


@pytest.fixture(scope='module')
def walked():
    """Let the robot walk round a corner."""
    walk = Walk()
    walk.controller.set_plan(CORNER)
    walk.arrives()
    return walk


def test_a_plan_with_a_corner_is_walked_to_its_goal(walked):
    end, goal = walked.poses[-1], CORNER.poses[-1]
    assert end.distance_to(goal) < 0.02
    assert abs(wrap_angle(end.yaw - goal.yaw)) < math.radians(2.0)
    assert walked.controller.reason == 'the goal is reached'
    assert walked.activities[-4:] == [
        Activity.WALKING,
        Activity.TURNING,
        Activity.WALKING,
        Activity.ARRIVED,
    ]


def test_on_the_way_the_body_stays_near_the_path(walked):
    # Sway included: mu = 0.4 of the way to a support triangle's centroid.
    sway = 0.4 * np.abs(ROBOT.neutral_feet[:, 1]).max()
    for pose in walked.poses:
        assert distance_to_polyline((pose.x, pose.y), CORNER.corners) < sway


def test_consecutive_trajectories_join_without_a_jump_or_a_jerk(walked):
    assert len(walked.trajectories) == 3 + 3 + 2
    for before, after in pairwise(walked.trajectories):
        assert before.positions[-1] == pytest.approx(after.positions[0], abs=1e-9)
        assert before.velocities[-1] == pytest.approx(np.zeros(12), abs=1e-9)
        assert after.velocities[0] == pytest.approx(np.zeros(12), abs=1e-9)
        assert before.end <= after.stamp + after.times[0]


def test_a_trajectory_is_given_out_its_lead_time_before_it_moves_anything(walked):
    for told_at, trajectory in zip(walked.told_at, walked.trajectories):
        lead = trajectory.stamp + trajectory.times[0] - told_at
        assert lead >= ControllerOptions().lead_time - 1e-9
        moving = np.flatnonzero(np.abs(trajectory.velocities).max(axis=1) > 1e-6)
        assert trajectory.stamp + trajectory.times[moving[0]] > told_at + 0.3


def test_cycles_follow_each_other_without_a_pause(walked):
    # Cycles of 5 s each, planned from what is measured 0.2 s after the last one's end.
    stamps = [trajectory.stamp for trajectory in walked.trajectories]
    assert np.diff(stamps) == pytest.approx(np.full(len(stamps) - 1, 5.0), abs=1e-9)
    ends = np.array([trajectory.end for trajectory in walked.trajectories[:-1]])
    assert walked.told_at[1:] == pytest.approx(ends + 0.2, abs=0.011)


def test_even_at_the_beginning_of_time_a_trajectory_says_when_it_starts():
    # A stamp of zero means "on arrival", and would put controller and robot out of step.
    controller = make_controller()
    controller.set_plan(AHEAD)
    trajectory = controller.update(standing(0.0))
    assert 0.0 < trajectory.stamp < 0.1
    assert controller.update(standing(trajectory.end + 0.19, AHEAD.poses[0])) is None
    assert controller.update(standing(trajectory.end + 0.21, AHEAD.poses[0])) is not None


@pytest.fixture
def begun():
    """Let a controller begin its first cycle at a pose in the middle of nowhere."""
    controller = make_controller()
    pose = Pose2D(3.0, -2.0, 0.5)
    ahead = pose @ Pose2D(1.0, 0.0, 0.0)
    controller.set_plan(Plan.through([[pose.x, pose.y], [ahead.x, ahead.y]], 0.5))
    trajectory = controller.update(standing(1.0, pose))
    return controller, trajectory.stamp, pose


def test_the_predicted_margin_is_the_cycles_and_positive(begun):
    controller, start, _ = begun
    cycle = controller.cycle
    for k in range(0, len(cycle.times) - 1, 10):
        assert controller.margin_at(start + cycle.times[k]) == cycle.margin[k] > 0.03
    # Between cycles the robot stands on four feet, 402 mm by 602 mm.
    for controller_, time in ((controller, start + 5.0), (make_controller(), 0.0)):
        assert controller_.margin_at(time) == pytest.approx(0.201, abs=1e-6)


def test_the_support_polygon_is_of_the_feet_on_the_ground_in_the_plans_frame(begun):
    controller, start, pose = begun
    swing = CRAWL.swings[0]
    assert len(controller.support_polygon_at(start + swing.liftoff + 0.2, pose)) == 3
    feet = pose.transform(ROBOT.neutral_feet)[:, :2]
    for time in (start, start + 0.5, start + 6.0):
        corners = controller.support_polygon_at(time, pose)
        assert np.sort(corners, axis=0) == pytest.approx(np.sort(feet, axis=0), abs=1e-9)


def test_footholds_are_the_initial_posture_under_the_end_of_the_cycle(begun):
    controller, _, pose = begun
    end = pose @ controller.cycle.motion.end
    feet = end.transform(ROBOT.neutral_feet)[:, :2]
    assert controller.footholds()[:, :2] == pytest.approx(feet, abs=1e-9)
    assert controller.footholds()[:, 2] == pytest.approx(np.full(4, ROBOT.foot_radius))
    assert make_controller().footholds().shape == (0, 3)


def test_after_arrival_the_robot_rests_even_if_it_is_pushed():
    controller = make_controller()
    controller.set_plan(Plan((ORIGIN,)))
    assert controller.update(standing(1.0)) is None
    assert controller.activity is Activity.ARRIVED
    assert controller.update(standing(2.0, Pose2D(0.3, 0.0, 1.0))) is None
    assert controller.activity is Activity.ARRIVED


def test_without_a_plan_the_robot_stands():
    controller = make_controller()
    assert (controller.activity, controller.reason) == (Activity.WAITING, 'no plan yet')
    assert controller.update(standing(1.0)) is None
    assert (controller.activity, controller.reason) == (Activity.STANDING, 'no plan to follow')


def test_without_joint_states_the_robot_waits():
    controller = make_controller()
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.0, joint_positions=None, joint_velocities=None)) is None
    assert (controller.activity, controller.reason) == (Activity.WAITING, 'no joint states yet')
    assert controller.update(standing(1.1)) is not None


def test_while_the_joints_move_the_robot_waits():
    controller = make_controller()
    controller.set_plan(AHEAD)
    speeds = np.zeros(12)
    speeds[5] = 0.3
    assert controller.update(standing(1.0, joint_velocities=speeds)) is None
    assert controller.reason == 'the joints are still moving'
    assert controller.update(standing(1.1)) is not None


@pytest.mark.parametrize('tilt', [0.6, math.pi / 2])
def test_a_tilted_robot_has_fallen_and_is_told_to_hold_its_joints_and_nothing_more(tilt):
    controller = make_controller()
    controller.set_plan(AHEAD)
    held = controller.update(standing(1.0, tilt=tilt))
    assert held.positions == pytest.approx(POSTURE[None])
    assert not held.velocities.any()
    assert controller.update(standing(1.02, tilt=tilt)) is None
    assert controller.activity is Activity.FALLEN
    assert f'tilted by {math.degrees(tilt):.0f} degrees' in controller.reason


def test_a_fall_in_mid_cycle_is_noticed_at_once():
    controller = make_controller()
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.0)) is not None
    assert controller.update(standing(2.0, tilt=0.1)) is None
    assert controller.activity is Activity.WALKING
    assert controller.update(standing(2.1, tilt=1.0)).positions == pytest.approx(POSTURE[None])
    assert controller.activity is Activity.FALLEN
    # Put upright again it does not walk off by itself.
    assert controller.update(standing(3.0)) is None
    assert controller.activity is Activity.FALLEN
    controller.stand()
    controller.update(standing(4.0))
    assert controller.activity is Activity.STANDING


def test_out_of_its_posture_the_robot_stands_up_smoothly_before_it_walks():
    offset = np.random.default_rng(1).uniform(-0.4, 0.4, 12)
    controller = make_controller()
    controller.set_plan(AHEAD)
    lying = POSTURE + offset
    # It might be in the middle of a cycle that another node began: first it must be still.
    assert controller.update(standing(1.0, joint_positions=lying)) is None
    assert controller.update(standing(1.4, joint_positions=lying)) is None
    trajectory = controller.update(standing(1.5, joint_positions=lying))
    assert controller.activity is Activity.STANDING_UP
    assert f'{np.abs(offset).max():.2f} rad from the initial posture' in controller.reason
    assert trajectory.positions[0] == pytest.approx(POSTURE + offset)
    assert trajectory.positions[-1] == pytest.approx(POSTURE)
    assert trajectory.velocities[[0, -1]] == pytest.approx(np.zeros((2, 12)), abs=1e-12)
    h = np.diff(trajectory.times)[:, None]
    means = (trajectory.velocities[1:] + trajectory.velocities[:-1]) / 2.0
    assert np.diff(trajectory.positions, axis=0) / h == pytest.approx(means, abs=1e-3)
    assert controller.update(standing(trajectory.end)) is None
    walking = controller.update(standing(trajectory.end + 0.2))
    assert controller.activity is Activity.WALKING
    assert walking.stamp + walking.times[0] >= trajectory.end + 0.5 - 1e-9


def test_within_the_tolerance_of_its_posture_the_robot_walks_at_once():
    controller = make_controller()
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.0, joint_positions=POSTURE + 0.14)) is not None
    assert controller.activity is Activity.WALKING


def test_a_new_plan_takes_effect_at_the_end_of_the_cycle():
    walk = Walk()
    walk.controller.set_plan(AHEAD)
    walk.run(lambda: len(walk.trajectories) == 1)
    walk.run_for(2.0)
    walk.controller.set_plan(Plan((Pose2D(0.2, 0.0, math.pi / 2),)))
    walk.run_for(2.0)
    assert (len(walk.trajectories), walk.controller.activity) == (1, Activity.WALKING)
    walk.run(lambda: len(walk.trajectories) == 2, 2.0)
    assert walk.controller.activity is Activity.TURNING
    assert walk.trajectories[1].stamp == pytest.approx(walk.trajectories[0].end)
    walk.arrives()
    assert walk.poses[-1].yaw == pytest.approx(math.pi / 2, abs=math.radians(2.0))


def test_taking_the_plan_back_stops_the_robot_at_the_end_of_the_cycle():
    walk = Walk()
    walk.controller.set_plan(AHEAD)
    walk.run(lambda: len(walk.trajectories) == 1)
    walk.run_for(1.0)
    walk.controller.set_plan(None)
    walk.run_for(8.0)
    assert len(walk.trajectories) == 1
    assert (walk.controller.activity, walk.controller.reason) == (
        Activity.STANDING,
        'no plan to follow',
    )
    assert measured(walk.simulation).joint_positions == pytest.approx(POSTURE, abs=1e-9)
    assert walk.controller.distance_left(walk.poses[-1]) == 0.0


def test_a_new_plan_after_arrival_is_walked():
    controller = make_controller()
    controller.set_plan(Plan((ORIGIN,)))
    controller.update(standing(1.0))
    controller.set_plan(AHEAD)
    assert controller.update(standing(2.0)) is not None
    assert controller.activity is Activity.WALKING


def test_when_the_clock_is_set_back_the_robot_does_not_wait_for_the_old_time():
    controller = make_controller()
    controller.set_plan(AHEAD)
    assert controller.update(standing(1000.0)) is not None
    assert controller.update(standing(1001.0)) is None
    trajectory = controller.update(standing(3.0))
    assert trajectory is not None
    assert 3.0 + 0.3 <= trajectory.stamp + trajectory.times[0] + 1e-9 < 4.0


def test_a_robot_carried_away_stops_and_says_why():
    controller = make_controller()
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.0)) is not None
    assert controller.update(standing(6.5, Pose2D(0.5, 2.0, 0.0))) is None
    assert controller.activity is Activity.STOPPED
    assert 'the robot is 2.00 m from its path' in controller.reason
    assert controller.update(standing(7.0, Pose2D(0.5, 0.0, 0.0))) is not None
    assert controller.activity is Activity.WALKING


def test_a_margin_that_cannot_be_had_stops_the_robot_with_the_numbers():
    controller = make_controller(least_margin=0.5)
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.0)) is None
    assert controller.activity is Activity.STOPPED
    assert 'it must be at least 500.0 mm' in controller.reason


@pytest.mark.parametrize('follows', [0.0, 0.2, 0.5, 1.0])
def test_a_robot_that_does_not_follow_its_commands_is_blocked_after_three_cycles(follows):
    controller, pose, time = make_controller(), ORIGIN, 1.0
    controller.set_plan(Plan.through([[0.0, 0.0], [5.0, 0.0]], 0.0))
    cycles = 0
    while cycles < 5:
        trajectory = controller.update(standing(time, pose))
        if trajectory is None:
            break
        cycles += 1
        pose = pose @ Pose2D(follows * controller.cycle.motion.forward, 0.0, 0.0)
        time = trajectory.end + 0.2
    if follows > 0.3:
        assert controller.activity is Activity.WALKING
        return
    assert (cycles, controller.activity) == (3, Activity.BLOCKED)
    assert '3 cycles without effect' in controller.reason
    assert controller.update(standing(time + 1.0, pose)) is None
    assert controller.activity is Activity.BLOCKED
    controller.set_plan(AHEAD)
    assert controller.update(standing(time + 2.0)) is not None


@pytest.mark.parametrize('side', [1, -1])
def test_turns_to_the_right_mirror_turns_to_the_left(side):
    controller = make_controller()
    controller.set_plan(Plan((Pose2D(0.0, 0.0, side * 0.7),)))
    trajectory = controller.update(standing(1.0))
    gait = controller.cycle.gait
    if side > 0:
        assert gait == TURN
    else:
        left = generate_cycle(ROBOT, TURN, BodyMotion(turn=0.7))
        assert controller.cycle.least_margin == pytest.approx(left.least_margin, rel=0.05)
    expected = generate_cycle(ROBOT, gait, controller.cycle.motion).trajectory(ROBOT, 0.0)
    assert trajectory.positions == pytest.approx(expected.positions, abs=1e-12)
    assert controller.reason == f'turning by {math.degrees(side * 0.7):.1f} degrees'


@pytest.mark.parametrize('lead', [0.0, 0.3, 2.0])
def test_a_longer_lead_time_delays_the_cycle_as_far_as_it_must(lead):
    controller = make_controller(lead_time=lead)
    controller.set_plan(AHEAD)
    trajectory = controller.update(standing(10.0))
    assert trajectory.stamp + trajectory.times[0] == pytest.approx(10.0 + lead)
