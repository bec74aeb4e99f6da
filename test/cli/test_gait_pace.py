"""``quadwalk gait pace``, and whether the paces that ship are those of the gaits."""

import json
import math
from dataclasses import astuple
from pathlib import Path

import pytest

import quad_gait
from quad_cli.gait import PACED, derive_paces
from quad_cli.main import main
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import available_robots, load_robot, robot_file
from quad_common.robot_files.walking_time import load_pace
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.path_follower import PathFollower


@pytest.mark.parametrize('robot', available_robots())
def test_the_paces_that_ship_are_those_of_the_gaits(robot):
    for gait, pace in derive_paces(robot, PACED).items():
        assert astuple(load_pace(robot, gait)) == pytest.approx(astuple(pace), abs=1e-6)


def cycles_walked(robot, gait, start, plan):
    """Let the follower walk a robot that does just as it is told."""
    turning = turning_gait_for(gait, robot)
    follower = PathFollower(
        MotionLimits(robot, gait), MotionLimits(robot, turning), FollowerOptions()
    )
    follower.follow(plan, start)
    pose, cycles = start, 0
    step = follower.next_step(pose)
    while step is not None:
        cycles += 1
        pose = pose @ step.motion.end
        step = follower.next_step(pose, step.exit)
    return cycles


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize('robot', available_robots())
@pytest.mark.parametrize('gait', PACED)
def test_a_plan_is_walked_in_as_many_cycles_as_its_pace_says(robot, gait):
    pace = load_pace(robot, gait)
    model = load_robot(robot)
    start = Pose2D(0.0, 0.0, 0.4)
    for corners, yaw in (
        ([(0.0, 0.0), (1.03, 0.0)], 0.0),
        ([(0.0, 0.0), (1.5, 0.0), (1.5, 1.31)], 2.9),
        ([(0.0, 0.0), (0.73, 0.4), (0.2, 1.1), (-0.9, 1.0)], -1.2),
    ):
        plan = Plan.through(corners, yaw)
        walked = cycles_walked(model, load_gait(gait, model), start, plan)
        # A trot may turn a little farther to one side; the pace knows the other.
        assert pace.cycles(start, plan) - walked in ((0, 1) if gait == 'trot' else (0,))


def test_the_command_writes_paces(tmp_path, capsys):
    path = tmp_path / 'paces.yaml'
    assert main(['gait', 'pace', 'crawl', '--output', str(path), '--json']) == 0
    pace = json.loads(capsys.readouterr().out)['crawl']
    assert math.degrees(pace['turn']) == pytest.approx(44.18, abs=0.01)
    assert 'quadwalk gait pace' in path.read_text()


def test_a_gait_of_ones_own_is_added(tmp_path):
    robot, gait = tmp_path / 'mine.yaml', tmp_path / 'stride.yaml'
    robot.write_text(robot_file('titan_viii').read_text())
    crawl = (Path(quad_gait.__file__).parent / 'gaits' / 'crawl.yaml').read_text()
    gait.write_text(crawl.replace('name: crawl', 'name: stride'))
    assert main(['gait', 'pace', 'crawl', '--robot', str(robot)]) == 0
    assert main(['gait', 'pace', str(gait), '--robot', str(robot)]) == 0
    assert load_pace(robot, str(gait)) == load_pace(robot, 'crawl')
