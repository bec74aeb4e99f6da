"""The robot's own parts: how far apart they are, and that no quick test misses two that touch."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from quad_common.robot.own_parts import LEAST_CLEARANCE
from quad_common.robot.robot_build import LEGS
from quad_common.robot.robot_shape import BODY, LINKS
from quad_common.robot_files.robot_file import available_robots, load_robot

ROBOTS = {name: load_robot(name) for name in available_robots()}

each_robot = pytest.mark.parametrize('robot', ROBOTS.values(), ids=ROBOTS)


def random_postures(robot, count, spread=1.0, seed=5):
    """Draw postures around the initial one, shape (count, 4, 3)."""
    drawn = np.random.default_rng(seed).uniform(-0.5, 0.5, (count, 4, 3))
    angles = robot.initial_joint_angles + spread * drawn * (robot.upper - robot.lower)
    return np.clip(angles, robot.lower, robot.upper)


def points_of(robot, part, posture, count=150):
    """Lay points along a part's axis, by the kinematics of its leg alone: (count, 3)."""
    leg = robot.legs[LEGS.index(part[:2])]
    pitch_axis, knee, foot = leg.chain(posture[LEGS.index(part[:2])])
    ends = {
        'hip': (np.asarray(leg.hip), pitch_axis),
        'thigh': (pitch_axis, knee),
        'calf': (knee, foot),
        'foot': (foot, foot),
    }[part[3:]]
    return ends[0] + np.linspace(0.0, 1.0, count)[:, None] * (ends[1] - ends[0])


def tried_clearance(robot, pair, posture):
    """Measure a clearance by trying many points."""
    second = points_of(robot, pair.second, posture)
    radius = robot.links[pair.second[3:]].radius
    if pair.first == BODY:
        outside = np.abs(second - robot.body_center) - 0.5 * np.array(robot.body_size)
        return np.linalg.norm(np.maximum(outside, 0.0), axis=1).min() - radius
    first = points_of(robot, pair.first, posture)
    distances = np.linalg.norm(first[:, None] - second[None], axis=-1)
    return distances.min() - radius - robot.links[pair.first[3:]].radius


@each_robot
def test_clearances_are_what_many_points_on_the_parts_give(robot):
    shape = robot.own_parts.shape
    postures = random_postures(robot, 3)
    for posture, clearances in zip(postures, shape.clearances(postures)):
        tried = [tried_clearance(robot, pair, posture) for pair in shape.pairs]
        # Points along a link are a 150th of it apart.
        assert clearances == pytest.approx(tried, abs=0.02 * robot.legs[0].calf_length)


@each_robot
def test_every_two_parts_are_compared_once_but_those_that_a_joint_connects(robot):
    pairs = robot.own_parts.shape.pairs
    parts = [BODY, *(f'{leg}_{link}' for leg in LEGS for link in LINKS)]
    connected = [(BODY, f'{leg}_hip') for leg in LEGS]
    for leg in LEGS:
        connected += [(f'{leg}_{a}', f'{leg}_{b}') for a, b in pairwise(LINKS)]
    expected = {frozenset((a, b)) for a in parts for b in parts if a != b}
    expected -= {frozenset(pair) for pair in connected}
    assert {frozenset((pair.first, pair.second)) for pair in pairs} == expected
    assert len(pairs) == len(expected)


@each_robot
def test_a_mirrored_posture_has_mirrored_clearances(robot):
    shape = robot.own_parts.shape
    postures = random_postures(robot, 20)
    mirrored = postures[:, [1, 0, 3, 2]] * [-1.0, 1.0, 1.0]
    other = str.maketrans('lr', 'rl')

    def mirror(part):
        return part if part == BODY else part[0].translate(other) + part[1:]

    names = [frozenset((pair.first, pair.second)) for pair in shape.pairs]
    partner = [
        names.index(frozenset((mirror(pair.first), mirror(pair.second)))) for pair in shape.pairs
    ]
    there, back = shape.clearances(postures), shape.clearances(mirrored)
    assert back[:, partner] == pytest.approx(there, abs=1e-9)


@pytest.mark.sweep(kept=5)
@each_robot
@pytest.mark.parametrize('spread', [0.1, 0.3, 0.6, 1.0])
def test_what_is_found_quickly_is_what_is_measured(robot, spread):
    parts = robot.own_parts
    for postures in random_postures(robot, 600, spread).reshape(30, 20, 4, 3):
        found, nearest = parts.too_near(postures), parts.nearest(postures)
        assert (found is not None) == (nearest.spare < 0.0)
        if found is not None:
            assert found == nearest


