"""A trotting robot with a height map: where on it it is, and how its feet go over the ground."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.feet import UNKNOWN, Demand, GroundAhead
from quad_gait.balance.foot_laws import STILL
from quad_gait.balance.foot_plan import FootPlanner
from quad_gait.balance.known_ground import KnownGround
from quad_gait.balance.phase_clock import PhaseClock
from quad_gait.cycle.gait import load_gait
from quad_gait.ground.ground_match import GroundMatch
from quad_gait.ground.ground_slope import Slope

ROBOT = load_robot('a1')
GAIT = load_gait('trot', ROBOT).with_period(0.4)
CLOCK = PhaseClock.of(GAIT)
KNOT = 0.02
STANCE = CLOCK.stance_times[0]
NEUTRAL = ROBOT.neutral_feet
AT_REST = BodyEstimate((0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0)
NOWHERE = (0.0, 0.0, 0.0, 0.0)


def hills(height=0.05):
    """A map of hills, 6 m by 4 m."""
    level = HeightMap.level((-1.0, -2.0, 5.0, 2.0), 0.02)
    x, y = np.moveaxis(level.centers, -1, 0)
    return level.with_heights(height * np.sin(9.0 * x) * np.cos(7.0 * y))


def trotted(heights, speed=0.5, cycles=24):
    """Trot over a map: yield the time, the true pose, and the feet, which stay where they stand."""
    places = NEUTRAL[:, :2].copy()
    for k in range(round(cycles * GAIT.cycle_period / KNOT)):
        time = k * KNOT
        pose = Pose2D(speed * time, 0.1 * time, 0.0)
        swing = ~CLOCK.in_stance(time)
        places[swing] = pose.transform(NEUTRAL[swing, :2] + [speed * STANCE / 2.0, 0.0])
        steep = np.hypot(*heights.slope_at(places).T)
        over = ROBOT.foot_radius * np.sqrt(1.0 + steep * steep)
        height = 0.3 + 0.01 * math.sin(3.0 * time)
        beside = pose.inverse().transform(places)
        yield time, pose, np.column_stack([beside, heights.height_at(places) + over - height])


def matched_after(match, heights, drift, wobble=0.003):
    """Trot with odometry that is off by a drift per metre; return the error in the end [m]."""
    rng = np.random.default_rng(1)
    for time, true, feet in trotted(heights):
        odometry = Pose2D(true.x * (1.0 + drift[0]), true.y + drift[1] * true.x, 0.0)
        felt = feet + [0.0, 0.0, wobble] * rng.normal(size=(4, 3))
        match.update(time, (odometry, odometry), felt, CLOCK.in_stance(time), STANCE)
    x, y = match.shift
    return math.hypot(odometry.x + x - true.x, odometry.y + y - true.y), true.x


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('drift', [(0.05, 0.0), (-0.05, 0.0), (0.0, 0.04), (0.04, -0.04)])
def test_feet_tell_where_on_the_map_a_robot_is_that_drifts(drift):
    error, distance = matched_after(GroundMatch(hills(), ROBOT), hills(), drift)
    assert error < 0.01 < 0.1 * math.hypot(*drift) * distance


def test_a_map_may_count_heights_from_anywhere():
    high = hills().with_heights(hills().heights + 140.0)
    found, above = GroundMatch(hills(), ROBOT), GroundMatch(high, ROBOT)
    matched_after(found, hills(), (0.05, 0.0))
    matched_after(above, high, (0.05, 0.0))
    assert above.shift == pytest.approx(found.shift, abs=1e-4)
    assert above.is_sure


def test_level_ground_leaves_a_robot_where_odometry_has_it():
    level = hills(height=0.0)
    match = GroundMatch(level, ROBOT)
    matched_after(match, level, (0.05, 0.0))
    assert match.shift == pytest.approx((0.0, 0.0), abs=1e-9)
    assert match.is_sure


def test_after_a_long_way_over_level_ground_noise_on_a_gentle_rise_does_not_move_a_robot_far():
    level = HeightMap.level((-1.0, -1.0, 20.0, 5.0), 0.02)
    ramp = level.with_heights(0.02 * np.clip(level.centers[..., 0] - 14.0, 0.0, 2.0))
    rng, match, farthest = np.random.default_rng(2), GroundMatch(ramp, ROBOT), 0.0
    for time, pose, feet in trotted(ramp, cycles=78):
        felt = feet + [0.0, 0.0, 0.004] * rng.normal(size=(4, 3))
        match.update(time, (pose, pose), felt, CLOCK.in_stance(time), STANCE)
        farthest = max(farthest, math.hypot(*match.shift))
    assert pose.x > 15.0
    assert farthest < 0.15 * ROBOT.hip_height


def test_a_correction_of_odometry_is_judged_by_the_feet():
    # A localiser moves the pose by 60 mm at once, and is wrong.
    heights, match = hills(), GroundMatch(hills(), ROBOT)
    for time, true, feet in trotted(heights):
        on_map = Pose2D(true.x + (0.06 if time > 5.0 else 0.0), true.y, 0.0)
        match.update(time, (on_map, true), feet, CLOCK.in_stance(time), STANCE)
    assert match.shift == pytest.approx((-0.06, 0.0), abs=0.01)


def test_a_map_that_does_not_fit_is_not_believed():
    rng = np.random.default_rng(3)
    wrong = hills().with_heights(0.4 * rng.uniform(size=hills().heights.shape))
    ground = KnownGround(wrong, ROBOT)
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    landings = planner.landings(planner.at_rest(NEUTRAL), CLOCK, 0.0, AT_REST)
    for time, pose, feet in trotted(hills()):
        ground.locate(time, (pose, pose), feet, CLOCK.in_stance(time), STANCE)
    assert not ground.match.is_sure
    assert ground.ahead(0.02, AT_REST, landings) == UNKNOWN


def absurd(extent, seed=4):
    """A map of random heights."""
    shape = hills().heights.shape
    return hills().with_heights(np.random.default_rng(seed).uniform(-extent, extent, shape))


def is_sure_while_trotting(match, heights, time=math.inf, other=None):
    """Trot over the ground; yield whether a map is believed, of which there is another in time."""
    for now, pose, feet in trotted(heights):
        if other is not None and now >= time:
            match.take(other)
            other = None
        match.update(now, (pose, pose), feet, CLOCK.in_stance(now), STANCE)
        yield now, match.is_sure


@pytest.mark.sweep(kept=3)
@pytest.mark.parametrize('seed', range(8))
def test_a_map_that_the_feet_contradict_is_not_believed_from_the_first(seed):
    level = hills(height=0.0)
    match = GroundMatch(absurd(0.1, seed), ROBOT)
    assert not any(sure for _, sure in is_sure_while_trotting(match, level))


@pytest.mark.sweep(kept=3)
@pytest.mark.parametrize('seed', range(8))
def test_a_map_that_takes_the_place_of_a_right_one_is_held_against_the_last_footholds(seed):
    level = hills(height=0.0)
    sure = dict(is_sure_while_trotting(GroundMatch(level, ROBOT), level, 4.0, absurd(0.1, seed)))
    assert [sure[t] for t in sure if 1.0 < t < 4.0] == [True] * sum(1.0 < t < 4.0 for t in sure)
    assert not any(sure[t] for t in sure if t >= 4.0)


def test_a_right_map_is_believed_as_soon_as_four_footholds_confirm_it():
    sure = dict(is_sure_while_trotting(GroundMatch(hills(), ROBOT), hills()))
    first = min(time for time in sure if sure[time])
    assert all(sure[time] for time in sure if time >= first)
    assert first < 0.6 * GAIT.cycle_period


def test_a_map_that_counts_heights_from_elsewhere_takes_the_place_of_another_at_once():
    high = hills().with_heights(hills().heights + 3.0)
    match = GroundMatch(hills(), ROBOT)
    sure = dict(is_sure_while_trotting(match, hills(), 4.0, high))
    assert all(sure[time] for time in sure if time > 1.0)
    assert match.shift == pytest.approx((0.0, 0.0), abs=0.005)


def test_a_map_that_is_replaced_leaves_the_robot_where_it_found_itself():
    match, replaced = GroundMatch(hills(), ROBOT), 0
    for time, true, feet in trotted(hills()):
        odometry = Pose2D(1.04 * true.x, true.y, 0.0)
        match.update(time, (odometry, odometry), feet, CLOCK.in_stance(time), STANCE)
        if time > 4.0 and replaced < time:
            # As mappers do, several times in a second.
            match.take(hills().with_heights(hills().heights.copy()))
            replaced = time + 0.2
    assert odometry.x + match.shift[0] == pytest.approx(true.x, abs=0.01)
    assert match.is_sure


def test_after_a_wrong_map_a_right_one_is_believed_again():
    match = GroundMatch(absurd(0.1), ROBOT)
    sure = dict(is_sure_while_trotting(match, hills(), 4.0, hills()))
    assert not any(sure[time] for time in sure if time < 4.0)
    assert all(sure[time] for time in sure if time > 6.0)
    assert match.shift == pytest.approx((0.0, 0.0), abs=0.01)


def test_no_map_leads_a_robot_farther_than_odometry_drifts():
    match, way, farthest = GroundMatch(absurd(0.05), ROBOT), 0.0, 0.0
    for time, pose, feet in trotted(hills(height=0.0)):
        match.update(time, (pose, pose), feet, CLOCK.in_stance(time), STANCE)
        way = math.hypot(pose.x, pose.y)
        assert math.hypot(*match.shift) < 3.01 * math.hypot(0.01, 0.07 * math.sqrt(way))
        farthest = max(farthest, math.hypot(*match.shift))
    assert farthest > 0.05


def ahead_of_walker(heights_at):
    """Tell a robot that walks of ground that has heights by x; level under its feet."""
    level = hills(height=0.0)
    ahead = level.with_heights(heights_at(level.centers[..., 0]))
    body = replace(AT_REST, velocity=(0.8, 0.0))
    planner, ground = FootPlanner(ROBOT, GAIT, BalanceOptions()), KnownGround(ahead, ROBOT)
    plan = planner.at_rest(NEUTRAL)._replace(pace=STILL._replace(forward=0.8))
    ground.locate(0.0, 2 * (Pose2D(0.0, 0.0, 0.0),), NEUTRAL, np.ones(4, dtype=bool), STANCE)
    return ground.ahead(0.02, body, planner.landings(plan, CLOCK, 0.0, body))


# It begins in front of the fore feet, where they land next.
EDGE = NEUTRAL[:, 0].max() + 0.05


def test_ground_that_is_farther_off_than_a_leg_steps_counts_as_unknown():
    def step(height):
        return ahead_of_walker(lambda x: np.where(x > EDGE, height, 0.0))

    size = ROBOT.hip_height
    assert max(step(0.2 * size).rises) == pytest.approx(0.2 * size)
    assert min(step(-0.2 * size).rises) == pytest.approx(-0.2 * size)
    assert step(0.35 * size) == step(-0.35 * size) == step(100.0) == UNKNOWN


@pytest.mark.parametrize('gradient', [0.3, -0.3])
def test_a_slope_ahead_is_known_where_it_leads_farther_than_a_step(gradient):
    found = ahead_of_walker(lambda x: gradient * np.maximum(x - EDGE, 0.0))
    farthest = max(found.rises, key=abs)
    assert abs(farthest) > 0.25 * ROBOT.hip_height
    assert farthest * gradient > 0.0


@pytest.mark.parametrize('gradient', [0.7, -0.7])
def test_a_slope_that_is_too_steep_is_unknown(gradient):
    assert ahead_of_walker(lambda x: gradient * np.maximum(x - EDGE, 0.0)) == UNKNOWN


def test_a_wall_between_the_feet_counts_as_unknown():
    def wall(height):
        return ahead_of_walker(lambda x: np.where(abs(x) < 0.06, height * ROBOT.hip_height, 0.0))

    assert wall(0.35) == wall(-0.35) == wall(3.0) == UNKNOWN
    assert wall(0.2).is_known


def told(ground, pose, plan=None, time=0.0, rises=NOWHERE):
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    plan = plan or planner.at_rest(NEUTRAL)
    feet = NEUTRAL.copy()
    feet[:, 2] += rises
    ground.locate(0.0, (pose, pose), feet, np.ones(4, dtype=bool), STANCE)
    return ground.ahead(0.0, AT_REST, planner.landings(plan, CLOCK, time, AT_REST))


def test_nothing_is_known_off_the_map_and_where_it_has_holes():
    heights = hills(height=0.0)
    assert told(KnownGround(heights, ROBOT), Pose2D(0.0, 0.0, 0.0)).is_known
    assert told(KnownGround(heights, ROBOT), Pose2D(9.0, 0.0, 0.0)) == UNKNOWN
    holes = heights.heights.copy()
    holes[:, :150] = math.nan
    assert told(KnownGround(heights.with_heights(holes), ROBOT), Pose2D(0.0, 0.0, 0.0)) == UNKNOWN


def test_heights_are_told_over_the_plane_on_which_the_feet_are_planned():
    level = HeightMap.level((-1.0, -1.0, 1.0, 1.0), 0.02)
    x = level.centers[..., 0]
    # A step of 30 mm between the hind feet and the fore feet.
    step = level.with_heights(np.where(x > 0.0, 0.03, 0.0))
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    plan = planner.at_rest(NEUTRAL)
    fore = NEUTRAL[:, 0] > 0.0
    rises = np.where(fore, 0.03, 0.0)
    found = told(KnownGround(step, ROBOT), Pose2D(0.0, 0.0, 0.0), plan, rises=rises)
    assert np.array(found.rises)[fore] - np.array(found.rises)[~fore] == pytest.approx(0.03)
    assert found.body == pytest.approx(np.mean(found.rises), abs=1e-9)


def test_a_slope_that_the_plane_has_is_no_rise_however_fast_the_body_goes():
    level = HeightMap.level((-1.0, -1.0, 1.0, 1.0), 0.02)
    ramp = level.with_heights(0.2 * level.centers[..., 0])
    slope = Slope.along(0.2, 0.0, 1.0)
    body = replace(AT_REST, velocity=(0.5, 0.1), slope=slope)
    planner, ground = FootPlanner(ROBOT, GAIT, BalanceOptions()), KnownGround(ramp, ROBOT)
    plan = planner.at_rest(NEUTRAL, slope)
    flat = np.zeros(4)
    plan.records['rise'] = flat
    ground.locate(0.0, 2 * (Pose2D(0.0, 0.0, 0.0),), NEUTRAL, np.ones(4, dtype=bool), STANCE)
    found = ground.ahead(0.02, body, planner.landings(plan, CLOCK, 0.0, body))
    assert found.rises == pytest.approx(flat, abs=1e-9)
    assert (found.body, *found.bumps) == pytest.approx((0.0, *flat), abs=1e-9)


def marched(ground, cycles, roughness=0.0):
    """Feet of a trot in place over ground ahead, (knots, 4)."""
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    count = round(cycles * GAIT.cycle_period / KNOT)
    times = [k * KNOT for k in range(count + 1)]
    demand = Demand(STILL, STILL, roughness=roughness, ground=ground)
    return planner.march(planner.at_rest(NEUTRAL), CLOCK, times, demand).feet


def test_feet_land_as_high_as_the_ground_is_and_no_foot_jumps():
    rises = (0.03, -0.02, 0.0, 0.01)
    feet = marched(GroundAhead(True, rises, NOWHERE, 0.0), 2.0)
    assert feet[-1]['swings'].sum() in (0.0, 2.0)
    landed = feet[-1]['swings'] == 0.0
    assert feet[-1]['z'][landed] == pytest.approx((NEUTRAL[:, 2] + rises)[landed], abs=1e-9)
    fastest = np.abs(np.diff(feet['z'], axis=0)).max()
    assert fastest < math.pi * 1.5 * (GAIT.swing_height + 0.03) / CLOCK.longest_swing * KNOT


def test_the_body_goes_up_with_the_ground_and_its_feet_stay_on_theirs():
    # All of the ground is 20 mm above the plane on which the feet were planned.
    feet = marched(GroundAhead(True, 4 * (0.02,), NOWHERE, 0.02), 6.0)
    assert feet[-1]['z'][feet[-1]['swings'] == 0.0] == pytest.approx(NEUTRAL[0, 2], abs=2e-3)
    middle = feet[round(0.1 / KNOT)]
    stands = middle['swings'] == 0.0
    assert (middle['rise'][stands] < -0.005).all()


def test_a_foot_is_lifted_over_what_is_on_its_way_and_no_higher_than_joints_can():
    def highest(bump, leg=0):
        bumps = tuple(bump if k == leg else 0.0 for k in range(4))
        z = marched(GroundAhead(True, NOWHERE, bumps, 0.0), 2.0)['z'] - NEUTRAL[:, 2]
        return z.max(axis=0)

    usual = highest(0.0)
    over = highest(0.02)
    assert over[0] - usual[0] == pytest.approx(0.02, rel=0.03)
    assert over[1:] == pytest.approx(usual[1:])
    assert highest(0.5)[0] == highest(1.0)[0] < 0.2


def test_blind_feet_land_on_the_plane():
    assert marched(UNKNOWN, 2.0).tobytes() == marched(GroundAhead(*UNKNOWN), 2.0).tobytes()
    assert np.ptp(marched(UNKNOWN, 2.0)['rise']) == 0.0


def test_a_robot_that_stands_on_uneven_ground_begins_to_trot_without_a_jump():
    places = NEUTRAL + [[0.0, 0.0, z] for z in (0.03, 0.0, -0.02, 0.01)]
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    after = CLOCK._replace(start=1.0)
    times = [k * KNOT for k in range(40)]
    feet = planner.march(planner.at_rest(places), after, times, Demand(STILL, STILL)).feet
    assert feet[0]['z'] == pytest.approx(places[:, 2], abs=1e-9)
    assert np.abs(np.diff(feet['z'], axis=0)).max() < 0.03 * KNOT / 0.09
    assert feet[-1]['z'] == pytest.approx(NEUTRAL[:, 2], abs=1e-3)
