"""What is planned when maps, goals, the robot's pose and the plan it follows change."""

import numpy as np
import pytest

from quad_common.errors import InvalidMessage, NoPathFound, WrongFrame
from quad_common.frames.frame_tree import FrameTransform
from quad_common.frames.map_frame import MapFrame
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline
from quad_common.robot_files.robot_file import load_robot
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.methods.planner import make_planner
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_status import session_status
from quad_planner.session.given_goal import GoalEnd
from quad_planner.session.planning_map import PlanningMap
from quad_planner.session.planning_session import PlanningSession
from quad_planner.session.session_state import SessionOptions

START, GOAL, OTHER = Pose2D(1.0, 1.0, 0.0), Pose2D(3.0, 1.0, 0.0), Pose2D(3.0, 3.0, 1.0)
NEAR = Pose2D(3.0, 1.005, 0.0)
"""Where a robot is that has arrived at the goal."""


class Later:
    """Requests that are worked on when a test says so; a newer one ends an older one."""

    def __init__(self):
        self.request = None

    @property
    def is_busy(self):
        return self.request is not None

    def submit(self, work, done):
        self.request = work, done

    def work(self):
        if self.request is not None:
            (work, done), self.request = self.request, None
            try:
                result = work()
            except Exception as error:

                def fail(error=error):
                    raise error

                done(fail)
            else:
                done(lambda: result)


class Room:
    """A session in an empty room of 4 m by 4 m, and what it has decided."""

    def __init__(self, grid=True, pose=START):
        robot = load_robot('titan_viii')
        planner = make_planner('mesh', mesh_size=robot.mesh_size, clearance_radius=0.4)
        self.frame = MapFrame()
        self.warnings = []
        planning_map = PlanningMap(
            planner, self.frame, GroundLimits.of(robot), warn=self.warnings.append
        )
        self.requests = Later()
        self.plans, self.stamps, self.said = [], [], []
        self.session = PlanningSession(planning_map, self.requests, self, SessionOptions())
        self.time = 0.0
        if grid:
            self.session.take_grid(room(), 'map')
        if pose is not None:
            self.move(pose)

    def publish_plan(self, plan):
        self.plans.append(plan)
        self.stamps.append(len(self.stamps) + 1)
        return self.stamps[-1]

    def show_map(self, prepared):
        pass

    def say(self, sentence):
        self.said.append(sentence)

    def update_status(self):
        pass

    def move(self, pose, frame='odom'):
        self.time += 1.0
        self.session.tick(self.time, self.time)
        self.session.take_pose(self.time, self.frame.locate(self.time, frame, pose))

    def give(self, goal, frame='map'):
        self.session.give_goal(frame, goal)
        self.requests.work()

    def follow(self, index=-1):
        """Say, as gait_node does, that a plan is followed."""
        self.session.take_followed(self.stamps[index], 'map', self.plans[index])

    def end(self, index=-1):
        """Say, as gait_node does, that a plan has ended."""
        self.session.take_followed(self.stamps[index], 'map', None)

    def goals(self):
        return [None if plan is None else plan.poses[-1] for plan in self.plans]


def said(walk):
    """Return what the planner's status says."""
    return str(session_status(walk.session, PlannerParameters(), None))


def room(wall=False):
    cells = np.zeros((80, 80), np.int8)
    if wall:
        cells[:, 40] = 100
    return OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0))


def test_a_goal_waits_for_map_and_pose():
    waiting = Room(grid=False, pose=None)
    waiting.give(GOAL)
    waiting.session.take_grid(room(), 'map')
    waiting.requests.work()
    assert waiting.plans == []
    waiting.move(START)
    waiting.requests.work()
    assert waiting.goals() == [GOAL]


def test_a_robot_that_leaves_its_path_is_planned_for_again():
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    walk.move(Pose2D(1.5, 1.2, 0.0))
    walk.requests.work()
    assert len(walk.plans) == 1
    walk.move(Pose2D(1.5, 1.9, 0.0))
    walk.requests.work()
    assert walk.goals() == [GOAL, GOAL]


@pytest.mark.parametrize('moved', [Pose2D(3.0, 2.5, 0.0), START])
def test_after_arrival_whatever_moves_the_robot_nothing_is_planned_any_more(moved):
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    walk.move(NEAR)
    walk.end()
    assert walk.session.has_ended
    walk.move(moved)
    walk.session.take_grid(room(wall=True), 'map')
    walk.session.take_grid(room(), 'map')
    walk.requests.work()
    assert set(walk.goals()[1:]) <= {None}
    walk.give(GOAL)
    assert walk.goals()[-1] == GOAL


