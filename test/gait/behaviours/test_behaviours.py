"""Each behaviour of a sound robot, by itself."""

import numpy as np
import pytest
from told_supervisor import measurement, shared_for

from quad_common.errors import FootholdNotFound
from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, Twist2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, Command, Done
from quad_gait.behaviours.cycle_walk import CycleWalk
from quad_gait.behaviours.sit import Sit
from quad_gait.behaviours.stand_up import StandUp
from quad_gait.behaviours.standing import Standing
from quad_gait.behaviours.uneven_walk import UnevenWalk
from quad_gait.behaviours.wishes import FollowPlan, HoldPlan, Steer, UseHeightMap
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.posture import crouching_joint_angles
from quad_gait.following.step import Step
from quad_gait.state.state_estimator import StateEstimator
from quad_gait.uneven.uneven_options import UnevenOptions

ROBOT = load_robot('titan_viii')
AHEAD = Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0)
STEP = Step(is_turn=False, motion=BodyMotion(forward=0.05))
FAR = Step(is_turn=False, motion=BodyMotion(forward=9.0))
TO_STANDING = Done(Activity.STANDING)


def state(time, robot=ROBOT, estimator=None, **changes):
    return (estimator or StateEstimator(robot)).judge(measurement(robot, time, **changes))


@pytest.fixture
def shared():
    return shared_for(ROBOT)


# Standing


def test_standing_hands_over_to_a_walk_with_the_step_to_take(shared):
    standing = Standing(shared)
    assert standing.update(state(1.0)) is GO_ON
    assert shared.report.activity is Activity.STANDING
    shared.guidance.take_plan(FollowPlan(AHEAD), '')
    outcome = standing.update(state(1.1))
    assert outcome.next is Activity.WALKING
    assert outcome.step.motion.forward > 0.0


def test_standing_waits_until_the_last_motion_has_settled(shared):
    standing = Standing(shared)
    shared.guidance.take_plan(FollowPlan(AHEAD), '')
    shared.joints.busy_until = 2.0
    assert standing.update(state(2.19)) is GO_ON
    assert standing.update(state(2.21)).next is Activity.WALKING


def test_standing_lets_a_plan_wait_for_a_reason(shared):
    standing = Standing(shared)
    shared.guidance.take_plan(FollowPlan(AHEAD), '')
    shared.guidance.plan_waits_for = HoldPlan('the planner is gone').reason
    assert standing.update(state(1.0)) is GO_ON
    assert shared.report.activity is Activity.WAITING
    assert shared.report.reason == 'the planner is gone'


@pytest.mark.parametrize('is_to_sit', [False, True])
def test_out_of_its_posture_a_robot_that_is_still_takes_it(shared, is_to_sit):
    standing = Standing(shared)
    shared.guidance.is_to_sit = is_to_sit
    joints = ROBOT.initial_joint_angles.reshape(-1) + 0.2
    times = np.arange(1.0, 1.6, 0.02)
    outcomes = [standing.update(state(time, joint_positions=joints)) for time in times]
    assert outcomes[0] is GO_ON
    assert outcomes[-1].next is (Activity.SITTING_DOWN if is_to_sit else Activity.STANDING_UP)


# Postures


@pytest.mark.parametrize('name', available_robots())
@pytest.mark.parametrize('behaviour', [StandUp, Sit])
def test_a_posture_is_taken_from_anywhere_and_at_rest(name, behaviour):
    robot = load_robot(name)
    shared = shared_for(robot)
    taking = behaviour(shared)
    joints = np.clip(robot.initial_joint_angles + 0.3, robot.lower, robot.upper).reshape(-1)
    trajectory = taking.begin(state(1.0, robot, joint_positions=joints), Done()).trajectory
    wanted = robot.initial_joint_angles
    if behaviour is Sit:
        wanted = crouching_joint_angles(robot)
    assert trajectory.positions[0] == pytest.approx(joints)
    assert trajectory.positions[-1] == pytest.approx(wanted.reshape(-1))
    assert not np.any(trajectory.velocities[[0, -1]])
    assert taking.update(state(trajectory.end, robot)) is GO_ON
    assert taking.update(state(trajectory.end + 0.21, robot)) == TO_STANDING


def test_who_has_sat_stands_up_to_the_initial_posture(shared):
    shared.joints.posture = ROBOT.initial_joint_angles + 0.1
    Sit(shared).begin(state(1.0), Done())
    assert np.array_equal(shared.joints.posture, ROBOT.initial_joint_angles)


# Walking by cycles


def test_a_cycle_walk_begins_and_is_done_when_its_cycle_has_settled(shared):
    walk = CycleWalk(shared)
    assert walk.footholds().shape == (0, 3)
    trajectory = walk.begin(state(1.0), Done(Activity.WALKING, STEP)).trajectory
    assert shared.report.activity is Activity.WALKING
    assert walk.footholds().shape == (4, 3)
    assert walk.update(state(trajectory.end - 0.1)) is GO_ON
    assert walk.update(state(trajectory.end + 0.21)) == TO_STANDING


