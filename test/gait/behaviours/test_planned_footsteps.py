"""Footsteps are planned in pieces, and the robot listens in between."""

import numpy as np
import pytest
from told_supervisor import measurement, shared_for

from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, Done
from quad_gait.behaviours.uneven_walk import UnevenWalk
from quad_gait.behaviours.wishes import FollowPlan, UseHeightMap
from quad_gait.footsteps import footstep_planner
from quad_gait.footsteps.foothold_map import FootholdMap
from quad_gait.footsteps.footstep_options import FootstepOptions
from quad_gait.footsteps.footstep_planner import FootstepPlanner
from quad_gait.state.state_estimator import StateEstimator
from quad_gait.uneven.uneven_options import UnevenOptions

TITAN = load_robot('titan_viii')
AHEAD = Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0)
UNEVEN = UnevenOptions(plans_footsteps=True)
SOON = 100
"""Measurements within which a plan over this ground is made, and far more than it takes."""


def trench(begin=0.45, end=0.60):
    """Lay level ground with a trench across the way."""
    level = HeightMap.level((-0.6, -0.8, 2.4, 0.8), 0.02)
    x = level.centers[..., 0]
    return level.with_heights(np.where((begin < x) & (x < end), -0.3, 0.0))


class Walk:
    """A robot that stands before a trench, with a plan across it."""

    def __init__(self):
        self.shared = shared_for(TITAN, uneven=UNEVEN)
        self.guidance, self.report = self.shared.guidance, self.shared.report
        self.behaviour = UnevenWalk(self.shared)
        self.behaviour.take(UseHeightMap(trench()))
        self.estimator = StateEstimator(TITAN)
        self.time = 1.0
        self.guidance.take_plan(FollowPlan(AHEAD), '')
        self.step = self.guidance.next_at_rest(self.state(), True)

    def state(self, **changes):
        self.time += 0.02
        return self.estimator.judge(measurement(TITAN, self.time, **changes))

    def begin(self):
        return self.behaviour.begin(self.state(), Done(Activity.WALKING, self.step))

    def update(self, **changes):
        return self.behaviour.update(self.state(**changes))

    def until_it_walks(self):
        """Update until a stride begins; return its command, and after how many updates."""
        for count in range(1, SOON):
            outcome = self.update()
            if outcome is not GO_ON:
                return outcome, count
        raise AssertionError('no stride begins')


@pytest.fixture
def walk():
    return Walk()


def test_each_piece_of_a_plan_looks_at_a_few_stances_and_the_whole_is_the_same(monkeypatch):
    searched, search = [], footstep_planner.search

    def counted(lattice, body, goal, tree, expansions):
        before = int(tree.state[2])
        end = search(lattice, body, goal, tree, expansions)
        searched.append(int(tree.state[2]) - before)
        return end

    monkeypatch.setattr(footstep_planner, 'search', counted)
    planner = FootstepPlanner(TITAN, FootstepOptions())
    ground = FootholdMap(TITAN, UNEVEN, FootstepOptions(), trench())
    feet = TITAN.neutral_feet.copy()
    feet[:, 2] = TITAN.foot_radius
    plans, pieces = [], planner.planning(feet, Pose2D(1.0, 0.0, 0.0), ground)
    while not plans:
        looked_at = len(searched)
        try:
            next(pieces)
        except StopIteration as end:
            plans.append(end.value)
        assert sum(searched[looked_at:]) <= 100
    assert sum(searched) > 200
    again = planner.plan(feet, Pose2D(1.0, 0.0, 0.0), ground)
    assert [step.leg for step in again.steps] == [step.leg for step in plans[0].steps]
    for one, other in zip(again.steps, plans[0].steps):
        assert np.array_equal(one.feet, other.feet)


def test_a_robot_stands_while_footsteps_are_planned_and_says_so(walk):
    assert walk.begin() is GO_ON
    assert walk.report.activity is Activity.WALKING
    assert walk.report.reason == 'planning footsteps'
    assert walk.behaviour.in_contact_at(walk.time).all()
    assert walk.behaviour.footholds().shape == (0, 3)
    command, count = walk.until_it_walks()
    assert count > 3
    assert command.trajectory is not None
    assert walk.report.reason.startswith('walking')
    assert walk.behaviour._goal.is_exact


def halt(guidance):
    guidance.stop()


def wait(guidance):
    guidance.plan_waits_for = 'the planner is gone'


def sit(guidance):
    guidance.is_to_sit = True


@pytest.mark.parametrize('wish', [halt, wait, sit])
def test_what_halts_a_robot_ends_the_planning_of_footsteps_at_once(walk, wish):
    walk.begin()
    assert walk.update() is GO_ON
    wish(walk.guidance)
    assert walk.update() == Done(Activity.STANDING)
    assert walk.update() == Done(Activity.STANDING)


def test_another_plan_does_not_begin_the_planning_of_footsteps_anew(walk):
    walk.begin()
    for _ in range(SOON):
        walk.guidance.take_plan(FollowPlan(AHEAD), '')
        if walk.update() is not GO_ON:
            break
    assert walk.behaviour._goal.is_exact


@pytest.mark.parametrize('forget', [UnevenWalk.forget, lambda each: each.come_to_rest(None)])
def test_what_interrupts_a_walk_ends_the_planning_of_footsteps(walk, forget, monkeypatch):
    monkeypatch.setattr('quad_gait.behaviours.behaviour.Behaviour.come_to_rest', lambda *_: False)
    walk.begin()
    forget(walk.behaviour)
    assert walk.update() == Done(Activity.STANDING)


def test_a_stride_that_was_planned_over_another_map_is_walked_and_the_next_is_planned_again(walk):
    walk.begin()
    walk.behaviour.take(UseHeightMap(trench(begin=0.46)))
    walk.until_it_walks()
    goal, route = walk.behaviour._goal, walk.behaviour._route
    assert goal.is_exact
    assert route._steps
    stance = walk.state().stance()
    assert not route._holds(stance, route._target)


@pytest.mark.parametrize('correction', [0.02, -0.02])
def test_a_correction_by_a_localiser_does_not_move_footholds_that_are_being_planned(correction):
    here, begun = Pose2D(0.0, 0.0, 0.0), []
    for pose in (here, Pose2D(correction, 0.0, 0.0)):
        walk = Walk()
        walk.behaviour.begin(walk.state().placed(here, here), Done(Activity.WALKING, walk.step))
        outcome = GO_ON
        while outcome is GO_ON and walk.time < 5.0:
            outcome = walk.behaviour.update(walk.state().placed(pose, here))
        begun.append(outcome.trajectory)
    # The same motion of the joints: feet that stand are where they stood.
    assert np.array_equal(begun[0].positions, begun[1].positions)
