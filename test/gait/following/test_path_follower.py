"""A robot that does what it is told, more or less, arrives."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest

from quad_common.errors import CannotFollow, GoalNotReached, LeftPath, ParameterError
from quad_common.plan import Plan
from quad_common.planar_pose import STILL, Pose2D, distance_to_polyline, wrap_angle
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.follower_options import TURNINGS, FollowerOptions
from quad_gait.following.path_follower import PathFollower
from quad_gait.following.reference_path import circle_pieces, rounded_pieces, straight_pieces
from quad_gait.following.step import advance

ROBOT = load_robot('titan_viii')


@dataclass(frozen=True)
class Gear:
    """A gait of which a motion takes its fraction of the largest stride and turn."""

    stride: float = ROBOT.largest_stride
    turn: float = ROBOT.largest_turn
    is_steady: bool = False
    period: float = 5.0
    acceleration_fraction: float = 0.5

    def reason(self, motion):
        return 'made up'

    def possible_part(self, motion):
        return min(1.0, self.largest_scale(motion))

    def largest_scale(self, motion):
        return 1.0 / (
            math.hypot(motion.forward, motion.left) / self.stride + abs(motion.turn) / self.turn
        )


CRAWL = Gear()
WAVE = Gear(is_steady=True)
OPTIONS = FollowerOptions()

CORNER = Plan.through([[0.0, 0.0], [2.0, 0.0], [2.0, 1.5]], math.pi / 2)


def walk(plan, pose, rng=None, noise=(0.0, 0.0), options=OPTIONS, most=400, gear=CRAWL):
    """Walk until the follower is content; return the steps and the poses between them."""
    follower = PathFollower(gear, gear, options)
    follower.follow(plan, pose)
    steps, poses, entry = [], [pose], STILL
    while (step := follower.next_step(pose, entry)) is not None:
        assert len(steps) < most, 'the robot does not arrive'
        end = step.motion.end
        if rng is not None:
            slip = rng.standard_normal(3) * (noise[0], noise[0], noise[1])
            end = end @ Pose2D(*slip)
        pose = pose @ end
        entry = step.exit
        steps.append(step)
        poses.append(pose)
    assert not entry, 'the robot arrives in full walk'
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
    follower, pose = PathFollower(CRAWL, CRAWL, OPTIONS), CORNER.poses[0]
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
                assert abs(end.yaw) <= CRAWL.turn + 1e-9
                assert max(abs(end.x), abs(end.y)) <= OPTIONS.largest_correction + 1e-9
            else:
                length = math.hypot(end.x, end.y)
                assert length <= math.hypot(CRAWL.stride, OPTIONS.largest_correction)
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
    assert turns_and_strides(steps) == (0, math.ceil(0.7 / CRAWL.stride))
    assert_arrived(CORNER, poses[-1])


def test_a_plan_that_crosses_itself_is_begun_at_its_beginning():
    plan = Plan.through([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 0.0]], math.pi)
    follower = PathFollower(CRAWL, CRAWL, OPTIONS)
    follower.follow(plan, Pose2D(0.0, 0.0, 0.0))
    assert follower.distance_left(Pose2D(0.0, 0.0, 0.0)) == pytest.approx(plan.length)


def test_carried_to_another_segment_the_robot_goes_on_from_there():
    follower = PathFollower(CRAWL, CRAWL, OPTIONS)
    follower.follow(CORNER, Pose2D(0.0, 0.0, 0.0))
    carried = Pose2D(2.0, 1.0, math.pi / 2)
    step = follower.next_step(carried)
    assert not step.is_turn
    assert follower.distance_left(carried) == pytest.approx(0.5)


@pytest.mark.parametrize('pose', [Pose2D(0.5, 0.6, 0.0), Pose2D(2.6, 1.0, 0.0), Pose2D(-3, -4, 0)])
def test_carried_away_the_robot_waits_for_a_new_plan(pose):
    follower = PathFollower(CRAWL, CRAWL, OPTIONS)
    follower.follow(CORNER, Pose2D(0.0, 0.0, 0.0))
    distance = distance_to_polyline((pose.x, pose.y), CORNER.corners)
    with pytest.raises(LeftPath) as caught:
        follower.next_step(pose)
    assert str(caught.value) == (
        f'the robot is {distance:.2f} m from its path; it follows within 0.50 m: '
        'waiting for a new plan'
    )


def test_brought_back_the_robot_goes_on():
    follower = PathFollower(CRAWL, CRAWL, OPTIONS)
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
    follower = PathFollower(CRAWL, CRAWL, OPTIONS)
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
    follower, pose = PathFollower(CRAWL, CRAWL, OPTIONS), CORNER.poses[0]
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
    follower, stuck = PathFollower(CRAWL, CRAWL, OPTIONS), Pose2D(1.05, 0.0, 0.0)
    follower.follow(Plan((goal,)), stuck)
    for _ in range(OPTIONS.final_cycles):
        assert follower.next_step(stuck) is not None
    with pytest.raises(GoalNotReached, match=r'0\.050 m and 0\.0 degrees off'):
        follower.next_step(stuck)


SETTLING = replace(OPTIONS, settling_distance=0.06, settling_angle=math.radians(5.0))


def test_where_it_may_settle_a_robot_that_gets_no_nearer_stays_and_says_how_far_off_it_is():
    goal = Pose2D(1.0, 0.0, 0.0)
    follower, stuck = PathFollower(CRAWL, CRAWL, SETTLING), Pose2D(1.05, 0.0, 0.0)
    follower.follow(Plan((goal,)), stuck)
    tries = 0
    while follower.next_step(stuck) is not None:
        tries += 1
        assert tries < OPTIONS.final_cycles
    assert tries > 1
    assert '0.050 m and 0.0 degrees off' in follower.remark


@pytest.mark.parametrize('stuck', [Pose2D(1.07, 0.0, 0.0), Pose2D(1.0, 0.0, 0.1)])
def test_a_robot_that_is_too_far_off_to_settle_gives_up(stuck):
    follower = PathFollower(CRAWL, CRAWL, SETTLING)
    follower.follow(Plan((Pose2D(1.0, 0.0, 0.0),)), stuck)
    for _ in range(OPTIONS.final_cycles):
        assert follower.next_step(stuck) is not None
    with pytest.raises(GoalNotReached):
        follower.next_step(stuck)


def test_half_a_turn_at_the_goal_takes_as_many_cycles_as_a_gait_with_short_steps_needs():
    # TITAN-VIII walks by turns of 17 degrees, and gave up on its goal after twelve of them.
    follower, yaw = PathFollower(CRAWL, CRAWL, OPTIONS), math.pi
    follower.follow(Plan((Pose2D(1.0, 0.0, 0.0),)), Pose2D(1.0, 0.0, yaw))
    cycles = 0
    while yaw > OPTIONS.heading_tolerance:
        assert follower.next_step(Pose2D(1.0, 0.0, yaw)) is not None
        yaw -= math.radians(5.0)
        cycles += 1
    assert cycles > 2 * OPTIONS.final_cycles
    assert follower.next_step(Pose2D(1.0, 0.0, 0.0)) is None


@pytest.mark.parametrize('options', [OPTIONS, SETTLING])
def test_cycles_that_get_nearer_do_not_count(options):
    follower, away = PathFollower(CRAWL, CRAWL, options), 0.4
    follower.follow(Plan((Pose2D(1.0, 0.0, 0.0),)), Pose2D(1.4, 0.0, 0.0))
    for _ in range(3 * OPTIONS.final_cycles):
        assert follower.next_step(Pose2D(1.0 + away, 0.0, 0.0)) is not None
        away -= 0.01
    assert follower.remark == ''


def test_what_is_left_to_do_shrinks_with_every_cycle_turns_included():
    rng = np.random.default_rng(4)
    for _ in range(20):
        plan = random_plan(rng)
        pose = Pose2D(plan.poses[0].x, plan.poses[0].y, float(rng.uniform(-3.0, 3.0)))
        follower = PathFollower(CRAWL, CRAWL, OPTIONS)
        follower.follow(plan, pose)
        left = [follower.work_left(pose)]
        while (step := follower.next_step(pose)) is not None:
            pose = pose @ step.motion.end
            left.append(follower.work_left(pose))
        least = np.minimum.accumulate(left[:-1])
        # A cycle that corrects its course may get no nearer; three do.
        assert (least[3:] < least[:-3]).all()


def test_a_way_of_turning_that_is_none_is_refused():
    with pytest.raises(ParameterError, match='one of in_place, crab, arc'):
        PathFollower(CRAWL, CRAWL, FollowerOptions(turning='pirouette'))


@dataclass(frozen=True)
class Lame(Gear):
    """A gait that can do nothing."""

    def largest_scale(self, motion):
        return 0.0


@pytest.mark.parametrize('is_steady', [False, True])
def test_a_gait_that_can_do_nothing_says_so_instead_of_standing_still_forever(is_steady):
    lame = Lame(is_steady=is_steady)
    for walking, turning, yaw, what in (
        (lame, CRAWL, 0.0, 'walk along its path'),
        (CRAWL, lame, 2.0, 'turn on the spot'),
    ):
        follower = PathFollower(walking, turning, OPTIONS)
        pose = Pose2D(0.0, 0.0, yaw)
        follower.follow(CORNER, pose)
        with pytest.raises(CannotFollow, match=f'the gait cannot {what} on this robot'):
            follower.next_step(pose)


# All three kinds of turning, with gaits that rest between cycles and with gaits that do not.

each_way = pytest.mark.parametrize('turning', TURNINGS)
GEARS = {
    'resting': CRAWL,
    'steady': WAVE,
    'small resting': Gear(0.06, 0.5, False, 4.0),
    'small steady': Gear(0.06, 0.5, True, 0.5),
    'agile': Gear(0.15, 1.5, True, 0.5),
}
each_gear = pytest.mark.parametrize('gear', GEARS.values(), ids=GEARS)


def pieces_of(plan, options):
    if options.turning == 'arc':
        return rounded_pieces(
            plan, options.corner_deviation, options.corner_radius, options.turn_threshold
        )
    return straight_pieces(plan, options.turn_threshold)


@pytest.mark.sweep(kept=5)
@each_way
@each_gear
def test_a_perfect_robot_stays_on_its_path_and_arrives_in_every_way(turning, gear):
    rng = np.random.default_rng(4)
    options = FollowerOptions(turning=turning)
    for _ in range(40):
        plan = random_plan(rng)
        start = Pose2D(0.0, 0.0, rng.uniform(-math.pi, math.pi))
        _, poses = walk(plan, start, options=options, gear=gear)
        assert_arrived(plan, poses[-1])
        pieces = pieces_of(plan, options)
        for pose in poses:
            assert min(piece.distance_to(pose) for piece in pieces) < 0.01


@pytest.mark.sweep(kept=5)
@each_way
@each_gear
def test_a_robot_that_slips_arrives_in_every_way(turning, gear):
    rng = np.random.default_rng(5)
    options = FollowerOptions(turning=turning)
    for _ in range(20):
        plan = random_plan(rng)
        start = Pose2D(0.0, 0.0, rng.uniform(-math.pi, math.pi))
        _, poses = walk(plan, start, rng, (0.003, 0.006), options, gear=gear)
        assert_arrived(plan, poses[-1])
        pieces = pieces_of(plan, options)
        for pose in poses:
            assert min(piece.distance_to(pose) for piece in pieces) < 0.08


@pytest.mark.sweep(kept=5)
@each_way
@each_gear
def test_in_no_way_a_cycle_asks_for_more_than_the_gait_can_do(turning, gear):
    rng = np.random.default_rng(6)
    options = FollowerOptions(turning=turning)
    for _ in range(20):
        plan = random_plan(rng)
        start = Pose2D(0.0, 0.0, rng.uniform(-math.pi, math.pi))
        for step in walk(plan, start, options=options, gear=gear)[0]:
            # A stride over a joint of two pieces bends where the next one does.
            assert (
                gear.largest_scale(step.motion) > 0.7
                or math.hypot(step.motion.forward, step.motion.left)
                < 1.1 * options.largest_correction
            )
            if step.exit:
                exit = BodyMotion.during(step.exit, gear.period)
                assert gear.largest_scale(exit) > 0.7


@each_gear
def test_in_the_crab_gait_the_body_keeps_its_heading_up_to_the_goal(gear):
    rng = np.random.default_rng(7)
    options = FollowerOptions(turning='crab')
    for _ in range(20):
        plan = random_plan(rng)
        start = Pose2D(0.0, 0.0, rng.uniform(-math.pi, math.pi))
        steps, poses = walk(plan, start, options=options, gear=gear)
        assert_arrived(plan, poses[-1])
        for step, pose in zip(steps, poses):
            if pose.distance_to(plan.poses[-1]) > options.position_tolerance:
                assert pose.yaw == pytest.approx(start.yaw, abs=1e-9) or math.isclose(
                    abs(pose.yaw), math.pi
                )
                assert step.motion.turn == pytest.approx(0.0, abs=1e-9)
                assert step.exit.turn == 0.0


def test_a_crab_whose_heading_is_the_goals_never_turns():
    plan = Plan.through([[0.0, 0.0], [1.0, 1.0], [-1.0, 1.0]], 0.3)
    for gear in (CRAWL, WAVE):
        steps, _ = walk(
            plan, Pose2D(0.0, 0.0, 0.3), options=FollowerOptions(turning='crab'), gear=gear
        )
        assert not any(step.is_turn for step in steps)


def test_on_arcs_a_robot_walks_through_gentle_corners_without_turning_on_the_spot():
    plan = Plan.through([[0.0, 0.0], [2.0, 0.0], [4.0, 1.0], [6.0, 1.0]], 0.0)
    options = FollowerOptions(turning='arc')
    for gear in (CRAWL, WAVE):
        steps, poses = walk(plan, Pose2D(0.0, 0.0, 0.0), options=options, gear=gear)
        assert_arrived(plan, poses[-1])
        assert not any(step.is_turn for step in steps)
        # The body faces along its path.
        for before, after in pairwise(poses):
            course = before.heading_to(after)
            middle = before.yaw + wrap_angle(after.yaw - before.yaw) / 2.0
            assert wrap_angle(course - middle) == pytest.approx(0.0, abs=0.12)


def test_where_a_steady_gait_goes_on_it_keeps_its_speed_and_rests_only_at_stops():
    plan = Plan.through([[0.0, 0.0], [3.0, 0.0]], 0.0)
    steps, _ = walk(plan, Pose2D(0.0, 0.0, 0.0), gear=WAVE)
    speeds = [step.exit.forward * WAVE.period for step in steps]
    assert speeds[-1] == 0.0
    assert all(speed > 0.0 for speed in speeds[:-1])
    assert speeds[:-3] == pytest.approx([WAVE.stride] * (len(speeds) - 3))


def test_a_steady_gait_stops_at_a_sharp_corner_and_turns_from_rest():
    steps, poses = walk(CORNER, CORNER.poses[0], gear=WAVE)
    assert_arrived(CORNER, poses[-1])
    entries = [STILL, *(step.exit for step in steps)]
    turning = [k for k, step in enumerate(steps) if step.is_turn]
    assert turning
    for k in turning:
        assert math.hypot(poses[k].x - 2.0, poses[k].y) < OPTIONS.position_tolerance
    assert not entries[turning[0]]
    assert not entries[turning[-1] + 1]


def test_a_steady_gait_needs_one_cycle_more_than_one_that_rests_to_gather_and_lose_its_speed():
    plan = Plan.through([[0.0, 0.0], [3.0, 0.0]], 0.0)
    resting, steady = (
        len(walk(plan, Pose2D(0.0, 0.0, 0.0), gear=gear)[0]) for gear in (CRAWL, WAVE)
    )
    assert resting <= steady <= resting + 1


@pytest.mark.parametrize('drift', [0.9, 1.1])
def test_lost_or_gained_distance_does_not_keep_a_steady_robot_from_arriving(drift):
    plan = Plan.through([[0.0, 0.0], [3.0, 0.0]], 0.0)
    follower = PathFollower(WAVE, WAVE, OPTIONS)
    pose, entry = plan.poses[0], STILL
    follower.follow(plan, pose)
    for _ in range(60):
        step = follower.next_step(pose, entry)
        if step is None:
            break
        end = step.motion.end
        pose, entry = pose @ Pose2D(drift * end.x, drift * end.y, end.yaw), step.exit
    assert step is None
    assert_arrived(plan, pose)


def test_a_largest_speed_is_kept():
    options = FollowerOptions(largest_speed=0.02)
    for gear in (CRAWL, WAVE):
        steps, poses = walk(CORNER, CORNER.poses[0], options=options, gear=gear)
        assert_arrived(CORNER, poses[-1])
        for step in steps:
            if not step.is_turn:
                assert step.motion.forward <= 0.02 * gear.period + 1e-9
                assert math.hypot(step.exit.forward, step.exit.left) <= 0.02 + 1e-9


@each_gear
@pytest.mark.parametrize('turn', [2.0 * math.pi, -2.0 * math.pi, 4.5 * math.pi])
def test_given_pieces_are_followed_in_place_of_the_plans(gear, turn):
    # S2's circles: R = 1 m, one lap and more.
    start = Pose2D(1.0, 2.0, 0.5)
    pieces = circle_pieces(start, 1.0, turn)
    plan = Plan((start, pieces[-1].end))
    follower = PathFollower(gear, gear, FollowerOptions(turning='arc'))
    follower.follow(plan, start, pieces)
    pose, entry, turned = start, STILL, 0.0
    center = start @ Pose2D(0.0, math.copysign(1.0, turn), 0.0)
    while (step := follower.next_step(pose, entry)) is not None:
        pose, entry = pose @ step.motion.end, step.exit
        turned += step.motion.turn
        assert pose.distance_to(center) == pytest.approx(1.0, abs=0.01)
        assert abs(turned) < abs(turn) + 0.1
    assert turned == pytest.approx(turn, abs=0.05)
    assert_arrived(plan, pose)


@each_way
def test_the_limits_of_a_real_gait_on_a_real_robot_are_gears(turning):
    robot = load_robot('cuhk')
    walking, spinning = (MotionLimits(robot, load_gait(name, robot)) for name in ('wave', 'turn'))
    plan = Plan.through([[0.0, 0.0], [0.6, 0.0], [0.6, 0.5]], 1.0)
    follower = PathFollower(walking, spinning, FollowerOptions(turning=turning))
    pose, entry = plan.poses[0], STILL
    follower.follow(plan, pose)
    for _ in range(100):
        step = follower.next_step(pose, entry)
        if step is None:
            break
        pose, entry = pose @ step.motion.end, step.exit
    assert step is None
    assert_arrived(plan, pose)


# How a distance is divided into cycles.


def divided(remaining, entry, largest, is_steady):
    """Return all advances and exit speeds up to the stop."""
    advances, speeds = [], []
    while remaining > 1e-12:
        assert len(advances) < 1000
        length, exit = advance(remaining, entry, largest, Gear(is_steady=is_steady))
        advances.append(length)
        speeds.append(exit)
        remaining, entry = remaining - length, exit
    return advances, speeds


@pytest.mark.parametrize('is_steady', [False, True])
def test_a_distance_is_divided_so_that_it_ends_exactly_at_rest(is_steady):
    rng = np.random.default_rng(8)
    for remaining, largest in rng.uniform((0.001, 0.05), (5.0, 0.5), (200, 2)):
        advances, speeds = divided(remaining, 0.0, largest, is_steady)
        assert sum(advances) == pytest.approx(remaining, abs=1e-9)
        assert speeds[-1] == 0.0
        assert all(0.0 <= speed <= largest + 1e-12 for speed in speeds)
        assert all(0.0 < advance <= largest + 1e-12 for advance in advances)


def test_a_robot_in_full_walk_comes_to_rest_at_the_end_too():
    rng = np.random.default_rng(9)
    for extra, fraction, largest in rng.uniform((0.0, 0.0, 0.05), (3.0, 1.0, 0.5), (200, 3)):
        entry = fraction * largest
        remaining = 0.5 * entry + extra * largest
        advances, speeds = divided(remaining, entry, largest, True)
        assert sum(advances) == pytest.approx(remaining, abs=1e-9)
        assert speeds[-1] == 0.0
        assert all(0.0 <= speed <= largest + 1e-12 for speed in speeds)


def test_without_a_steady_gait_all_cycles_are_equal_and_as_few_as_possible():
    for remaining, count in ((0.226, 1), (0.23, 2), (1.0, 5), (2.0, 9)):
        advances, speeds = divided(remaining, 0.0, 0.226, False)
        assert advances == pytest.approx([remaining / count] * count)
        assert set(speeds) == {0.0}


def test_a_steady_gait_neither_creeps_nor_jumps_into_the_stop():
    rng = np.random.default_rng(10)
    for remaining in rng.uniform(1.0, 5.0, 200):
        advances, speeds = divided(remaining, 0.0, 0.2, True)
        entries = [0.0, *speeds[:-1]]
        for length, entry, exit in zip(advances, entries, speeds):
            # The mean speed of a cycle is near the mean of its ends.
            assert abs(length - (entry + exit) / 2.0) <= 0.3 * 0.2 + 1e-9
