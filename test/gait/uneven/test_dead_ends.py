"""Walks over uneven ground that led into dead ends, and how they end now."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import CommandOutsideLimits, GaitError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.map_file import load_map
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.resources import sample_map
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait
from quad_gait.faults.command_gate import CommandGate
from quad_gait.uneven.swing_planner import SwingPlanner
from quad_gait.uneven.ways_out import ORDER, WayOut
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import controller_for, for_uneven_ground
from quad_lab.closed_loop.ground_walk import GroundWalk, make_scene
from quad_sim.world.terrain_spec import make_terrain, specs_from_text
from quad_sim.world.world import world_from_map

TITAN = load_robot('titan_viii')
GENIBO = load_robot('genibo')
ORIGIN = Pose2D(0.0, 0.0, 0.0)
BEYOND = 1.0
"""By which the ground of a map goes on beyond it, as sim_node lays it [m]."""


class NoSwing(GaitError):
    """What a swing that cannot be planned raises here."""


def controller_of(robot):
    controller = controller_for(
        robot, load_gait('crawl', robot), for_uneven_ground(SupervisorOptions())
    )
    said = []

    def note(_):
        limit = controller.limit
        if limit and said[-1:] != [limit]:
            said.append(limit)

    return controller, said, note


def walked_on_level_ground(plan, longest=120.0):
    """Walk without physics; return the loop, its controller and what was said of limits."""
    controller, said, note = controller_of(TITAN)
    walk = ClosedLoop(TITAN, controller, 'kinematic', start=plan.poses[0])
    walk.on_observation.append(note)
    walk.run(0.5)
    controller.set_plan(plan)
    walk.run(longest, lambda: controller.activity.is_terminal)
    return walk, controller, said


def walked_over_level_map(distance, longest):
    """Walk without physics, over a map; return the loop, its controller and what was said."""
    controller, said, note = controller_of(TITAN)
    walk = ClosedLoop(TITAN, controller, 'kinematic')
    walk.on_observation.append(note)
    walk.run(0.5)
    controller.set_height_map(HeightMap.level((-1.0, -1.0, distance + 1.2, 1.0), 0.05))
    controller.set_plan(Plan.through([[0.0, 0.0], [distance, 0.0]], 0.0))
    walk.run(longest, lambda: controller.activity.is_terminal)
    return walk, controller, said


def swings_only_if(monkeypatch, is_possible):
    """Let swings be planned only where a function of leg, start and place allows it."""
    swing = SwingPlanner.swing

    def planned(self, now, commanded, ground, leg, place, stands=True):
        if not is_possible(LEGS[leg], now.feet[leg, :2], place):
            raise NoSwing(f'{LEGS[leg]} cannot swing')
        return swing(self, now, commanded, ground, leg, place)

    monkeypatch.setattr(SwingPlanner, 'swing', planned)


AHEAD = Plan.through([[0.0, 0.0], [0.3, 0.0]], 0.0)


def test_where_no_foot_can_swing_all_ways_out_are_tried_and_the_robot_stops_and_asks(monkeypatch):
    swings_only_if(monkeypatch, lambda *_: False)
    walk, controller, _ = walked_on_level_ground(AHEAD)
    assert controller.activity is Activity.STOPPED
    assert 'another path is needed' in controller.reason
    assert 'cannot swing' in controller.reason
    assert controller.impassable is not None
    assert controller.impassable.distance_to(ORIGIN) < 0.01
    assert abs(controller.impassable.yaw) < 0.01
    assert controller.in_contact_at(walk.time).all()
    # It wants to go on as soon as there is another path.
    assert controller.wanted_plan is AHEAD
    controller.set_plan(Plan.through([[0.0, 0.0], [0.0, 0.3]], math.pi / 2))
    walk.run(1.0)
    assert controller.impassable.distance_to(ORIGIN) < 0.01


def test_the_ways_out_are_said_in_their_order(monkeypatch):
    swings_only_if(monkeypatch, lambda *_: False)
    heard = []
    controller, _, _ = controller_of(TITAN)
    ways = controller._guidance.ways_out
    take = ways.take

    def heard_take(step):
        chosen = take(step)
        heard.append(chosen.remark)
        return chosen

    monkeypatch.setattr(ways, 'take', heard_take)
    walk = ClosedLoop(TITAN, controller, 'kinematic')
    walk.run(0.5)
    controller.set_plan(AHEAD)
    walk.run(60.0, lambda: controller.activity.is_terminal)
    strides = [way for way in ORDER if way not in (WayOut.FOOTSTEPS, WayOut.DETOUR)]
    assert [remark.split(' is tried')[0] for remark in heard if remark] == [
        way.value for way in strides
    ]


def test_where_no_stride_gets_on_footsteps_are_planned_over_the_height_map(monkeypatch):
    # Onto footholds that were chosen for it a foot swings by another method.
    swings_only_if(monkeypatch, lambda *_: False)
    walk, _, said = walked_over_level_map(0.3, 60.0)
    planned = f'{WayOut.FOOTSTEPS.value} is tried'
    assert any(text.startswith(planned) for text in said)
    # Strides are to correct the pose there: they cannot, here.
    pose = walk.simulation.observe().pose
    assert pose.distance_to(Pose2D(0.3, 0.0, 0.0)) < 0.05


def test_where_footsteps_have_led_out_of_a_dead_end_strides_go_on(monkeypatch):
    begun = []

    def is_possible(leg, start, place):
        is_out = place[0] > TITAN.neutral_feet[LEGS.index(leg), 0] + 0.4
        begun.append(is_out)
        return is_out

    swings_only_if(monkeypatch, is_possible)
    _, controller, said = walked_over_level_map(1.5, 200.0)
    assert controller.activity is Activity.ARRIVED
    assert sum(text.startswith(f'{WayOut.FOOTSTEPS.value} is tried') for text in said) == 1
    # Three strides or more of the four feet after the footsteps.
    assert sum(begun) >= 12


def test_a_foot_that_cannot_swing_first_swings_later(monkeypatch):
    order = [swing.leg for swing in load_gait('crawl', TITAN).swings]
    first, swung = order[0], []

    def is_possible(leg, start, place):
        if leg == first and not swung:
            return False
        if np.hypot(*(place - start)) > 0.01:
            swung.append(leg)
        return True

    swings_only_if(monkeypatch, is_possible)
    _, controller, said = walked_on_level_ground(AHEAD)
    assert controller.activity is Activity.ARRIVED
    assert swung[:2] == [order[1], first]
    assert said[0] == f'another foot goes first: {first} cannot swing'


def test_a_foot_that_cannot_swing_at_all_stays_and_the_body_goes_on(monkeypatch):
    last = load_gait('crawl', TITAN).swings[-1].leg
    tries = []

    def is_possible(leg, start, place):
        tries.append(leg)
        return leg != last or tries.count(last) > 1

    swings_only_if(monkeypatch, is_possible)
    _, controller, said = walked_on_level_ground(AHEAD)
    assert controller.activity is Activity.ARRIVED
    assert any(text.startswith('a foot stays where it is') for text in said)


def test_a_turn_that_never_gets_on_ends(monkeypatch):
    # The feet swing, but are put down where they stood: no swing has any effect.
    swing = SwingPlanner.swing

    def in_place(self, now, commanded, ground, leg, place, stands=True):
        return swing(self, now, commanded, ground, leg, now.feet[leg, :2])

    monkeypatch.setattr(SwingPlanner, 'swing', in_place)
    walk, controller, _ = walked_on_level_ground(Plan((ORIGIN, Pose2D(0.0, 0.0, 2.0))), 600.0)
    assert controller.activity in (Activity.STOPPED, Activity.BLOCKED)
    assert walk.time < 300.0


def stopped_in_a_swing(monkeypatch, wished=lambda controller: None):
    """Walk until a foot is in the air, wish for something, and let the last gate refuse."""
    controller, _, _ = controller_of(TITAN)
    walk = ClosedLoop(TITAN, controller, 'kinematic')
    walk.run(0.5)
    controller.set_plan(SHORT)
    assert walk.run(5.0, lambda: not controller.in_contact_at(walk.time).all())
    wished(controller)

    def refuses(gate, trajectory, time, measured):
        raise CommandOutsideLimits('lf_knee_pitch_joint', 'velocity', 9.0, (-6.3, 6.3), 'rad/s')

    with monkeypatch.context() as patch:
        patch.setattr(CommandGate, 'admit', refuses)
        assert walk.run(5.0, lambda: controller.activity is Activity.STOPPED)
    assert walk.run(5.0, lambda: controller.activity is Activity.STANDING_UP)
    assert walk.run(5.0, lambda: controller.activity is not Activity.STANDING_UP)
    walk.run(1.0)
    return walk, controller


SHORT = Plan.through([(0.0, 0.0), (0.3, 0.0)], 0.0)


def test_a_robot_that_was_stopped_in_a_swing_still_says_why_when_it_has_stood_up(monkeypatch):
    walk, controller = stopped_in_a_swing(monkeypatch)
    assert controller.activity is Activity.STOPPED
    assert 'would be commanded a velocity of 9 rad/s' in controller.reason
    # Until something is wished for.
    controller.set_plan(SHORT)
    assert walk.run(5.0, lambda: controller.activity is Activity.WALKING)


@pytest.mark.parametrize('wish', ['stop', 'stand', 'sit'])
def test_what_is_wished_for_after_it_takes_the_place_of_why_it_stopped(monkeypatch, wish):
    walk, controller = stopped_in_a_swing(monkeypatch)
    getattr(controller, wish)()
    walk.run(4.0)
    assert controller.activity in (Activity.STANDING, Activity.SITTING)
    assert 'rad/s' not in controller.reason


def test_a_wish_of_the_swing_that_failed_counts_and_not_why_it_failed(monkeypatch):
    _, controller = stopped_in_a_swing(monkeypatch, lambda controller: controller.stop())
    assert controller.activity is Activity.STANDING
    assert controller.reason.startswith('stopped on request')
    walk, controller = stopped_in_a_swing(monkeypatch, lambda c: c.set_plan(BACK))
    assert walk.run(60.0, lambda: controller.activity is Activity.ARRIVED)
    controller.stand()
    walk.run(3.0)
    assert 'rad/s' not in controller.reason


BACK = Plan.through([(0.0, 0.0), (0.2, 0.0)], 0.0)


@pytest.mark.parametrize('off', [(-0.08, 0.0, 0.0), (-0.05, 0.04, -0.1)])
def test_the_pose_at_the_goal_is_corrected_though_footholds_are_chosen(off):
    """The same footholds were chosen cycle after cycle: the body stayed 22 mm off for good."""
    pytest.importorskip('mujoco')
    x_min, y_min, x_max, y_max = load_map(sample_map('room')).bounds()
    bounds = x_min - BEYOND, y_min - BEYOND, x_max + BEYOND, y_max + BEYOND
    start, goal = Pose2D(6.779, 4.583, -1.519), Pose2D(3.963, 2.697, 0.940)
    specs = specs_from_text('noise+boxes:height=0.05', seed=582)
    terrain = make_terrain(specs, bounds, start, ((start.x, start.y),))
    controller, _, _ = controller_of(TITAN)
    controller.set_height_map(terrain.height_map)
    world = replace(world_from_map(None), terrain=terrain)
    walk = ClosedLoop(TITAN, controller, 'mujoco', world, goal @ Pose2D(*off))
    try:
        walk.run(1.0)
        pose = walk.simulation.observe().pose
        controller.set_plan(Plan((pose, goal)))
        walk.run(40.0, lambda: controller.activity.is_terminal)
        end = walk.simulation.observe().pose
    finally:
        walk.close()
    assert controller.activity is Activity.ARRIVED
    assert end.distance_to(goal) < 0.005
    assert abs(wrap_angle(end.yaw - goal.yaw)) < 0.01


@pytest.mark.parametrize('terrain', ['boxes', 'slope'])
def test_a_random_scene_has_a_plan_and_ground_in_proportion(terrain):
    for robot in (TITAN, GENIBO):
        scene = make_scene(robot, terrain, 3)
        again = make_scene(robot, terrain, 3)
        assert (scene.start, scene.goal) == (again.start, again.goal)
        assert np.array_equal(scene.height_map.heights, again.height_map.heights)
        low, high = scene.height_map.heights.min(), scene.height_map.heights.max()
        assert robot.relative_size * 0.02 < high - low < robot.relative_size * 0.5
    walk = GroundWalk(TITAN, make_scene(TITAN, terrain, 3), 'mujoco')
    try:
        assert walk.planner.problem == ''
    finally:
        walk.close()