def test_a_plan_that_has_ended_is_not_left_for_others_to_walk_once_the_robot_is_elsewhere():
    walk = Room()
    walk.give(GOAL)
    walk.move(NEAR)
    walk.end()
    assert walk.goals() == [GOAL]
    walk.move(Pose2D(3.0, 1.6, 0.0))
    assert walk.goals() == [GOAL, None]
    assert walk.session.plan is None


def test_a_robot_that_is_steered_or_stopped_on_its_way_has_no_goal_any_more():
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    walk.move(Pose2D(2.0, 1.0, 0.0))
    walk.end()
    assert walk.goals() == [GOAL, None]
    walk.move(Pose2D(2.0, 3.0, 0.0))
    walk.session.take_grid(room(wall=True), 'map')
    walk.requests.work()
    assert walk.goals() == [GOAL, None]


def test_the_end_of_an_older_plan_does_not_end_a_goal_that_was_just_given():
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    # While it is searched for, and after it was found.
    walk.session.give_goal('map', OTHER)
    walk.end(0)
    walk.requests.work()
    walk.end(0)
    assert walk.goals() == [GOAL, OTHER]
    walk.move(Pose2D(1.0, 3.0, 0.0))
    walk.requests.work()
    assert walk.goals()[-1] == OTHER


def test_the_same_goal_given_again_outlives_the_end_of_the_plan_before():
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    walk.move(NEAR)
    walk.session.give_goal('map', GOAL)
    walk.end(0)
    walk.requests.work()
    assert walk.goals() == [GOAL, GOAL]
    assert not walk.session.has_ended


def test_an_end_in_the_middle_of_planning_again_gives_that_up():
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    walk.move(Pose2D(1.5, 2.0, 0.0))
    assert walk.session.pending_goal == GOAL
    walk.end()
    assert walk.session.pending_goal is None
    walk.requests.work()
    assert walk.goals() == [GOAL, None]


def test_any_plan_to_the_goal_may_be_the_one_that_ends():
    walk = Room()
    walk.give(GOAL)
    walk.move(Pose2D(1.5, 1.9, 0.0))
    walk.requests.work()
    assert len(walk.plans) == 2
    walk.end(0)
    walk.move(Pose2D(1.0, 3.0, 0.0))
    walk.requests.work()
    assert walk.goals() == [GOAL, GOAL, None]


def test_a_planner_that_begins_while_a_plan_is_followed_takes_its_goal_over():
    late = Room(grid=False, pose=None)
    late.session.take_followed(123, 'map', Plan.through([[1.0, 1.0], [3.0, 1.0]], 0.0))
    assert 'that goal is taken over' in late.said[0]
    late.session.take_grid(room(), 'map')
    late.move(START)
    late.requests.work()
    assert late.goals() == [GOAL]


def test_a_goal_that_was_taken_over_ends_with_the_plan_it_came_from():
    late = Room(grid=False)
    late.session.take_followed(123, 'map', Plan.through([[1.0, 1.0], [3.0, 1.0]], 0.0))
    late.session.take_followed(123, 'map', None)
    late.session.take_grid(room(), 'map')
    late.requests.work()
    assert late.plans == []


def test_a_planner_that_begins_when_all_has_ended_has_nothing_to_do():
    late = Room()
    late.session.take_followed(123, 'map', None)
    late.requests.work()
    assert late.plans == []


def test_a_goal_that_was_given_counts_more_than_one_to_take_over():
    late = Room(grid=False)
    late.give(OTHER)
    late.session.take_followed(123, 'map', Plan.through([[1.0, 1.0], [3.0, 1.0]], 0.0))
    late.session.take_grid(room(), 'map')
    late.requests.work()
    assert late.goals() == [OTHER]


def test_a_plan_of_somebody_else_ends_the_goal_here():
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    walk.session.take_followed(999, 'map', Plan.through([[1.0, 1.0], [1.0, 3.0]], 0.0))
    walk.move(Pose2D(1.0, 3.0, 0.0))
    walk.requests.work()
    assert walk.goals() == [GOAL, None]


