"""A robot one of whose joints fails comes to a standstill, and says why."""

import math

import numpy as np
import pytest

pytest.importorskip('pybullet')

from quad_common.errors import GaitError
from quad_common.plan import Plan
from quad_common.planar_pose import Twist2D
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.faults.tipping import tipping
from quad_gait.supervisor import Supervisor
from quad_gait.uneven.uneven_options import UnevenOptions
from quad_lab.benchmarks.ground.bench_joint_failure import FailureCase, walk_and_fail
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_sim.engines.simulator import JointFailure

ROBOT = load_robot('titan_viii')
UP = np.array([0.0, 0.0, 1.0])
AHEAD = Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0)


class LameWalk:
    """A walk in physics during which a joint fails."""

    def __init__(self, joint, kind, time, gait='crawl', uneven=False, backend='bullet'):
        gaits = load_gait(gait, ROBOT)
        options = SupervisorOptions(uneven=UnevenOptions() if uneven else None)
        self.controller = Supervisor(ROBOT, gaits, turning_gait_for(gaits, ROBOT), options)
        self.walk = ClosedLoop(ROBOT, self.controller, backend)
        self.walk.simulation.plan_failure(JointFailure(joint, kind, time))
        self.walk.run(1.0)
        self.controller.set_plan(AHEAD)
        self.walk.run(30.0, lambda: self.controller.activity is Activity.LAME)

    def rests(self):
        """Go on until the robot has come to a standstill; return how long it took."""
        begun = self.walk.time
        done = self.walk.run(10.0, lambda: 'the robot st' in self.controller.reason)
        assert done, self.controller.reason
        before = self.walk.simulation.observe().position
        taken = self.walk.time - begun
        self.walk.run(1.0)
        assert self.walk.simulation.observe().position == pytest.approx(before, abs=2e-3)
        return taken

    @property
    def largest_tilt(self):
        return max(self.walk.record.tilts)


@pytest.fixture
def lame_walk():
    walks = []

    def make(*args, **kwargs):
        walks.append(LameWalk(*args, **kwargs))
        return walks[-1]

    yield make
    for walk in walks:
        walk.walk.close()


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize(
    ('joint', 'kind', 'time', 'feet', 'uneven'),
    [
        ('lh_hip_pitch_joint', 'free', 4.2, 'three legs', False),
        ('rf_hip_pitch_joint', 'free', 6.0, 'three legs', False),
        ('lf_knee_pitch_joint', 'free', 3.4, 'three legs', False),
        ('rh_hip_yaw_joint', 'stuck', 3.0, 'four feet', False),
        ('rf_knee_pitch_joint', 'stuck', 4.5, 'three legs', False),
        ('lh_hip_pitch_joint', 'free', 4.2, '', True),
        ('rh_hip_yaw_joint', 'stuck', 3.0, '', True),
        ('rf_knee_pitch_joint', 'stuck', 4.5, '', True),
    ],
)
def test_a_robot_whose_joint_fails_does_not_fall_stands_still_and_says_why(
    lame_walk, joint, kind, time, feet, uneven
):
    walk = lame_walk(joint, kind, time, uneven=uneven)
    assert walk.controller.activity is Activity.LAME
    assert joint in walk.controller.reason
    assert 'rad from its command' in walk.controller.reason
    assert walk.rests() < 7.0
    assert 'the robot stands on' in walk.controller.reason
    if not uneven:
        assert f'stands on {feet} with a margin of' in walk.controller.reason
    assert walk.largest_tilt < math.radians(25.0)


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize(
    ('joint', 'kind', 'time'),
    [
        (7, 'stuck', 2.23),
        (3, 'stuck', 2.16),
        (1, 'free', 3.3),
        (9, 'stuck', 2.86),
        # Legs that swing, and motors that do not pull.
        (0, 'free', 2.24),
        (4, 'free', 3.74),
        (0, 'free', 3.11),
        (3, 'free', 2.2),
        (5, 'stuck', 2.39),
        (5, 'free', 2.08),
        (2, 'stuck', 2.354),
    ],
)
def test_a_trotting_robot_stands_still_within_two_strides(joint, kind, time):
    outcome = walk_and_fail(FailureCase('titan_viii', 'trot', 'flat', joint, kind, time, 0))
    assert outcome.is_named
    assert not outcome.has_fallen
    assert outcome.still <= 2.0 * outcome.period


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize(
    ('joint', 'kind', 'time'),
    [
        # In the air: put down it hardly bears, and the body is not to rock over it.
        (4, 'free', 2.2766),
        # Under load, with little lever: the body goes over the others, and not down.
        (2, 'free', 2.6771),
        # Folded in its swing: its foot is not down when its plan says so.
        (11, 'free', 2.1901),
        # Jammed in the middle of its swing, never far from its command.
        (4, 'stuck', 3.7456),
    ],
)
def test_a_small_robot_that_trots_stands_still_within_two_strides_of_its_own(joint, kind, time):
    outcome = walk_and_fail(FailureCase('genibo', 'trot', 'flat', joint, kind, time, 0))
    assert outcome.is_named
    assert not outcome.has_fallen
    assert outcome.still <= 2.0 * outcome.period


