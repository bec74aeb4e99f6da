"""A robot that does what it is told, more or less, arrives."""

import math
from itertools import pairwise

import numpy as np
import pytest

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline, wrap_angle
from quad_common.robot import load_robot
from quad_gait.path_follower import FollowerOptions, GoalNotReached, LeftPath, PathFollower

ROBOT = load_robot('titan_viii')
OPTIONS = FollowerOptions(largest_stride=ROBOT.largest_stride, largest_turn=ROBOT.largest_turn)

CORNER = Plan.through([[0.0, 0.0], [2.0, 0.0], [2.0, 1.5]], math.pi / 2)


def walk(plan, pose, rng=None, noise=(0.0, 0.0), options=OPTIONS, most=200):
    """Walk until the follower is content; return the steps and the poses between them."""
    follower = PathFollower(options)
    follower.follow(plan, pose)
    steps, poses = [], [pose]
    while (step := follower.next_step(pose)) is not None:
        assert len(steps) < most, 'the robot does not arrive'
        end = step.motion.end
        if rng is not None:
            slip = rng.standard_normal(3) * (noise[0], noise[0], noise[1])
            end = end @ Pose2D(*slip)
        pose = pose @ end
        steps.append(step)
        poses.append(pose)
    return steps, poses


def assert_arrived(plan, pose, options=OPTIONS):
    goal = plan.poses[-1]
    assert pose.distance_to(goal) <= options.position_tolerance + 1e-9
    assert abs(wrap_angle(pose.yaw - goal.yaw)) <= options.heading_tolerance + 1e-9


def turns_and_strides(steps):
    return sum(step.is_turn for step in steps), sum(not step.is_turn for step in steps)


def random_plan(rng):
    """Draw a plan of a few segments from the origin."""
    corners = [np.zeros(2)]
    for _ in range(rng.integers(1, 5)):
        angle, length = rng.uniform(-math.pi, math.pi), rng.uniform(0.5, 2.0)
        corners.append(corners[-1] + length * np.array([math.cos(angle), math.sin(angle)]))
    return Plan.through(corners, rng.uniform(-math.pi, math.pi))


def test_a_perfect_robot_walks_an_l_in_the_fewest_cycles_there_are():
    steps, poses = walk(CORNER, CORNER.poses[0])
    assert_arrived(CORNER, poses[-1])
    # 2 m are nine strides of at most 226 mm, 1.5 m are seven; 90 degrees are three turns.
    assert turns_and_strides(steps) == (3, 9 + 7)


def test_a_perfect_robot_stays_on_any_plan_and_arrives():
    rng = np.random.default_rng(1)
    for _ in range(100):
        plan = random_plan(rng)
        _, poses = walk(plan, Pose2D(0.0, 0.0, rng.uniform(-math.pi, math.pi)))
        assert_arrived(plan, poses[-1])
        for pose in poses:
            assert distance_to_polyline((pose.x, pose.y), plan.corners) < 0.021


def test_a_robot_that_slips_arrives_within_the_tolerances_all_the_same():
    rng = np.random.default_rng(2)
    for _ in range(100):
        plan = random_plan(rng)
        start = Pose2D(0.0, 0.0, rng.uniform(-math.pi, math.pi))
        _, poses = walk(plan, start, rng, noise=(0.005, 0.008))
        assert_arrived(plan, poses[-1])
        for pose in poses:
            assert distance_to_polyline((pose.x, pose.y), plan.corners) < 0.06


@pytest.mark.parametrize('drift', [0.9, 1.1])
@pytest.mark.parametrize('veer', [-0.04, 0.04])
def test_a_robot_that_always_errs_the_same_way_arrives(drift, veer):
    follower, pose = PathFollower(OPTIONS), CORNER.poses[0]
    follower.follow(CORNER, pose)
    for _ in range(100):
        step = follower.next_step(pose)
        if step is None:
            break
        end = step.motion.end
        pose = pose @ Pose2D(drift * end.x, drift * end.y, drift * end.yaw + veer * abs(end.x))
        assert distance_to_polyline((pose.x, pose.y), CORNER.corners) < 0.06
    assert step is None
    assert_arrived(CORNER, pose)