def test_a_map_without_a_path_takes_the_plan_back_and_keeps_the_goal():
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    walk.session.take_grid(room(wall=True), 'map')
    walk.requests.work()
    assert walk.goals() == [GOAL, None]
    assert isinstance(walk.session.problem, NoPathFound)
    # The robot follows it no more, as it was told.
    walk.end(0)
    walk.session.take_grid(room(), 'map')
    walk.requests.work()
    assert walk.goals() == [GOAL, None, GOAL]


def test_a_robot_that_is_moved_while_there_is_no_path_has_no_goal_any_more():
    walk = Room()
    walk.give(GOAL)
    walk.session.take_grid(room(wall=True), 'map')
    walk.requests.work()
    walk.move(Pose2D(1.0, 2.0, 0.0))
    assert 'its goal is given up' in walk.said[-1]
    walk.session.take_grid(room(), 'map')
    walk.requests.work()
    assert walk.goals() == [GOAL, None]


def test_no_plan_is_made_from_an_old_pose_but_from_the_next():
    walk = Room()
    walk.session.tick(walk.time + 3.0, walk.time + 3.0)
    assert walk.session.silence == pytest.approx(3.0)
    walk.give(GOAL)
    assert (walk.plans, walk.session.is_waiting) == ([], True)
    walk.time += 10.0
    walk.move(Pose2D(1.0, 2.0, 0.0))
    walk.requests.work()
    assert walk.goals() == [GOAL]
    assert walk.plans[0].poses[0].distance_to(Pose2D(1.0, 2.0, 0.0)) < 1e-6
    # The same for a map that changes meanwhile.
    walk.session.tick(walk.time + 3.0, walk.time + 3.0)
    walk.session.take_grid(room(wall=True), 'map')
    walk.requests.work()
    assert len(walk.plans) == 1
    walk.move(Pose2D(1.0, 2.0, 0.0))
    walk.requests.work()
    assert walk.goals() == [GOAL, None]


def test_a_clock_that_stands_still_makes_no_pose_old():
    walk = Room()
    for second in range(100):
        walk.session.tick(walk.time + second, walk.time)
    assert walk.session.silence == 0.0
    walk.give(GOAL)
    assert walk.goals() == [GOAL]


def test_a_pose_that_repeats_its_stamp_grows_old():
    walk = Room()
    for second in range(1, 4):
        walk.session.tick(walk.time + second, walk.time + second)
        walk.session.take_pose(walk.time, START)
    assert walk.session.silence > 1.0


def test_plans_begin_where_the_robot_is_in_the_map():
    walk = Room(pose=None)
    walk.frame.add([FrameTransform('map', 'odom', (0.5, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))])
    walk.move(START)
    walk.give(GOAL)
    assert walk.plans[0].poses[0].distance_to(Pose2D(1.5, 2.0, 0.0)) < 1e-9


def test_goals_in_odometrys_frame_are_brought_onto_the_map():
    walk = Room(pose=None)
    walk.frame.add([FrameTransform('map', 'odom', (0.5, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))])
    walk.move(START)
    walk.give(GOAL, 'odom')
    assert walk.goals()[0].distance_to(Pose2D(3.5, 2.0, 0.0)) < 1e-9
    walk.give(GOAL, 'moon')
    assert isinstance(walk.session.problem, WrongFrame)
    assert len(walk.plans) == 1


def test_a_relocalisation_off_the_path_leads_to_a_new_plan():
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    walk.frame.add([FrameTransform('map', 'odom', (0.0, 0.8, 0.0), (0.0, 0.0, 0.0, 1.0))])
    walk.move(START)
    walk.requests.work()
    assert walk.goals() == [GOAL, GOAL]
    assert walk.plans[1].poses[0].distance_to(Pose2D(1.0, 1.8, 0.0)) < 1e-9


def test_a_height_map_waits_for_the_map_and_has_to_be_in_its_frame():
    level = HeightMap.level((0.0, 0.0, 4.0, 4.0), 0.05)
    early = Room(grid=False)
    early.session.take_heights(level, 'map')
    early.session.take_grid(room(), 'map')
    with pytest.raises(InvalidMessage, match="in frame 'moon'; give it in 'map'"):
        early.session.take_heights(level, 'moon')
    early.session.take_grid(room(), 'floor')
    assert 'the height map is left out until one is' in early.warnings[0]


