"""
The circle that a robot needs to turn on the spot: nothing leaves it, and something reaches it.
"""

import numpy as np
import pytest

from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_common.robot_files.walking_time import load_pace
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.cycle.gait_generator import generate_cycle, generate_largest_cycle
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.swept_radius import sweep_of_turns, swept_radius


def turning_limits(robot, name):
    gait = load_gait(name, robot)
    return MotionLimits(robot, turning_gait_for(gait, robot))


def test_a_robot_that_steps_on_the_spot_without_sway_needs_what_its_parts_take_up():
    robot = load_robot('titan_viii')
    cycle = generate_cycle(robot, load_gait('trot', robot), BodyMotion())
    pitch_axes, knees, feet = robot.stacked_legs.chain(cycle.joint_positions)
    radius = robot.own_parts.shape.radii
    of_points = [
        np.hypot(points[..., 0], points[..., 1]).max() + radius[link]
        for points, link in ((pitch_axes, 'hip'), (knees, 'thigh'), (feet, 'foot'))
    ]
    corner = np.hypot(*robot.body_size[:2]) / 2.0
    assert swept_radius(robot, cycle) == pytest.approx(max(*of_points, corner), abs=1e-9)


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize('name', available_robots())
@pytest.mark.parametrize('gait', ['crawl', 'wave', 'trot'])
def test_turns_of_any_size_stay_within_the_sweep_that_the_planner_knows(name, gait):
    robot = load_robot(name)
    limits = turning_limits(robot, gait)
    sweep = load_pace(name, gait).sweep
    assert sweep == pytest.approx(sweep_of_turns(robot, limits), abs=1e-6)
    for fraction in (-1.0, -0.6, -0.2, 0.2, 0.6, 1.0):
        turn = BodyMotion(turn=fraction * limits.largest_scale(BodyMotion(turn=np.sign(fraction))))
        cycle = generate_largest_cycle(robot, limits.gait_for(turn), turn)
        assert swept_radius(robot, cycle) <= robot.standing_radius + sweep + 5e-4
