"""Footsteps: every one within reach and balanced, on even ground, and none cheaper."""

import heapq
import itertools
import math

import numpy as np
import pytest

from quad_common.errors import FootstepsNotFound, GaitError
from quad_common.footing.leg_room import LegRoom
from quad_common.footing.postures import LOWERINGS
from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.footsteps.foothold_map import FootholdMap
from quad_gait.footsteps.footstep_options import FootstepOptions
from quad_gait.footsteps.footstep_planner import FootstepPlanner, pose_over
from quad_gait.footsteps.footstep_route import FootstepRoute
from quad_gait.footsteps.pieces import whole
from quad_gait.footsteps.search_values import Lattice
from quad_gait.state.body_placement import BodyPose, balanced, body_over, heading_over
from quad_gait.state.stance import Stance
from quad_gait.uneven.uneven_options import UnevenOptions

TITAN, GENIBO = load_robot('titan_viii'), load_robot('genibo')
OPTIONS = FootstepOptions()
AHEAD = Pose2D(1.2, 0.0, 0.0)
FLAT = np.zeros(2)


def stones(scale=1.0, side=0.2, gap=0.09, seed=1, begin=0.35):
    """Lay stones ahead, each at a height of its own, over a deep pit."""
    rng = np.random.default_rng(seed)
    level = HeightMap.level((-0.6, -0.8, 2.4, 0.8), 0.02)
    x, y = np.moveaxis(level.centers, -1, 0)
    column, row = np.floor((x - begin) / (side + gap)), np.floor((y + 0.03) / (side + gap))
    on_stone = (x - begin) % (side + gap) > gap
    on_stone &= (y + 0.03) % (side + gap) > gap
    tops = {key: -0.02 * rng.random() for key in set(zip(column.flat, row.flat))}
    top = np.vectorize(lambda a, b: tops[a, b])(column, row)
    heights = np.where(x < begin, 0.0, np.where(on_stone, top, -0.3))
    origin = tuple(scale * np.array(level.origin))
    return HeightMap(scale * heights, scale * level.resolution, origin)


def standing_feet(robot, heights, x=0.0):
    feet = robot.neutral_feet + np.array([x, 0.0, 0.0])
    feet[:, 2] = heights.height_at(feet[:, :2]) + robot.foot_radius
    return feet


def reaches(robot, body, feet, leg=None, start=None):
    """Tell whether the legs reach the feet with the level body at one of its heights."""
    for lower in LOWERINGS:
        position = body.position - [0.0, 0.0, robot.relative_size * lower]
        place = BodyPose(position, 0.0, 0.0, body.yaw)
        local = (feet - place.position) @ place.rotation
        try:
            robot.joint_angles(local)
            if leg is not None:
                local[leg] = (start - place.position) @ place.rotation
                robot.joint_angles(local)
        except GaitError:
            continue
        return True
    return False


def rest_over(robot, feet):
    return body_over(robot, feet, heading_over(robot, feet), FLAT, 0.0)


def swinging_over(robot, before, after, leg, margin):
    feet = after.copy()
    feet[leg, :2] = 0.5 * (before[leg] + after[leg])[:2]
    body = rest_over(robot, feet)
    center = robot.center_of_mass(robot.initial_joint_angles)
    offset = (body.rotation @ center)[:2]
    triangle = np.delete(before[:, :2], leg, axis=0)
    moved = balanced(body.position[:2] + offset, triangle, margin) - offset
    return BodyPose(np.array([*moved, body.position[2]]), 0.0, 0.0, body.yaw)


def inscribed_radius(triangle):
    sides = [np.hypot(*(triangle[k] - triangle[k - 1])) for k in range(3)]
    a, b = triangle[1] - triangle[0], triangle[2] - triangle[0]
    return abs(a[0] * b[1] - a[1] * b[0]) / sum(sides)


# What legs reach


@pytest.mark.parametrize('robot', [TITAN, GENIBO], ids=lambda robot: robot.name)
def test_legs_reach_whatever_the_table_says(robot):
    room, rng = LegRoom.of(robot), np.random.default_rng(0)
    assert np.isfinite(room.lowest).mean() > 0.1
    half = room.lowest.shape[1] / 2.0
    for leg, i, j in rng.permutation(np.argwhere(np.isfinite(room.lowest)))[:200]:
        u, v = (np.array([i, j]) + rng.random(2) - half) * room.side
        z = rng.uniform(room.lowest[leg, i, j], room.highest[leg, i, j])
        feet = robot.neutral_feet.copy()
        feet[leg] = *(robot.neutral_feet[leg, :2] + (u, v)), z
        angles = robot.joint_angles(feet)
        # Its thigh keeps off the body, too.
        assert robot.own_parts.leg_keeps_clear(leg, angles[None, leg]).all()