def test_a_joint_that_jams_where_it_is_held_is_not_missed():
    # Genibo's roll joints do not turn in a trot straight on: this one does what it is told.
    outcome = walk_and_fail(FailureCase('genibo', 'trot', 'flat', 9, 'stuck', 2.1969, 0))
    assert not outcome.is_asked
    assert not outcome.is_named
    assert outcome.largest_tilt < math.radians(1.0)


def test_a_body_that_three_feet_cannot_level_is_not_tipped_over_but_sits():
    # Genibo's lame leg is folded under it: its other feet would lever it over that.
    outcome = walk_and_fail(FailureCase('genibo', 'crawl', 'flat', 2, 'free', 2.7, 607))
    assert outcome.reason.endswith('the robot sits on the ground')
    assert outcome.largest_tilt < math.radians(15.0)


def test_a_lame_robot_refuses_plans_and_steering_and_says_so(lame_walk):
    walk = lame_walk('rf_knee_pitch_joint', 'stuck', 4.5)
    walk.rests()
    controller, reason = walk.controller, walk.controller.reason
    with pytest.raises(GaitError, match='stays as it is: rf_knee_pitch_joint'):
        controller.sit()
    for wish, words in (
        (lambda: controller.set_plan(Plan.through([[0.0, 0.0], [0.0, 2.0]], 0.0)), 'the plan is'),
        (lambda: controller.set_twist(Twist2D(0.05)), 'steering is'),
    ):
        wish()
        assert controller.limit == f'{words} refused: rf_knee_pitch_joint does not answer'
        pose = walk.walk.simulation.observe().pose
        walk.walk.run(2.0)
        assert (controller.activity, controller.reason) == (Activity.LAME, reason)
        assert walk.walk.simulation.observe().pose.distance_to(pose) < 2e-3


def test_an_emergency_stop_does_not_make_a_lame_robot_forget_its_joint(lame_walk):
    walk = lame_walk('rf_knee_pitch_joint', 'stuck', 4.5)
    controller, simulation = walk.controller, walk.walk.simulation
    hold = controller.freeze()
    if hold is not None:
        simulation.accept(hold)
    controller.release()
    walk.walk.run(1.0)
    before = simulation.observe().joint_positions
    walk.walk.run(3.0)
    assert simulation.observe().joint_positions == pytest.approx(before, abs=0.01)
    assert 'is tried first' in controller.stand()
    walk.walk.run(3.0)
    assert controller.activity is Activity.LAME
    assert 'tried again, it still does not answer' in controller.reason


def test_stand_tries_the_joint_first_and_stands_up_only_if_it_answers(lame_walk):
    walk = lame_walk('lh_hip_pitch_joint', 'free', 4.2)
    controller = walk.controller
    walk.rests()
    assert 'is tried first' in controller.stand()
    walk.walk.run(3.0)
    assert controller.activity is Activity.LAME
    assert 'tried again, it still does not answer' in controller.reason
    # Repaired, and put back onto its feet.
    walk.walk.simulation.reset()
    controller.stand()
    assert walk.walk.run(10.0, lambda: controller.activity is Activity.STANDING), controller.reason
    controller.set_plan(Plan.through([[0.0, 0.0], [0.0, 1.0]], 0.0))
    assert walk.walk.run(10.0, lambda: controller.activity is Activity.TURNING), controller.reason


def test_where_joints_follow_exactly_a_stuck_one_is_named_as_well(lame_walk):
    walk = lame_walk('lf_hip_yaw_joint', 'stuck', 2.0, backend='kinematic')
    assert 'lf_hip_yaw_joint of leg lf does not move' in walk.controller.reason
    walk.rests()


def test_on_three_feet_of_its_initial_posture_a_robot_is_about_to_tip():
    # Its center of mass is above the line between two of them.
    for leg in range(len(LEGS)):
        carries = np.arange(len(LEGS)) != leg
        margin, _ = tipping(ROBOT, ROBOT.initial_joint_angles, UP, carries)
        assert margin == pytest.approx(0.0, abs=1e-6)


def test_a_body_that_tips_turns_until_a_hip_meets_the_ground():
    # Over its left feet alone: 301 mm from the center of mass, the right hips 402 mm away.
    carries = np.array([True, False, True, False])
    margin, angle = tipping(ROBOT, ROBOT.initial_joint_angles, UP, carries)
    away = ROBOT.neutral_feet[0, 1]
    assert margin == pytest.approx(-away)
    clear = ROBOT.standing_height - ROBOT.links['hip'].radius
    reach = away + ROBOT.legs[0].hip[1]
    assert angle == pytest.approx(math.atan2(clear, reach), abs=0.02)
    margin, angle = tipping(ROBOT, ROBOT.initial_joint_angles, UP, np.ones(4, dtype=bool))
    assert (margin, angle) == (pytest.approx(ROBOT.neutral_feet[0, 0]), 0.0)
