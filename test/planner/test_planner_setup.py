"""
A planner as the node's parameters say: how near to a wall a walk may begin.
"""

import time
from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import GoalOccupied, ParameterError, StartOccupied
from quad_common.frames.map_frame import MapFrame
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_common.robot_files.walking_time import load_pace
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import (
    change_planner,
    planner_from_parameters,
    session_from_parameters,
    unheeded_costs,
)
from quad_planner.session.immediate_request import ImmediateRequest

GOAL = Pose2D(2.0, 2.0, 0.0)


def walled_room():
    """Return a free map of 4 m x 4 m with a wall below y = 0.5 m."""
    cells = np.zeros((80, 80), dtype=np.int8)
    cells[:10] = 100
    return OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0))


def planner_with(**parameters):
    values = PlannerParameters(**parameters)
    robot = load_robot(values.robot)
    planner = planner_from_parameters(values, robot)
    planner.set_map(walled_room())
    return robot, planner


@pytest.mark.parametrize('name', available_robots())
@pytest.mark.parametrize('gait', ['crawl', 'trot'])
def test_a_walk_begins_where_the_robot_has_room_to_sway_and_turn_and_not_nearer(name, gait):
    robot, planner = planner_with(robot=name, gait=gait)
    needed = robot.footprint_radius + load_pace(name, gait).sweep
    assert planner.plan(Pose2D(2.0, 0.5 + needed + 0.001, 0.0), GOAL).length > 0.0
    with pytest.raises(StartOccupied, match=f'the robot needs {needed:.2f} m'):
        planner.plan(Pose2D(2.0, 0.5 + needed - 0.001, 0.0), GOAL)


def test_another_tolerance_can_be_set():
    robot, planner = planner_with(start_tolerance=0.1)
    needed = robot.footprint_radius + 0.12 - 0.1
    assert planner.plan(Pose2D(2.0, 0.5 + needed + 0.001, 0.0), GOAL).length > 0.0
    with pytest.raises(StartOccupied):
        planner.plan(Pose2D(2.0, 0.5 + needed - 0.001, 0.0), GOAL)


class Noted:
    """Notes down the plans of a session."""

    def __init__(self):
        self.plans = []

    def publish_plan(self, plan):
        self.plans.append(plan)
        return len(self.plans)

    def show_map(self, prepared):
        pass

    def say(self, sentence):
        pass

    warn = say

    def update_status(self):
        pass


def test_another_method_counts_from_the_next_plan_on_and_keeps_map_and_plan():
    output, requests, robot = Noted(), ImmediateRequest(), load_robot('titan_viii')
    mesh_parameters = PlannerParameters(method='mesh')
    session = session_from_parameters(mesh_parameters, robot, MapFrame(), requests, output)
    session.take_grid(walled_room(), 'map')
    session.take_pose(0.0, Pose2D(1.3, 1.7, 0.0))
    session.give_goal('map', Pose2D(2.9, 2.3, 0.0))
    shortest = PlannerParameters(method='shortest', any_angle=True)
    change_planner(session, mesh_parameters, shortest, requests, time.monotonic)
    assert len(output.plans) == 1
    session.give_goal('map', Pose2D(2.9, 2.3, 0.0))
    mesh, straight = output.plans
    assert len(mesh.poses) > 2
    assert len(straight.poses) == 2
    assert straight.length < mesh.length


def test_a_method_that_cannot_be_had_leaves_the_planner_as_it_is(tmp_path):
    requests, robot = ImmediateRequest(), load_robot('titan_viii')
    session = session_from_parameters(PlannerParameters(), robot, MapFrame(), requests, Noted())
    planner = session.map.planner
    unknown = PlannerParameters(method='quickest', gait=str(tmp_path / 'unknown.yaml'))
    with pytest.raises(ParameterError):
        change_planner(session, PlannerParameters(), unknown, requests, time.monotonic)
    assert session.map.planner is planner


def session_on_its_way(parameters):
    """Return a session whose robot walks past the wall, with what it published."""
    output, requests, robot = Noted(), ImmediateRequest(), load_robot('titan_viii')
    session = session_from_parameters(parameters, robot, MapFrame(), requests, output)
    session.take_grid(walled_room(), 'map')
    session.take_pose(0.0, Pose2D(1.3, 1.7, 0.0))
    session.give_goal('map', Pose2D(2.9, 1.7, 0.0))
    return session, output, requests


@pytest.mark.parametrize('change', [{'safety_distance': 0.2}, {'occupied_threshold': 50}])
def test_where_other_cells_are_free_than_before_the_plan_in_force_is_made_again(change):
    before = PlannerParameters()
    session, output, requests = session_on_its_way(before)
    change_planner(session, before, replace(before, **change), requests, time.monotonic)
    assert len(output.plans) == 2
    assert output.plans[-1].poses[-1] == Pose2D(2.9, 1.7, 0.0)


def test_a_plan_that_a_larger_safety_distance_forbids_is_taken_back():
    before = PlannerParameters()
    session, output, requests = session_on_its_way(before)
    wide = replace(before, safety_distance=1.0)
    change_planner(session, before, wide, requests, time.monotonic)
    assert output.plans[-1] is None
    assert isinstance(session.problem, GoalOccupied)


def test_the_conditions_of_planning_again_may_change_on_the_way():
    before = PlannerParameters()
    session, output, requests = session_on_its_way(before)
    patient = replace(before, replan_distance=2.0)
    change_planner(session, before, patient, requests, time.monotonic)
    session.take_pose(1.0, Pose2D(1.8, 2.6, 0.0))
    assert len(output.plans) == 1
    change_planner(session, patient, before, requests, time.monotonic)
    session.take_pose(2.0, Pose2D(1.8, 2.6, 0.0))
    assert len(output.plans) == 2


@pytest.mark.parametrize(
    'nonsense',
    [
        {'gait': 'gallop'},
        {'gait': 'x' * 1_000_000},
        {'gait': '~nobody_of_that_name/gait.yaml'},
        {'gait': '/nowhere/my_gait.yaml', 'method': 'shortest'},
        {'outline': 'round'},
        {'outline': '[' * 1_000_000},
        {'outline': '[[0.3, 0.2], [-0.5, 0.2]]', 'footprint': 'outline'},
    ],
)
def test_a_gait_or_outline_that_does_not_exist_is_refused(nonsense):
    values = PlannerParameters()
    robot = load_robot(values.robot)
    with pytest.raises(ParameterError, match=next(iter(nonsense))):
        planner_from_parameters(replace(values, **nonsense), robot)


def test_a_gait_of_a_file_whose_pace_is_not_known_is_taken(tmp_path):
    path = tmp_path / 'my_gait.yaml'
    path.write_text('cycle_period: 4.0')
    _, planner = planner_with(gait=str(path))
    assert planner.plan(Pose2D(1.0, 2.0, 0.0), GOAL).length == pytest.approx(1.0)


def test_costs_that_a_method_does_not_heed_are_said():
    def said(**changes):
        return unheeded_costs(replace(PlannerParameters(), **changes))

    assert said(method='mesh') == ''
    assert "method 'mesh'" in said(method='mesh', map_values='costmap')
    assert said(method='potential', map_values='costmap')
    heeding = {'shortest': {}, 'quickest': {}, 'potential': {'potential': 'navigation'}}
    for method, more in heeding.items():
        assert said(method=method, map_values='costmap', **more) == ''