def test_where_a_leg_reaches_out_the_body_may_be_lower():
    room = LegRoom.of(GENIBO)
    middle = GENIBO.neutral_feet[:, 2, None, None]
    is_known = np.isfinite(room.lowest)
    assert (room.highest >= room.lowest)[is_known].all()
    # Places that no foot reaches at its initial height, and a foot that is higher does.
    only_lower = is_known & (room.lowest > middle + 1e-6)
    assert only_lower.sum() > 0.2 * is_known.sum()


# Plans


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize(('robot', 'seed'), [(TITAN, 1), (TITAN, 2), (GENIBO, 3)])
def test_each_step_is_balanced_in_reach_and_on_even_ground(robot, seed):
    scale = robot.relative_size
    # Smaller gaps for the one with the shorter reach.
    heights = stones(scale, gap=0.09 if robot is TITAN else 0.05, seed=seed)
    ground = FootholdMap(robot, UnevenOptions(), OPTIONS, heights)
    before = standing_feet(robot, heights)
    target = Pose2D(scale * AHEAD.x, 0.0, 0.0)
    plan = FootstepPlanner(robot, OPTIONS).plan(before, target, ground)
    assert len(plan.steps) >= 12
    for step in plan.steps:
        leg, after = step.leg, step.feet
        others = np.arange(4) != leg
        assert (after[others] == before[others]).all()
        assert (after[leg] == step.foothold).all()
        length = np.hypot(*(after - before)[leg, :2])
        assert 0.0 < length <= scale * OPTIONS.longest_step
        assert ground.is_fit(leg, after[None, leg, :2], 0.0).all()
        assert heights.step_at(after[leg, :2], scale * OPTIONS.radius) <= scale * 0.025
        height = after[leg, 2] - robot.foot_radius
        assert height == pytest.approx(heights.height_at(after[leg, :2]), abs=1e-9)
        rest = rest_over(robot, after)
        beside = (after - rest.position) @ rest.rotation
        neutral = robot.neutral_feet[leg & ~1, 1] - robot.neutral_feet[leg | 1, 1]
        apart = beside[leg & ~1, 1] - beside[leg | 1, 1]
        assert apart >= OPTIONS.breadth * neutral - 1e-9
        triangle = before[others, :2]
        assert inscribed_radius(triangle) >= scale * OPTIONS.margin
        assert reaches(robot, rest_over(robot, after), after)
        body = swinging_over(robot, before, after, leg, scale * OPTIONS.margin)
        assert reaches(robot, body, after, leg, before[leg])
        before = after
    end = pose_over(robot, before)
    assert end.distance_to(target) <= scale * OPTIONS.far_tolerance
    assert abs(end.yaw) <= OPTIONS.angle_tolerance


def test_a_pit_that_is_too_wide_is_not_stepped_over():
    heights = stones(gap=0.6, side=0.3)
    ground = FootholdMap(TITAN, UnevenOptions(), OPTIONS, heights)
    with pytest.raises(FootstepsNotFound, match=r'no sequence of footholds leads 1\.20 m ahead'):
        FootstepPlanner(TITAN, OPTIONS).plan(standing_feet(TITAN, heights), AHEAD, ground)


def test_where_no_footsteps_have_all_the_margin_some_with_less_will_do():
    heights = stones()
    feet = standing_feet(TITAN, heights)
    asked = {'margin': 0.12, 'least_margin': 0.12}

    def planned(**margins):
        options = FootstepOptions(most_expansions=800, **margins)
        ground = FootholdMap(TITAN, UnevenOptions(), options, heights)
        return FootstepPlanner(TITAN, options).plan(feet, AHEAD, ground)

    with pytest.raises(FootstepsNotFound):
        planned(**asked)
    less = planned(**asked | {'least_margin': OPTIONS.margin})
    usual = planned()
    assert [step.leg for step in less.steps] == [step.leg for step in usual.steps]
    assert np.array_equal(less.steps[-1].feet, usual.steps[-1].feet)


def test_where_stones_are_small_more_of_their_places_are_looked_at():
    # Of squares as large as these stones most give a place beside them, or none.
    a1 = load_robot('a1')
    scale, leg = a1.relative_size, a1.legs[0].thigh_length + a1.legs[0].calf_length
    far, found = Pose2D(1.2 * scale, 0.0, 0.0), []
    for blocks in (3,), (3, 2):
        options = FootstepOptions(blocks=blocks)
        count = 0
        for seed in range(3):
            heights = stones(scale, gap=0.25 * leg / scale, seed=seed)
            ground = FootholdMap(a1, UnevenOptions(), options, heights)
            try:
                FootstepPlanner(a1, options).plan(standing_feet(a1, heights), far, ground)
            except FootstepsNotFound:
                continue
            count += 1
        found.append(count)
    assert found[1] == 3
    assert found[0] < 3


