"""Planned motions keep the robot's own parts apart, and say in words where they would not."""

from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import PartsTooNear
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_check import check_gait
from quad_gait.cycle.gait_generator import (
    generate_cycle,
    generate_largest_cycle,
    generate_steady_cycle,
)
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.cycle.part_check import check_nearing_parts

GENIBO, CUHK = load_robot('genibo'), load_robot('cuhk')
WAVE = load_gait('wave', GENIBO)
SIDEWAYS = BodyMotion(left=0.12)
"""Within what legs and joints of genibo can do in a cycle, but not what its body leaves free."""


def test_a_cycle_that_would_bring_a_thigh_into_the_body_is_refused_with_its_facts():
    gait = MotionLimits(GENIBO, WAVE).gait_for(SIDEWAYS)
    with pytest.raises(PartsTooNear) as caught:
        generate_steady_cycle(GENIBO, gait, SIDEWAYS)
    error = caught.value
    assert error.first == 'base_link'
    assert error.second.endswith('_thigh')
    assert error.least == GENIBO.own_parts.least
    assert error.clearance < error.least
    assert 0.0 <= error.time <= error.duration == WAVE.cycle_period
    for told in (error.first, error.second, f'{error.time:.2f} s', f'{1e3 * error.least:.2f} mm'):
        assert told in str(error)


@pytest.mark.parametrize(
    'direction',
    [BodyMotion(left=1.0), BodyMotion(left=-1.0), BodyMotion(turn=1.0), BodyMotion(turn=-1.0)],
)
@pytest.mark.parametrize('name', ['wave', 'crawl'])
def test_the_largest_motions_of_a_slim_robot_keep_its_parts_apart(name, direction):
    limits = MotionLimits(GENIBO, load_gait(name, GENIBO))
    largest = direction.scaled(limits.largest_scale(direction))
    cycle = generate_steady_cycle(GENIBO, limits.gait_for(direction), largest)
    assert GENIBO.own_parts.nearest(cycle.joint_positions).spare >= 0.0


def test_a_cycle_is_shortened_until_parts_keep_clear_and_says_why():
    wanted = BodyMotion(left=0.062)
    crawl = MotionLimits(GENIBO, load_gait('crawl', GENIBO)).gait_for(wanted)
    cycle = generate_largest_cycle(GENIBO, crawl, wanted)
    assert 0.0 < cycle.motion.left < wanted.left
    assert 'base_link and ' in cycle.limit
    assert GENIBO.own_parts.nearest(cycle.joint_positions).spare >= 0.0


def test_limits_name_the_parts_that_forbid_more():
    reason = MotionLimits(GENIBO, WAVE).reason(SIDEWAYS)
    assert 'base_link and ' in reason
    assert '_thigh would come within' in reason


def test_the_check_says_which_parts_come_nearest_how_near_and_when():
    for motion in check_gait(GENIBO, WAVE).motions:
        assert motion.clearance >= GENIBO.own_parts.least
        assert 0.0 <= motion.nearest_at <= 1.0
        assert motion.nearest_parts[0] == 'base_link'
        assert ('base_link' in motion.limit) == (motion.direction not in ('forward', 'backward'))


def test_a_knee_that_would_come_to_the_ground_is_refused():
    # Legs with knees so thick that a crouch of the body leaves them no room.
    thigh = replace(CUHK.links['thigh'], radius=0.014)
    thick = replace(CUHK, links={**CUHK.links, 'thigh': thigh})
    assert not thick.own_parts.kneels
    crawl = load_gait('crawl', thick)
    generate_cycle(thick, crawl, BodyMotion(forward=0.01))
    with pytest.raises(PartsTooNear, match='_thigh and ground would') as caught:
        generate_cycle(thick, crawl, BodyMotion(forward=0.066))
    assert caught.value.second == 'ground'


def test_parts_that_are_too_near_already_may_go_apart_but_not_nearer():
    apart = GENIBO.initial_joint_angles
    near = apart.copy()
    near[0, 0] = -0.55
    assert GENIBO.own_parts.too_near(near[None]) is not None
    fractions = np.linspace(0.0, 1.0, 11)[:, None, None]
    times = fractions[:, 0, 0]
    check_nearing_parts(GENIBO, times, near + fractions * (apart - near))
    check_nearing_parts(GENIBO, times, np.repeat(near[None], 11, axis=0))
    with pytest.raises(PartsTooNear, match='base_link and lf_thigh'):
        check_nearing_parts(GENIBO, times, apart + fractions * (near - apart))