@each_robot
def test_no_group_of_parts_that_are_too_near_is_left_out(robot):
    shape, planes = robot.own_parts.shape, robot.own_parts._planes
    postures = random_postures(robot, 1000, 0.8, seed=6)
    chain = shape.legs.chain(postures)
    segments = shape.segments(chain)
    doubts = {id(group): mask for group, mask in planes.doubts(chain, postures)}
    for group in shape.groups:
        near = shape.group_clearances(group, segments).min(axis=1) < robot.own_parts.least
        assert not np.any(near & ~doubts.get(id(group), np.zeros(len(near), dtype=bool)))


@each_robot
def test_nothing_is_too_near_in_the_initial_posture_of_the_robots_that_ship(robot):
    parts = robot.own_parts
    assert parts.ignored == ()
    assert not parts.kneels
    assert parts.nearest(robot.initial_joint_angles[None]).spare > 0.0


def test_the_least_clearance_grows_with_the_robot():
    for robot in ROBOTS.values():
        assert robot.own_parts.least == pytest.approx(LEAST_CLEARANCE * robot.hip_height / 0.243)


def test_a_thigh_that_rolls_under_the_body_is_found():
    robot = ROBOTS['genibo']
    angles = np.tile(robot.initial_joint_angles, (3, 1, 1))
    # The left front leg inward.
    angles[1, 0, 0], angles[2, 0, 0] = -0.3, -0.6
    found = robot.own_parts.too_near(angles)
    assert (found.pair.first, found.pair.second) == (BODY, 'lf_thigh')
    assert found.sample == 2
    assert found.clearance < 0.0
    assert robot.own_parts.too_near(angles[:1]) is None


def test_feet_may_come_near_but_not_into_one_another():
    robot = ROBOTS['cuhk']
    for gap, is_found in ((0.0005, False), (-0.0005, True)):
        feet = robot.neutral_feet.copy()
        feet[:2, 1] = [robot.foot_radius + gap / 2.0, -robot.foot_radius - gap / 2.0]
        found = robot.own_parts.too_near(robot.joint_angles(feet)[None])
        assert (found is not None) == is_found
        if is_found:
            assert (found.pair.first, found.pair.second) == ('lf_foot', 'rf_foot')
            assert found.clearance == pytest.approx(gap, abs=1e-9)


def test_parts_that_overlap_in_the_initial_posture_are_named_and_left_out():
    robot = ROBOTS['genibo']
    length, _, height = robot.body_size
    wide = replace(robot, body_size=(length, 0.12, height))
    angles = wide.initial_joint_angles[None]
    assert {str(pair) for pair in wide.own_parts.ignored} == {
        f'{BODY} and {leg}_thigh' for leg in LEGS
    }
    assert wide.own_parts.too_near(angles) is None
    # Other parts are watched as before.
    folded = angles.copy()
    folded[0, 0, 0] = folded[0, 1, 0] = 0.0
    feet = wide.neutral_feet.copy()
    feet[:2, 1] = 0.0
    crossed = wide.own_parts.too_near(wide.joint_angles(feet)[None])
    assert 'rf_' in crossed.pair.second


def test_a_knee_near_the_ground_is_found():
    robot = ROBOTS['cuhk']
    parts = robot.own_parts
    chain = robot.stacked_legs.chain(robot.initial_joint_angles[None])
    knee = float(chain[1][..., 2].min())
    radius = robot.links['thigh'].radius
    for spare, is_found in ((1e-4, False), (-1e-4, True)):
        ground = np.array([knee - radius - parts.least - spare])
        found = parts.too_low(chain, ground)
        assert (found is not None) == is_found
    assert found.pair.second == 'ground'
    assert found.spare == pytest.approx(-1e-4)


@pytest.mark.parametrize('name', ['genibo', 'titan_viii'])
def test_a_leg_keeps_clear_just_where_none_of_its_pairs_is_too_near(name):
    robot, rng = ROBOTS[name], np.random.default_rng(4)
    parts, shape, leg = robot.own_parts, robot.shape, 2
    angles = np.repeat(robot.initial_joint_angles[None], 400, axis=0)
    angles[:, leg] = rng.uniform(robot.lower[leg], robot.upper[leg], (400, 3))
    own = [k for k, pair in enumerate(shape.pairs) if _is_of(pair, LEGS[leg])]
    clear = (shape.clearances(angles)[:, own] >= parts.least).all(axis=1)
    assert np.array_equal(parts.leg_keeps_clear(leg, angles[:, leg]), clear)
    assert 0.05 < clear.mean() < 0.95


def _is_of(pair, leg):
    """Tell whether both parts are the leg's, or one is the body."""
    return all(part == BODY or part.startswith(f'{leg}_') for part in (pair.first, pair.second))
