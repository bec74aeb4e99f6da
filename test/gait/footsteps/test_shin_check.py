"""Shins over planned footsteps: where they would touch the ground, and plans on which none does."""

import numpy as np
import pytest

from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.footsteps import footstep_planner
from quad_gait.footsteps.foothold_map import FootholdMap
from quad_gait.footsteps.footstep import Footstep
from quad_gait.footsteps.footstep_options import FootstepOptions
from quad_gait.footsteps.footstep_planner import FootstepPlanner, steps_walked
from quad_gait.footsteps.shin_check import ShinCheck
from quad_gait.uneven.uneven_options import UnevenOptions

TITAN = load_robot('titan_viii')
LEVEL = HeightMap.level((-1.0, -1.0, 2.0, 1.0), 0.01)
LEFT_FORE, RIGHT_HIND = 0, 3
CLEARANCE = 0.01


def standing_on_level_ground():
    feet = TITAN.neutral_feet.copy()
    feet[:, 2] = TITAN.foot_radius
    return feet


def with_post(x, y, height):
    """Level ground with a post of one cell."""
    heights = LEVEL.heights.copy()
    column, row = np.floor((np.array([x, y]) - LEVEL.origin) / LEVEL.resolution).astype(int)
    heights[row, column] = height
    return LEVEL.with_heights(heights)


def two_steps():
    """The left fore foot goes far to its side, and the right hind one forwards after it."""
    feet = standing_on_level_ground()
    aside = feet.copy()
    aside[LEFT_FORE, 1] += 0.12
    ahead = aside.copy()
    ahead[RIGHT_HIND, 0] += 0.1
    steps = [
        Footstep(LEFT_FORE, aside[LEFT_FORE], aside),
        Footstep(RIGHT_HIND, ahead[RIGHT_HIND], ahead),
    ]
    return feet, steps


def found(heights, shift=0.0):
    feet, steps = two_steps()
    return ShinCheck(TITAN, 0.035, CLEARANCE, heights, shift).touching(feet, steps)


def shin_in_the_last_stance():
    """Foot and knee of the left fore leg while the right hind one swings [m]."""
    feet, steps = two_steps()
    # The body is over the middle of the swing, and its center of mass inside the other feet.
    moments = ShinCheck(TITAN, 0.035, CLEARANCE, LEVEL, 0.0)._moments(feet, steps)
    body, standing = list(moments)[2]
    foot = standing[LEFT_FORE]
    arm = (foot - body.position) @ body.rotation
    leg = TITAN.legs[LEFT_FORE]
    return foot, body.transform(leg.chain(leg.inverse(arm))[1])


def test_on_level_ground_no_shin_touches():
    assert found(LEVEL) == []


@pytest.mark.parametrize('fraction', [0.3, 0.5, 0.7])
def test_a_post_as_high_as_a_shin_is_found_and_a_lower_one_is_not(fraction):
    foot, knee = shin_in_the_last_stance()
    at = foot + fraction * (knee - foot)
    # Within the width of the shin it need not be quite below it.
    assert found(with_post(*at[:2], at[2] + 0.01)) == [(LEFT_FORE, *foot[:2])]
    near = TITAN.foot_radius + CLEARANCE + 3 * LEVEL.resolution
    lowest = foot[2] + max(0.0, fraction - near / np.hypot(*(knee - foot)[:2])) * (knee - foot)[2]
    assert found(with_post(*at[:2], lowest - 0.03)) == []


def test_a_map_is_taken_as_it_lies_under_the_feet():
    foot, knee = shin_in_the_last_stance()
    at = foot + 0.5 * (knee - foot)
    post = with_post(*at[:2], at[2] + 0.01)
    lower = post.with_heights(post.heights - 0.5)
    assert found(lower) == []
    assert found(lower, 0.5) == found(post)


def test_what_is_not_known_touches_nothing():
    assert found(LEVEL.with_heights(np.full_like(LEVEL.heights, np.nan))) == []


def test_feet_are_not_told_to_leave_where_they_stand_already():
    feet, _ = two_steps()
    walled = LEVEL.with_heights(LEVEL.heights + 0.5)
    touched = ShinCheck(TITAN, 0.035, CLEARANCE, walled, 0.0).touching(feet, two_steps()[1])
    assert {leg for leg, _, _ in touched} == {LEFT_FORE, RIGHT_HIND}
    assert ShinCheck(TITAN, 0.035, CLEARANCE, walled, 0.0).touching(feet, []) == []


def among_boxes(seed):
    """Ground with boxes 80 mm high, none near the start."""
    rng = np.random.default_rng(seed)
    x, y = np.moveaxis(LEVEL.centers, -1, 0)
    heights = LEVEL.heights.copy()
    for low, left in rng.uniform((0.35, -1.0), (2.0, 0.9), (24, 2)):
        side = rng.uniform(0.08, 0.25, 2)
        inside = (x > low) & (x < low + side[0]) & (y > left) & (y < left + side[1])
        heights[inside] = 0.08
    return LEVEL.with_heights(heights)


def touching_plans(options, seeds):
    """Count the plans of footsteps among boxes that are walked to where a shin touches one."""
    feet = standing_on_level_ground()
    planner, count = FootstepPlanner(TITAN, options), 0
    for seed in seeds:
        heights = among_boxes(seed)
        ground = FootholdMap(TITAN, UnevenOptions(), options, heights)
        steps = planner.plan(feet, Pose2D(1.2, 0.0, 0.0), ground).steps
        assert steps
        check = ShinCheck(TITAN, options.margin, CLEARANCE, heights, 0.0)
        count += bool(check.touching(feet, steps[: steps_walked(len(steps))]))
    return count


def test_plans_among_boxes_lead_where_shins_have_room(monkeypatch):
    seeds = range(12)
    assert touching_plans(FootstepOptions(), seeds) == 0
    monkeypatch.setattr(footstep_planner, '_MOST_PLANS', 1)
    assert touching_plans(FootstepOptions(blocks=(3,)), seeds) >= 2