@pytest.mark.parametrize(
    ('degrees', 'cycles'),
    [(15, 1), (44, 1), (45, 2), (-45, 2), (88, 2), (90, 3), (-90, 3), (135, 4), (-179, 5)],
)
def test_a_turn_takes_as_few_cycles_as_44_degrees_each_allow(degrees, cycles):
    plan = Plan((Pose2D(1.0, 2.0, math.radians(degrees)),))
    steps, poses = walk(plan, Pose2D(1.0, 2.0, 0.0))
    assert turns_and_strides(steps) == (cycles, 0)
    assert_arrived(plan, poses[-1])


@pytest.mark.parametrize('heading', [math.pi, -math.pi, 3.1, -3.1, 0.0])
def test_headings_are_compared_on_the_circle(heading):
    # Walking towards -x, where headings jump from pi to -pi.
    goal = Pose2D(-2.0 * abs(math.cos(heading)), 0.0, heading)
    plan = Plan.through([[0.0, 0.0], [-2.0, 0.0]], goal.yaw)
    for start in (3.13, -3.13, math.pi, -math.pi):
        steps, poses = walk(plan, Pose2D(0.0, 0.0, start))
        assert_arrived(plan, poses[-1])
        turned = sum(abs(step.motion.turn) for step in steps)
        assert turned < abs(wrap_angle(heading - math.pi)) + 0.1
    assert heading == 0.0 or turns_and_strides(steps)[0] == 0


def test_it_turns_the_shorter_way():
    for start, heading, sign in ((3.0, -3.0, 1), (-3.0, 3.0, -1), (0.2, 1.5, 1), (0.2, -1.5, -1)):
        steps, _ = walk(Plan((Pose2D(0.0, 0.0, heading),)), Pose2D(0.0, 0.0, start))
        assert steps
        assert all(sign * step.motion.turn > 0.0 for step in steps)


def test_no_cycle_asks_for_more_than_the_gait_can_do():
    rng = np.random.default_rng(3)
    for _ in range(100):
        plan = random_plan(rng)
        start = Pose2D(0.0, 0.0, rng.uniform(-math.pi, math.pi))
        for step in walk(plan, start, rng, noise=(0.01, 0.02))[0]:
            end = step.motion.end
            if step.is_turn:
                assert abs(end.yaw) <= OPTIONS.largest_turn + 1e-9
                assert max(abs(end.x), abs(end.y)) <= OPTIONS.largest_correction + 1e-9
            else:
                length = math.hypot(end.x, end.y)
                assert length <= math.hypot(OPTIONS.largest_stride, OPTIONS.largest_correction)
                assert abs(end.yaw) <= OPTIONS.turn_threshold + 1e-9


def test_the_strides_of_a_straight_segment_are_equal():
    steps, _ = walk(Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0), Pose2D(0.0, 0.0, 0.0))
    assert [step.motion.forward for step in steps] == pytest.approx([0.2] * 5)
    assert [step.motion.left for step in steps] == pytest.approx([0.0] * 5)


def test_the_robot_turns_at_the_corner_and_nowhere_else():
    steps, poses = walk(CORNER, CORNER.poses[0])
    for step, pose in zip(steps, poses):
        if step.is_turn:
            assert math.hypot(pose.x - 2.0, pose.y) < OPTIONS.position_tolerance


def test_a_plan_is_joined_at_its_nearest_segment():
    steps, poses = walk(CORNER, Pose2D(2.1, 0.8, math.pi / 2))
    assert turns_and_strides(steps) == (0, math.ceil(0.7 / OPTIONS.largest_stride))
    assert_arrived(CORNER, poses[-1])


def test_a_plan_that_crosses_itself_is_begun_at_its_beginning():
    plan = Plan.through([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 0.0]], math.pi)
    follower = PathFollower(OPTIONS)
    follower.follow(plan, Pose2D(0.0, 0.0, 0.0))
    assert follower.distance_left(Pose2D(0.0, 0.0, 0.0)) == pytest.approx(plan.length)