def test_where_the_body_is_already_no_step_is_planned():
    heights = stones()
    ground = FootholdMap(TITAN, UnevenOptions(), OPTIONS, heights)
    feet = standing_feet(TITAN, heights)
    assert FootstepPlanner(TITAN, OPTIONS).plan(feet, Pose2D(0.01, 0.0, 0.0), ground).steps == ()


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('seed', range(6))
def test_no_other_path_costs_less(seed):
    # Few cells, so that every stance can be looked at.
    options = FootstepOptions(weight=1.0, strain=0.0, expansions=100000)
    rng = np.random.default_rng(seed)
    side, rows, columns = 0.08, 9, 10
    x, y = side * np.arange(columns) - 0.24, side * np.arange(rows) - 0.32
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    fit = np.zeros((4, len(points)), dtype=np.uint8)
    for leg in range(4):
        away = points - (TITAN.neutral_feet[leg, :2] + (0.1, 0.0))
        near = np.flatnonzero(np.hypot(*away.T) < 0.16)
        fit[leg, rng.choice(near, 3, replace=False)] = 1
    feet = TITAN.neutral_feet.copy()
    level = np.full(len(points), feet[0, 2])
    places = np.concatenate([np.column_stack([points, level]), feet])
    lattice = Lattice(places, fit.reshape(4, rows, columns), x[0], y[0], side)
    target = Pose2D(float(rng.uniform(0.08, 0.15)), 0.0, 0.0)
    planner = FootstepPlanner(TITAN, options)
    best = cheapest(planner._body, lattice, target, options)
    if best is None:
        with pytest.raises(FootstepsNotFound):
            planner.plan_over(lattice, target)
        return
    plan = planner.plan_over(lattice, target)
    assert plan.is_best
    assert plan.cost == pytest.approx(best, abs=1e-9)


def cheapest(body, lattice, target, options):
    """Find the least cost by Dijkstra's algorithm over all stances; None if there is no path."""
    fit, places = lattice.fit.reshape(4, -1), lattice.places
    start = tuple(len(places) - 4 + np.arange(4))
    costs, queue, done = {start: 0.0}, [(0.0, start)], set()
    while queue:
        cost, stance = heapq.heappop(queue)
        if stance in done:
            continue
        done.add(stance)
        feet = places[list(stance)]
        pose = pose_over(TITAN, feet)
        if pose.distance_to(target) <= options.distance_tolerance and abs(pose.yaw) <= 0.1:
            return cost
        for leg in range(4):
            for cell in np.flatnonzero(fit[leg]):
                after = feet.copy()
                after[leg] = places[cell]
                if not may_step(body, feet, after, leg, options, lattice.side):
                    continue
                after_pose = rest_over(TITAN, after)
                off = (after[leg] - after_pose.position) @ after_pose.rotation
                off = np.hypot(*(off - TITAN.neutral_feet[leg])[:2]) / options.longest_step
                new = cost + 1.0 + 0.3 * off**2 + 4.0 * after_pose.yaw**2
                other = (*stance[:leg], int(cell), *stance[leg + 1 :])
                if new < costs.get(other, math.inf):
                    costs[other] = new
                    heapq.heappush(queue, (new, other))
    return None


def may_step(body, before, after, leg, options, side):
    apart = [np.hypot(*(after[a] - after[b])[:2]) for a, b in itertools.combinations(range(4), 2)]
    length = np.hypot(*(after - before)[leg, :2])
    if min(apart) < body.separation or not 0.5 * side <= length <= options.longest_step:
        return False
    rest = rest_over(TITAN, after)
    left, right = ((after[k] - rest.position) @ rest.rotation for k in (leg & ~1, leg | 1))
    if (left - right)[1] < body.breadth:
        return False
    if inscribed_radius(np.delete(before[:, :2], leg, axis=0)) < options.margin:
        return False
    swinging = swinging_over(TITAN, before, after, leg, options.margin)
    both = np.concatenate([after, before[None, leg]])
    return in_room(body, rest_over(TITAN, after), after, range(4)) and in_room(
        body, swinging, both, [*range(4), leg]
    )


def in_room(body, pose, feet, legs):
    low, high = -math.inf, math.inf
    for leg, foot in zip(legs, feet):
        away = ((foot - pose.position) @ pose.rotation - TITAN.neutral_feet[leg])[:2]
        i, j = np.floor(away / body.side + body.lowest.shape[1] / 2.0).astype(int)
        if not (min(i, j) >= 0 and max(i, j) < body.lowest.shape[1]):
            return False
        low = max(low, foot[2] - body.highest[leg, i, j])
        high = min(high, foot[2] - body.lowest[leg, i, j])
    return any(low <= pose.position[2] - lower <= high for lower in body.lowerings)