def test_feet_are_in_contact_as_the_cycle_has_them(shared):
    walk = CycleWalk(shared)
    trajectory = walk.begin(state(1.0), Done(Activity.WALKING, STEP)).trajectory
    times = np.linspace(trajectory.stamp, trajectory.end, 50)
    counts = [int(walk.in_contact_at(time).sum()) for time in times]
    assert set(counts) == {3, 4}
    walk.forget()
    assert walk.in_contact_at(times[25]).all()


def test_a_walk_that_cannot_begin_says_so_and_is_done(shared, monkeypatch):
    walk = CycleWalk(shared)
    monkeypatch.setattr(walk._planner, 'begin', failing)
    assert walk.begin(state(1.0), Done(Activity.WALKING, FAR)) is GO_ON
    assert (shared.report.activity, shared.report.reason) == (Activity.STOPPED, str(NO_FOOTHOLD))
    assert walk.update(state(1.1)) == TO_STANDING


NO_FOOTHOLD = FootholdNotFound('lf', 0.1)


def failing(*_):
    raise NO_FOOTHOLD


def test_a_gait_that_keeps_its_speed_goes_on_and_stops_when_nothing_is_wanted():
    shared = shared_for(ROBOT, 'trot')
    walk, estimator = CycleWalk(shared), StateEstimator(ROBOT)
    now = state(1.0, estimator=estimator)
    shared.guidance.take_steering(Steer(Twist2D(0.05)), now.time, '')
    step = shared.guidance.next_at_rest(now, is_ready=True)
    assert walk.begin(now, Done(Activity.WALKING, step)).trajectory is not None
    given, time = 0, 1.0
    for _ in range(1500):
        time += 0.02
        outcome = walk.update(state(time, estimator=estimator))
        if isinstance(outcome, Done):
            break
        given += outcome.trajectory is not None
    # Steering lasts for a second.
    assert given >= 1
    assert outcome == TO_STANDING
    assert not walk.come_to_rest(state(time))


# Walking on uneven ground


def test_an_uneven_walk_swings_from_where_the_feet_stand_and_remembers_how_they_do():
    shared = shared_for(ROBOT, uneven=UnevenOptions())
    walk = UnevenWalk(shared)
    walk.take(UseHeightMap(None))
    outcome = walk.begin(state(1.0), Done(Activity.WALKING, STEP))
    assert isinstance(outcome, Command)
    assert outcome.trajectory is not None
    assert walk.footholds().shape == (4, 3)
    ahead = walk.footholds()[:, :2] - Pose2D(0.05, 0.0, 0.0).transform(ROBOT.neutral_feet)[:, :2]
    assert ahead == pytest.approx(np.zeros((4, 2)))
    walk.forget()
    assert walk.footholds().shape == (0, 3)
    assert walk.in_contact_at(1.0).all()


def test_a_correction_of_odometry_is_taken_off_the_shift_of_the_map_before_the_next_stride():
    shared = shared_for(ROBOT, uneven=UnevenOptions())
    walk, felt = UnevenWalk(shared), shared.guidance.felt
    at, moved = Pose2D(0.0, 0.0, 0.0), Pose2D(0.07, 0.0, 0.0)
    walk.begin(state(1.0).placed(at, at), Done(Activity.WALKING, STEP))
    felt.map_shift = np.array([0.10, 0.0])
    walk.begin(state(2.0).placed(at, at), Done(Activity.WALKING, STEP))
    assert felt.map_shift == pytest.approx([0.10, 0.0])
    walk.begin(state(3.0).placed(moved, at), Done(Activity.WALKING, STEP))
    assert felt.map_shift == pytest.approx([0.03, 0.0])


def test_footsteps_are_planned_over_the_map_where_feet_say_that_it_lies():
    shared = shared_for(ROBOT, uneven=UnevenOptions(plans_footsteps=True))
    walk = UnevenWalk(shared)
    heights = HeightMap.level((-1.0, -1.0, 1.0, 1.0), 0.05)
    walk.take(UseHeightMap(heights))
    walk.begin(state(1.0), Done(Activity.WALKING, STEP))
    assert walk._route._map.heights is heights
    shared.guidance.felt.map_shift = np.array([0.10, 0.0])
    walk.begin(state(2.0), Done(Activity.WALKING, STEP))
    assert walk._route._map.heights.origin == pytest.approx((-1.10, -1.0))
    known = walk._route._map
    walk.begin(state(3.0), Done(Activity.WALKING, STEP))
    assert walk._route._map is known


def test_ground_that_is_not_found_ends_the_stride_and_is_said(monkeypatch):
    shared = shared_for(ROBOT, uneven=UnevenOptions())
    walk = UnevenWalk(shared)
    walk.begin(state(1.0), Done(Activity.WALKING, STEP))
    monkeypatch.setattr(walk._stride, 'update', failing)
    end = walk._stride.joint_positions
    assert walk.update(state(1.1)) is GO_ON
    assert shared.report.activity is Activity.STOPPED
    assert np.array_equal(shared.joints.posture, end)
