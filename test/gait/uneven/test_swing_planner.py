"""Swings are chosen of many kinds: the same ones, however quickly the others are passed over."""

from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import GaitError, ShinTooNear, SupportTooNarrow
from quad_common.footing.shin_room import ShinRoom
from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.state.body_placement import BodyPose
from quad_gait.state.stance import Stance
from quad_gait.uneven import swing_planner
from quad_gait.uneven.ground_model import GroundModel
from quad_gait.uneven.swing_planner import SwingPlanner
from quad_gait.uneven.uneven_options import UnevenOptions

ROBOT = load_robot('titan_viii')
JOINTS = ROBOT.initial_joint_angles
FEET = ROBOT.foot_positions(JOINTS)
STANCE = Stance(0.0, BodyPose(np.zeros(3), 0.0, 0.0, 0.0), FEET, JOINTS, lambda: np.ones(4))
UNDER = FEET - [0.0, 0.0, ROBOT.foot_radius]
LEVEL = HeightMap.level((-2.0, -2.0, 2.0, 2.0), 0.02)
LEVEL_ROOM = ShinRoom(ROBOT, 0.0, LEVEL)


def hole(depth):
    """Ground with a hole where the left fore foot is to go."""
    off = np.hypot(*np.moveaxis(LEVEL.centers - FEET[0, :2] - [0.3, 0.0], -1, 0))
    return GroundModel.through(UNDER, LEVEL.with_heights(np.where(off < 0.2, -depth, 0.0)))


def planned(ground, stride, kind):
    """What is planned of a stride: its joints and what is said, or why there is none."""
    planner = SwingPlanner(ROBOT, UnevenOptions(), 0.06)
    try:
        swing = getattr(planner, kind)(STANCE, None, ground, 0, FEET[0, :2] + [stride, 0.0])
    except GaitError as error:
        return str(error)
    return swing.limit, swing.motion.positions.tobytes()


@pytest.mark.parametrize('kind', ['swing', 'swing_onto'])
@pytest.mark.parametrize('depth', [0.06, 0.4])
def test_a_quick_look_passes_over_no_swing_that_is_possible(monkeypatch, kind, depth):
    strides = (0.15, 0.3, 0.5)
    quick = [planned(hole(depth), stride, kind) for stride in strides]
    monkeypatch.setattr(SwingPlanner, '_may_reach', lambda *_: True)
    assert quick == [planned(hole(depth), stride, kind) for stride in strides]


def standing(feet):
    """The robot with its feet at some places, the body as in the initial posture."""
    joints = [kinematics.inverse(foot) for kinematics, foot in zip(ROBOT.legs, feet, strict=True)]
    return replace(STANCE, feet=feet, joint_positions=np.array(joints))


def left_behind(leg):
    """The robot with a foot that has not come with the others: its shin leans."""
    feet = FEET.copy()
    feet[leg, :2] += [-0.1, 0.12 * np.sign(FEET[leg, 1])]
    return standing(feet)


def chosen(monkeypatch, now, ground):
    """What is said of a step of the left fore foot, and its course."""
    courses, along = [], SwingPlanner._swing_along

    def noted(self, now, commanded, course):
        courses.append(course)
        return along(self, now, commanded, course)

    monkeypatch.setattr(SwingPlanner, '_swing_along', noted)
    planner = SwingPlanner(ROBOT, UnevenOptions(), 0.06)
    swing = planner.swing(now, None, ground, 0, now.feet[0, :2] + [0.1, 0.0])
    return swing.limit, courses[-1]


def touches(ground, course):
    """Tell whether a shin comes too near to the ground where the body goes."""
    try:
        course.check_shins(ROBOT, ground, UnevenOptions().shin_clearance)
    except ShinTooNear:
        return True
    return False


@pytest.mark.parametrize('leg', [2, 3])
def test_the_body_goes_where_shins_of_legs_that_stand_are_free(monkeypatch, leg):
    now = left_behind(leg)
    level = GroundModel.through(now.feet - [0.0, 0.0, ROBOT.foot_radius], LEVEL)
    limit, before = chosen(monkeypatch, now, level)
    assert limit == ''
    body = before.body
    points = LEVEL_ROOM.points(body.position[None], body.rotation[None], now.feet[None])[0, leg]
    foot, lean = points[0, :2], points[-1, :2] - points[0, :2]
    away = LEVEL.centers - foot
    is_under = (away @ lean / np.hypot(*lean) > 0.08) & (np.linalg.norm(away, axis=-1) < 0.16)

    def stone(height):
        """Ground with a stone under the shin, near its foot."""
        return replace(level, height_map=LEVEL.with_heights(np.where(is_under, height, 0.0)))

    # Just so high that the shin comes too near to it.
    height = next(h for h in np.arange(0.01, 0.2, 0.002) if touches(stone(h), before))
    limit, after = chosen(monkeypatch, now, stone(height))
    assert not touches(stone(height), after)
    assert not limit or limit.endswith(f'the shin of {LEGS[leg]} would come too near to the ground')


def test_a_step_is_done_with_a_shin_at_an_edge_where_none_is_without(monkeypatch):
    level = GroundModel.through(UNDER, LEVEL)
    before = planned(level, 0.2, 'swing')

    def touch(*_):
        raise ShinTooNear('lf')

    monkeypatch.setattr(ShinRoom, 'check', touch)
    assert isinstance(before, tuple)
    assert planned(level, 0.2, 'swing') == before