# Along a path


def stance_on(feet):
    body = rest_over(TITAN, feet)
    joints = TITAN.joint_angles((feet - body.position) @ body.rotation)
    return Stance(0.0, body, feet, joints, lambda: None)


def route_over(heights):
    route = FootstepRoute(TITAN, UnevenOptions(), OPTIONS)
    route.take_map(heights)
    return route


def stride_ahead(route, *args, **options):
    return whole(route.planning(*args, **options))


def test_on_even_ground_no_footsteps_are_planned():
    heights = HeightMap.level((-1.0, -1.0, 3.0, 1.0), 0.02)
    feet = standing_feet(TITAN, heights)
    assert stride_ahead(route_over(heights), stance_on(feet), Pose2D(0, 0, 0), [AHEAD]) is None
    unknown = heights.with_heights(np.full(heights.heights.shape, np.nan))
    assert stride_ahead(route_over(unknown), stance_on(feet), Pose2D(0, 0, 0), [AHEAD]) is None


def test_a_route_that_was_prepared_gives_the_same_strides():
    heights = stones()
    feet = standing_feet(TITAN, heights)
    given = []
    for is_prepared in (True, False):
        route = route_over(heights)
        if is_prepared:
            route.prepare()
        given.append(stride_ahead(route, stance_on(feet), pose_over(TITAN, feet), [AHEAD]))
    assert given[0].order == given[1].order
    assert np.array_equal(given[0].footholds, given[1].footholds)


@pytest.mark.parametrize('touches', [False, True])
def test_half_a_plan_is_walked_before_its_second_half_is_looked_at(monkeypatch, touches):
    heights = stones()
    route, feet = route_over(heights), standing_feet(TITAN, heights)
    planning, plans, looked_at = FootstepPlanner.planning, [], []

    def planned(*request):
        plans.append((yield from planning(*request)))
        return plans[-1]

    def touching(planner, feet, steps, ground, shift):
        # That of whole plans finds nothing.
        is_rest = len(plans) == 1 and len(steps) <= len(plans[0].steps) / 2
        looked_at.append(is_rest)
        return [(0, *steps[0].foothold[:2])] if touches and is_rest else []

    monkeypatch.setattr(FootstepPlanner, 'planning', planned)
    monkeypatch.setattr(FootstepPlanner, 'touching', touching)
    walked = 0
    while not plans or (walked < len(plans[0].steps) and len(plans) == 1):
        stride = stride_ahead(
            route, stance_on(feet), pose_over(TITAN, feet), [AHEAD], is_asked=True
        )
        walked += len(stride.order)
        feet = np.column_stack([stride.footholds, feet[:, 2]])
        feet[:, 2] = heights.height_at(feet[:, :2]) + TITAN.foot_radius
    assert any(looked_at)
    assert (len(plans) > 1) == touches


def test_strides_follow_the_plan_until_a_foot_goes_astray():
    heights = stones()
    route, feet = route_over(heights), standing_feet(TITAN, heights)
    first = stride_ahead(route, stance_on(feet), pose_over(TITAN, feet), [AHEAD])
    assert first.is_exact
    assert len(set(first.order)) == len(first.order) > 0
    unmoved = [leg for leg in range(4) if leg not in first.order]
    assert first.footholds[unmoved] == pytest.approx(feet[unmoved, :2])
    there = np.column_stack([first.footholds, heights.height_at(first.footholds) + 0.015])
    planned = route._steps
    second = stride_ahead(route, stance_on(there), first.place, [AHEAD])
    assert route._steps == planned[len(second.order) :]
    astray = there.copy()
    astray[second.order[0], 0] -= 0.05
    third = route_over(heights)
    third._steps, third._length, third._feet, third._target = planned, len(planned), there, AHEAD
    goal = stride_ahead(third, stance_on(astray), first.place, [AHEAD])
    still = [leg for leg in range(4) if leg not in goal.order]
    assert goal.footholds[still] == pytest.approx(astray[still, :2])


def test_a_foothold_that_a_leg_could_not_get_to_is_left_out():
    heights = stones()
    route, feet = route_over(heights), standing_feet(TITAN, heights)
    goal = stride_ahead(route, stance_on(feet), pose_over(TITAN, feet), [AHEAD])
    leg = goal.order[0]
    route.block(goal, leg)
    other = stride_ahead(route, stance_on(feet), pose_over(TITAN, feet), [AHEAD])
    lost = goal.footholds[leg]
    assert np.hypot(*(other.footholds[leg] - lost)) > OPTIONS.cell
