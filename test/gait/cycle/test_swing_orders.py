"""The order of the legs' swings: the steadiest one, found in little time."""

import math

import numpy as np
import pytest

from quad_common.errors import GaitError
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, Twist2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle import foot_paths
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.cycle.gait_generator import CycleOptions, generate_steady_cycle, margins_of_orders
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.supervisor import Supervisor
from quad_lab.closed_loop.closed_loop import ClosedLoop

ROBOTS = {name: load_robot(name) for name in ('titan_viii', 'pukyong', 'cuhk', 'genibo')}
STATIC_GAITS = ('crab', 'crawl', 'turn', 'wave')

MOST_PASSES = 20
"""Cycles that may be generated within one update: a search through 24 orders, one by one, or a
bisection, is more. All orders at once are one of them."""

each_robot = pytest.mark.parametrize('robot', ROBOTS.values(), ids=ROBOTS)
each_gait = pytest.mark.parametrize('gait', STATIC_GAITS)

ORIGIN = Pose2D(0.0, 0.0, 0.0)


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def middling(robot, parts):
    """Make a motion of two fifths of what S0's bounds allow in a direction."""
    forward, left, turn = parts
    fraction = math.hypot(forward, left) / robot.largest_stride + abs(turn) / robot.largest_turn
    return BodyMotion(*(0.4 / fraction * part for part in parts))


def directions(rng, count):
    return [(1.0, 0.0, 0.0), *rng.uniform((-1.0, -1.0, -3.0), (1.0, 1.0, 3.0), (count, 3))]


def margin_alone(robot, order, motion, period):
    try:
        return generate_steady_cycle(robot, order, motion, CycleOptions(period)).least_margin
    except GaitError:
        return -math.inf


@pytest.mark.sweep(kept=5)
@each_robot
@each_gait
def test_all_orders_at_once_have_the_margins_that_each_has_alone(robot, gait, rng):
    limits = MotionLimits(robot, load_gait(gait, robot))
    orders = {limits.gait_for(BodyMotion(*parts)) for parts in directions(rng, 4)}
    orders = [limits.gait, limits.gait.mirrored(), *orders]
    period = limits.period / 40
    for parts in directions(rng, 2):
        motion = middling(robot, parts)
        alone = [margin_alone(robot, order, motion, period) for order in orders]
        together = margins_of_orders(robot, orders, motion, period)
        for one, other in zip(alone, together):
            # Speeds of joints are looked at in a cycle alone only.
            assert one == -math.inf or one == pytest.approx(other, abs=1e-9)


@pytest.mark.sweep(kept=5)
@each_robot
@each_gait
def test_no_other_order_is_much_steadier_than_the_one_that_is_taken(robot, gait, rng):
    limits = MotionLimits(robot, load_gait(gait, robot))
    period = limits.period / 40
    for parts in directions(rng, 2):
        motion = middling(robot, parts)
        taken = margin_alone(robot, limits.gait_for(motion), motion, period)
        others = [margin_alone(robot, order, motion, period) for order in limits._variants]
        assert taken >= 0.89 * max(others)


def test_the_order_does_not_depend_on_what_was_walked_before(rng):
    gait = load_gait('crawl', ROBOTS['titan_viii'])
    motions = [BodyMotion(*parts) for parts in directions(rng, 6)]
    there, back = (MotionLimits(ROBOTS['titan_viii'], gait) for _ in range(2))
    orders = [there.gait_for(motion) for motion in motions]
    assert [back.gait_for(motion) for motion in reversed(motions)] == orders[::-1]


class CountedWalk(ClosedLoop):
    """Walks, and counts the cycles that are generated within an update."""

    def __init__(self, monkeypatch, robot, gait, start=ORIGIN, **follower):
        gait = load_gait(gait, robot)
        options = SupervisorOptions(twist_timeout=math.inf, follower=FollowerOptions(**follower))
        controller = Supervisor(robot, gait, turning_gait_for(gait, robot), options)
        controller.prepare()
        super().__init__(robot, controller, 'kinematic', start=start)
        self.passes = []
        rolling, update = foot_paths.rolling_of, controller.update

        def counted(*args):
            # Every cycle asks for it once, and so do all orders together.
            self.passes[-1] += 1
            return rolling(*args)

        def update_counted(now):
            self.passes.append(0)
            return update(now)

        monkeypatch.setattr(foot_paths, 'rolling_of', counted)
        monkeypatch.setattr(controller, 'update', update_counted)


@pytest.mark.parametrize('turning', ['in_place', 'crab'])
def test_no_update_of_a_walk_that_is_corrected_generates_many_cycles(monkeypatch, turning):
    gait = {'in_place': 'crawl', 'crab': 'crab'}[turning]
    start = Pose2D(0.02, -0.04, 0.1)
    walk = CountedWalk(monkeypatch, ROBOTS['titan_viii'], gait, start, turning=turning)
    walk.run(0.1)
    walk.controller.set_plan(Plan.through([(0.0, 0.0), (0.5, 0.1), (0.6, 0.5)], 2.5))
    assert walk.run(200.0, until=lambda: walk.controller.activity is Activity.ARRIVED)
    assert 0 < max(walk.passes) <= MOST_PASSES


@pytest.mark.parametrize('robot', ['titan_viii', 'cuhk'])
def test_no_update_of_a_crawl_steered_anywhere_generates_many_cycles(monkeypatch, robot, rng):
    walk = CountedWalk(monkeypatch, ROBOTS[robot], 'crawl')
    walk.run(0.1)
    for parts in rng.uniform((-0.05, -0.05, -0.2), (0.05, 0.05, 0.2), (5, 3)):
        walk.controller.set_twist(Twist2D(*parts))
        walk.run(7.0)
    assert sum(passes > 0 for passes in walk.passes) >= 5
    assert max(walk.passes) <= MOST_PASSES