def test_carried_to_another_segment_the_robot_goes_on_from_there():
    follower = PathFollower(OPTIONS)
    follower.follow(CORNER, Pose2D(0.0, 0.0, 0.0))
    carried = Pose2D(2.0, 1.0, math.pi / 2)
    step = follower.next_step(carried)
    assert not step.is_turn
    assert follower.distance_left(carried) == pytest.approx(0.5)


@pytest.mark.parametrize('pose', [Pose2D(0.5, 0.6, 0.0), Pose2D(2.6, 1.0, 0.0), Pose2D(-3, -4, 0)])
def test_carried_away_the_robot_waits_for_a_new_plan(pose):
    follower = PathFollower(OPTIONS)
    follower.follow(CORNER, Pose2D(0.0, 0.0, 0.0))
    distance = distance_to_polyline((pose.x, pose.y), CORNER.corners)
    with pytest.raises(LeftPath) as caught:
        follower.next_step(pose)
    assert str(caught.value) == (
        f'the robot is {distance:.2f} m from its path; it follows within 0.50 m: '
        'waiting for a new plan'
    )


def test_brought_back_the_robot_goes_on():
    follower = PathFollower(OPTIONS)
    follower.follow(CORNER, Pose2D(0.0, 0.0, 0.0))
    with pytest.raises(LeftPath):
        follower.next_step(Pose2D(0.5, 3.0, 0.0))
    assert follower.next_step(Pose2D(0.5, 0.3, 0.0)) is not None


def test_beside_its_path_but_within_tolerance_the_robot_comes_back_to_it():
    plan = Plan.through([[0.0, 0.0], [3.0, 0.0]], 0.0)
    _, poses = walk(plan, Pose2D(0.0, 0.4, 0.0))
    sides = [abs(pose.y) for pose in poses]
    assert all(after <= before + 1e-12 for before, after in pairwise(sides))
    assert sides[-1] < OPTIONS.position_tolerance
    assert_arrived(plan, poses[-1])


def test_without_a_plan_there_is_nothing_to_do():
    follower = PathFollower(OPTIONS)
    pose = Pose2D(0.0, 0.0, 0.0)
    assert follower.next_step(pose) is None
    assert follower.distance_left(pose) == 0.0
    follower.follow(CORNER, pose)
    assert follower.plan is CORNER
    follower.follow(None, pose)
    assert (follower.plan, follower.next_step(pose)) == (None, None)


def test_at_the_goal_there_is_nothing_to_do():
    plan = Plan((Pose2D(1.0, 1.0, 1.0),))
    assert walk(plan, Pose2D(1.01, 0.99, 1.02))[0] == []


def test_a_plan_of_a_single_pose_is_a_correction_on_the_spot():
    plan = Plan((Pose2D(0.1, -0.1, 2.0),))
    _, poses = walk(plan, Pose2D(0.0, 0.0, -1.0))
    assert_arrived(plan, poses[-1])


def test_the_distance_left_shrinks_to_nothing():
    follower, pose = PathFollower(OPTIONS), CORNER.poses[0]
    follower.follow(CORNER, pose)
    left = [follower.distance_left(pose)]
    assert left == [pytest.approx(CORNER.length)]
    while (step := follower.next_step(pose)) is not None:
        pose = pose @ step.motion.end
        left.append(follower.distance_left(pose))
    assert all(after <= before + 1e-9 for before, after in pairwise(left))
    assert left[-1] <= OPTIONS.position_tolerance


def test_a_robot_that_cannot_correct_its_pose_at_the_goal_says_so_instead_of_trying_forever():
    goal = Pose2D(1.0, 0.0, 0.0)
    follower, stuck = PathFollower(OPTIONS), Pose2D(1.05, 0.0, 0.0)
    follower.follow(Plan((goal,)), stuck)
    for _ in range(OPTIONS.final_cycles):
        assert follower.next_step(stuck) is not None
    with pytest.raises(GoalNotReached, match=r'0\.050 m and 0\.0 degrees off'):
        follower.next_step(stuck)