@pytest.mark.parametrize('rise', [0.15, 0.3, 0.5])
def test_shins_change_nothing_on_stairs_and_where_no_map_is(monkeypatch, rise):
    """There shins are at edges anyway, or nobody knows: what is planned is as if nobody looked."""

    def choices():
        stairs = np.where(LEVEL.centers[..., 0] > 0.1, 0.08, 0.0)
        model = GroundModel.through(UNDER, LEVEL.with_heights(stairs))
        steep = replace(model, slope=np.array([rise, 0.0]))
        blind = replace(steep, height_map=None)
        return [planned(ground, 0.25, 'swing') for ground in (steep, blind)]

    before = choices()
    assert any(isinstance(each, tuple) for each in before)

    def looked(*_):
        raise AssertionError('nobody should look')

    monkeypatch.setattr(ShinRoom, 'check', looked)
    monkeypatch.setattr(swing_planner, 'LEVEL_VARIANTS', [])
    assert choices() == before


@pytest.mark.parametrize('leg', [2, 3])
def test_a_foot_that_was_left_behind_is_fetched_with_less_margin(leg):
    feet = FEET - [[0.265 * (leg == other), 0.0, 0.0] for other in range(4)]
    now = standing(feet)
    ground = GroundModel.through(feet - [0.0, 0.0, ROBOT.foot_radius], LEVEL)
    options = UnevenOptions()
    strict = replace(options, least_margin=options.margin)
    with pytest.raises(GaitError, match=f'foot {LEGS[leg]} would have to be'):
        SwingPlanner(ROBOT, strict, 0.06).swing(now, None, ground, leg, FEET[leg, :2])
    swing = SwingPlanner(ROBOT, options, 0.06).swing(now, None, ground, leg, FEET[leg, :2])
    assert swing.limit == ''


def test_a_foothold_is_looked_for_once_for_each_length_of_a_step(monkeypatch):
    looked, best = [], GroundModel.best_foothold

    def counted(self, wanted, choice):
        looked.append(tuple(wanted))
        return best(self, wanted, choice)

    monkeypatch.setattr(GroundModel, 'best_foothold', counted)
    # The leg gets to none of them but that where the foot stands.
    planned(hole(0.4), 0.5, 'swing')
    assert len(looked) == len(set(looked)) > 2


@pytest.mark.parametrize('behind', [0.1, 0.14])
def test_the_body_stays_over_feet_that_were_left_behind(behind):
    # Fore feet that did not swing are behind, and the place of the body is far ahead.
    feet = FEET.copy()
    feet[:2, 0] -= behind
    joints = ROBOT.joint_angles(feet)
    now = Stance(0.0, BodyPose(np.zeros(3), 0.0, 0.0, 0.0), feet, joints, lambda: np.ones(4))
    under = feet - [0.0, 0.0, ROBOT.foot_radius]
    options = UnevenOptions(foothold_reach=0.3)
    planner = SwingPlanner(ROBOT, options, 0.06)
    motion = planner.shift(now, None, GroundModel.through(under), Pose2D(0.9, 0.0, 0.0))
    end = motion.positions[-1]
    center, ends = ROBOT.center_of_mass(end), ROBOT.foot_positions(end)
    assert ends[:2, 0].min() - center[0] > 0.8 * options.margin


def test_no_foot_is_lifted_while_the_others_are_nearly_in_line():
    feet = FEET.copy()
    feet[2] = 0.5 * (feet[0] + feet[3]) + [0.01, -0.01, 0.0]
    now = Stance(0.0, BodyPose(np.zeros(3), 0.0, 0.0, 0.0), feet, JOINTS, lambda: np.ones(4))
    planner = SwingPlanner(ROBOT, UnevenOptions(), 0.06)
    ground = GroundModel.through(UNDER)
    ahead = feet[1, :2] + [0.1, 0.0]
    with pytest.raises(
        SupportTooNarrow, match=r'leg rf cannot swing: .* in line, with room .* 7 mm'
    ):
        planner.swing(now, None, ground, 1, ahead)
    # A foot that is in the air already has to come down somewhere.
    try:
        planner.swing(now, None, ground, 1, ahead, stands=False)
    except SupportTooNarrow:
        pytest.fail('refused')
    except GaitError:
        pass


@pytest.mark.parametrize('leg', range(4))
@pytest.mark.parametrize('name', ['a1', 'titan_viii'])
def test_legs_that_stay_behind_count_where_the_body_goes_far(name, leg):
    robot = load_robot(name)
    scale, options = robot.relative_size, UnevenOptions()
    # The body is at the far end of its room over the feet.
    feet = robot.neutral_feet.copy()
    feet += scale * np.array([*(-0.1 * np.sign(robot.neutral_feet[leg, :2])), 0.03])
    joints = robot.joint_angles(feet)
    now = Stance(0.0, BodyPose(np.zeros(3), 0.0, 0.0, 0.0), feet, joints, lambda: np.ones(4))
    under = feet - [0.0, 0.0, robot.foot_radius]
    planner = SwingPlanner(robot, options, 0.06 * scale)
    swing = planner.swing_onto(now, None, GroundModel.through(under), leg, feet[leg, :2])
    lifted = swing.motion.positions[swing.feels_from]
    center = robot.center_of_mass(lifted)[:2]
    corners = np.delete(robot.foot_positions(lifted)[:, :2], leg, axis=0)
    edges = np.roll(corners, -1, axis=0) - corners
    arms = center - corners
    inside = edges[:, 0] * arms[:, 1] - edges[:, 1] * arms[:, 0]
    inside = inside * np.sign(inside.sum()) / np.linalg.norm(edges, axis=1)
    assert inside.min() > 0.8 * scale * options.margin