def test_whoever_gave_a_goal_learns_how_it_ended():
    told = Room()
    refused = told.session.give_goal('map', Pose2D(9.0, 1.0, 0.0))
    told.requests.work()
    assert (refused.end, refused.error.code) == (GoalEnd.REFUSED, 204)
    replaced = told.session.give_goal('map', OTHER)
    told.requests.work()
    assert replaced.end is None
    arrived = told.session.give_goal('map', GOAL)
    # The end of the plan before is none of the goal that is being searched for.
    told.end()
    assert (replaced.end, arrived.end) == (GoalEnd.REPLACED, None)
    told.requests.work()
    told.follow()
    told.move(NEAR)
    told.end()
    assert arrived.end is GoalEnd.ARRIVED
    # What has ended stays as it is.
    ended = told.session.give_goal('map', OTHER)
    told.requests.work()
    told.end()
    assert (arrived.end, ended.end) == (GoalEnd.ARRIVED, GoalEnd.ENDED)


def test_a_goal_that_is_withdrawn_leaves_no_plan_and_no_search():
    told = Room()
    given = told.session.give_goal('map', GOAL)
    told.session.withdraw_goal()
    told.requests.work()
    assert (given.end, told.plans) == (GoalEnd.WITHDRAWN, [])
    told.give(GOAL)
    told.session.withdraw_goal()
    assert told.plans[-1] is None
    told.move(Pose2D(1.0, 2.0, 0.0))
    told.session.take_grid(room(wall=True), 'map')
    told.requests.work()
    assert told.goals() == [GOAL, None]
    # The same goal may be given again.
    told.session.take_grid(room(), 'map')
    told.give(GOAL)
    assert told.goals() == [GOAL, None, GOAL]


def no_footing(walk, at):
    """Say, as gait_node does, that there is no going on from a pose, and let the session plan."""
    walk.move(at)
    walk.session.take_impassable('map', at)
    walk.requests.work()


def test_a_robot_that_finds_no_footing_ahead_gets_another_path():
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    no_footing(walk, Pose2D(1.5, 1.0, 0.0))
    straight, around = walk.plans
    assert around.poses[0].distance_to(Pose2D(1.5, 1.0, 0.0)) < 0.01
    assert around.poses[-1] == GOAL
    # What is closed is 0.5 m ahead, and paths keep 0.4 m from it.
    assert distance_to_polyline((2.0, 1.0), straight.corners) < 0.3
    assert distance_to_polyline((2.0, 1.0), around.corners) > 0.35
    assert 'no footing' in walk.said[-1]


def test_what_was_closed_for_one_goal_is_open_for_the_next():
    walk = Room()
    walk.give(GOAL)
    walk.follow()
    no_footing(walk, Pose2D(1.5, 1.0, 0.0))
    walk.move(START)
    walk.give(GOAL)
    assert walk.plans[-1].corners.tolist() == walk.plans[0].corners.tolist()


def test_places_without_footing_are_closed_a_few_times_only_and_none_without_a_goal():
    walk = Room()
    no_footing(walk, Pose2D(1.5, 1.0, 0.0))
    assert walk.plans == []
    walk.give(GOAL)
    walk.follow()
    for _ in range(20):
        no_footing(walk, Pose2D(1.5, 1.0, 0.0))
    assert 2 <= len(walk.plans) <= 6


def test_without_another_path_the_last_plan_stays():
    walk = Room()
    cells = np.zeros((80, 80), np.int8)
    cells[36:, :] = cells[:6, :] = 100
    walk.session.take_grid(OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0)), 'map')
    walk.give(GOAL)
    walk.follow()
    no_footing(walk, Pose2D(1.5, 1.0, 0.0))
    assert walk.goals() == [GOAL]
    assert isinstance(walk.session.problem, NoPathFound)


def test_a_goal_that_is_refused_is_said_while_an_earlier_one_is_searched():
    walk = Room()
    walk.session.give_goal('map', GOAL)
    walk.session.give_goal('moon', OTHER)
    assert 'moon' in said(walk)
    walk.requests.work()
    assert walk.goals() == [GOAL]
    assert 'plan of' in said(walk)


def test_a_goal_that_is_refused_is_said_while_searches_compile():
    walk = Room()
    walk.requests.submit(lambda: None, lambda result: result())
    assert 'compile' in said(walk)
    walk.session.give_goal('moon', GOAL)
    assert 'moon' in said(walk)


def test_a_new_goal_ends_what_was_said_of_the_one_before():
    walk = Room()
    walk.session.give_goal('moon', OTHER)
    walk.session.give_goal('map', GOAL)
    assert 'searching a path' in said(walk)
