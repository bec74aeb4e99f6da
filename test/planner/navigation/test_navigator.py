"""How a task ends, and what is done about trouble on the way, in a room without a robot."""

from __future__ import annotations

import numpy as np
import pytest

from quad_common.errors import InvalidPlanner, NoGoals, NoRobotPose
from quad_common.frames.map_frame import MapFrame
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.robot_files.walking_time import load_pace
from quad_common.task_result import FollowCode, TaskOutcome
from quad_gait.behaviours.activity import Activity
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.methods.planner import make_planner
from quad_planner.navigation.navigator import Navigator
from quad_planner.navigation.navigator_options import NavigatorOptions
from quad_planner.navigation.path_request import check_planner, path_work
from quad_planner.navigation.remaining_plan import remaining_plan
from quad_planner.navigation.robot_report import DISABLED, MOVING, STUCK, RobotReport
from quad_planner.session.immediate_request import ImmediateRequest
from quad_planner.session.planning_map import PlanningMap
from quad_planner.session.planning_session import PlanningSession
from quad_planner.session.session_state import SessionOptions

START, MIDDLE, GOAL = Pose2D(1.0, 1.0, 0.0), Pose2D(2.0, 1.0, 0.0), Pose2D(3.0, 1.0, 0.0)
OUTSIDE, IN_THE_PILLAR = Pose2D(9.0, 1.0, 0.0), Pose2D(3.7, 3.7, 0.0)
WALKING = RobotReport('walking', 'walking 0.1 m')
STANDING = RobotReport('standing', 'no plan to follow')
BLOCKED = RobotReport('blocked', 'something is in the way')


class Scene:
    """A navigator, its session in an empty room, and the gait's part played by the test."""

    def __init__(self, **options):
        robot = load_robot('titan_viii')
        planner = make_planner('mesh', mesh_size=robot.mesh_size, clearance_radius=0.4)
        planning_map = PlanningMap(planner, MapFrame(), GroundLimits.of(robot))
        self.plans: list[Plan | None] = []
        self.session = PlanningSession(planning_map, ImmediateRequest(), self, SessionOptions())
        self.navigator = Navigator(self.session, NavigatorOptions(**options))
        self.time = 0.0
        self.session.take_grid(room(), 'map')
        self.move(START)

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

    def move(self, pose):
        self.session.tick(self.time, self.time)
        self.session.take_pose(self.time + 0.01, pose)

    def arrive(self, pose):
        """Let the robot be where its plan ends, and the gait say so."""
        self.move(pose)
        self.session.take_followed(len(self.plans), 'map', None)

    def wait(self, seconds, report=None, clock_runs=True):
        """Let time go on, in tenths of a second; return the end of the task."""
        for _ in range(round(10 * seconds)):
            self.time += 0.1
            if report is not None:
                self.navigator.take_report(report)
            if clock_runs:
                self.move(self.session.pose)
            result = self.navigator.update(self.time, self.time if clock_runs else 0.0)
            if result is not None:
                return result
        return None


def room(*columns):
    """Make a room of 4 m by 4 m with a pillar in a corner, and walls in some columns."""
    cells = np.zeros((80, 80), np.int8)
    cells[70:, 70:] = 100
    cells[:, list(columns)] = 100
    return OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0))


def test_a_task_succeeds_when_the_robot_is_at_its_goal_and_not_before():
    scene = Scene()
    scene.navigator.begin([('map', GOAL)])
    assert scene.wait(30.0, WALKING) is None
    scene.arrive(GOAL)
    assert scene.wait(0.1).outcome is TaskOutcome.SUCCEEDED
    assert not scene.navigator.is_active
    assert scene.wait(1.0) is None


def test_a_plan_that_ends_elsewhere_is_no_success():
    scene = Scene()
    scene.navigator.begin([('map', GOAL)])
    scene.arrive(MIDDLE)
    result = scene.wait(0.1)
    assert (result.outcome, result.code) == (TaskOutcome.ABORTED, FollowCode.UNKNOWN)


@pytest.mark.parametrize(('goal', 'code'), [(OUTSIDE, 204), (IN_THE_PILLAR, 206)])
def test_a_goal_without_a_plan_fails_with_the_planners_code(goal, code):
    scene = Scene()
    scene.navigator.begin([('map', MIDDLE)])
    scene.navigator.begin([('map', goal)])
    result = scene.wait(0.1)
    assert (result.outcome, result.code) == (TaskOutcome.ABORTED, code)
    # Nor does the robot walk on to the goal before.
    assert scene.plans[-1] is None


def test_a_wrong_frame_is_refused_with_the_code_of_transforms():
    scene = Scene()
    scene.navigator.begin([('moon', GOAL)])
    assert scene.wait(0.1).code == 202


def test_poses_are_passed_in_their_order_without_a_stop():
    scene = Scene(passing_distance=0.2)
    scene.navigator.begin([('map', MIDDLE), ('map', GOAL)])
    first = scene.navigator.progress(scene.session.pose, None)
    assert (first.poses_left, first.distance) == (2, pytest.approx(2.0))
    assert scene.wait(1.0, WALKING) is None
    assert scene.plans[-1].poses[-1] == MIDDLE
    scene.move(Pose2D(1.85, 1.0, 0.0))
    assert scene.wait(0.1, WALKING) is None
    assert scene.plans[-1].poses[-1] == GOAL
    assert scene.navigator.progress(scene.session.pose, None).poses_left == 1
    scene.move(Pose2D(2.9, 1.0, 0.0))
    assert scene.wait(1.0, WALKING) is None
    scene.arrive(GOAL)
    assert scene.wait(0.1).outcome is TaskOutcome.SUCCEEDED


def test_a_canceled_task_ends_when_the_robot_says_after_it_that_it_stands():
    scene = Scene()
    scene.navigator.begin([('map', GOAL)])
    scene.wait(1.0, STANDING)
    scene.navigator.cancel()
    assert scene.plans[-1] is None
    assert scene.wait(2.0) is None
    assert scene.wait(2.0, WALKING) is None
    assert scene.wait(0.1, STANDING).outcome is TaskOutcome.CANCELED


def test_a_canceled_task_ends_though_no_robot_says_anything():
    scene = Scene(patience=3.0)
    scene.navigator.begin([('map', GOAL)])
    scene.navigator.cancel()
    assert scene.wait(2.9) is None
    assert scene.wait(0.4).outcome is TaskOutcome.CANCELED


def test_a_goal_on_the_topic_preempts_a_task():
    scene = Scene()
    scene.navigator.begin([('map', GOAL)])
    scene.session.give_goal('map', MIDDLE)
    result = scene.wait(0.1)
    assert (result.outcome, result.code) == (TaskOutcome.ABORTED, FollowCode.NONE)
    assert 'newer goal' in result.message
    # That goal is walked to all the same.
    assert scene.plans[-1].poses[-1] == MIDDLE


def test_a_robot_that_is_blocked_is_planned_for_again_before_the_task_fails():
    scene = Scene(retries=2)
    scene.navigator.begin([('map', GOAL)])
    scene.wait(1.0, WALKING)
    result = scene.wait(20.0, BLOCKED)
    assert (result.outcome, result.code) == (TaskOutcome.ABORTED, FollowCode.NO_PROGRESS)
    assert result.message == BLOCKED.reason
    assert scene.navigator.progress(None, None).recoveries == 2
    # One plan at first, one for each recovery, and none in the end.
    assert [plan is None for plan in scene.plans] == [False, False, False, True]


@pytest.mark.parametrize('activity', sorted(DISABLED))
def test_a_robot_that_needs_help_fails_at_once(activity):
    scene = Scene()
    scene.navigator.begin([('map', GOAL)])
    result = scene.wait(3.0, RobotReport(activity, 'help'))
    assert result.code == FollowCode.NO_CONTROL
    assert scene.time < 2.5


def test_a_plan_that_nobody_follows_fails_after_a_while_unless_the_simulation_is_paused():
    scene = Scene(patience=5.0)
    scene.navigator.begin([('map', GOAL)])
    scene.wait(0.1, STANDING)
    assert scene.wait(30.0, clock_runs=False) is None
    assert scene.wait(4.5, STANDING) is None
    result = scene.wait(1.0, STANDING)
    assert result.code == FollowCode.PATIENCE_EXCEEDED
    assert STANDING.reason in result.message


def test_a_gait_that_is_found_late_is_waited_for_and_then_given_all_patience():
    scene = Scene(patience=5.0)
    scene.navigator.begin([('map', GOAL)])
    assert scene.wait(20.0) is None
    assert scene.wait(4.5, STANDING) is None
    assert scene.wait(30.0, WALKING) is None


def test_without_a_gait_a_task_fails_once_one_would_have_been_found():
    scene = Scene(patience=5.0)
    scene.navigator.begin([('map', GOAL)])
    assert scene.wait(29.0) is None
    result = scene.wait(2.0)
    assert result.code == FollowCode.PATIENCE_EXCEEDED
    assert 'no gait_node' in result.message


def test_a_gait_that_dies_while_the_robot_walks_is_not_taken_at_its_last_word():
    scene = Scene(patience=5.0)
    scene.navigator.begin([('map', GOAL)])
    scene.wait(1.0, WALKING)
    assert scene.wait(7.0) is None
    result = scene.wait(2.0)
    assert result.code == FollowCode.PATIENCE_EXCEEDED
    assert 'no gait_node' in result.message


def test_a_robot_that_walks_is_given_all_the_time_it_needs():
    scene = Scene(patience=5.0)
    scene.navigator.begin([('map', GOAL)])
    assert scene.wait(100.0, WALKING) is None


def test_a_robot_whose_odometry_falls_silent_fails_with_the_code_of_transforms():
    scene = Scene(patience=5.0)
    scene.navigator.begin([('map', GOAL)])
    scene.wait(1.0, WALKING)
    for _ in range(100):
        scene.time += 0.1
        scene.session.tick(scene.time, scene.time)
        result = scene.navigator.update(scene.time, scene.time)
        if result is not None:
            break
    assert result.code == FollowCode.NO_POSE


def test_a_map_that_leaves_no_path_is_waited_for_and_then_the_task_fails_with_its_code():
    scene = Scene(patience=5.0)
    scene.navigator.begin([('map', GOAL)])
    scene.wait(1.0, WALKING)
    scene.session.take_grid(room(40), 'map')
    assert scene.plans[-1] is None
    assert scene.wait(4.0, STANDING) is None
    assert scene.wait(2.0, STANDING).code == 208


def test_the_time_left_is_that_of_the_gaits_pace():
    scene = Scene()
    pace = load_pace('titan_viii', 'crawl')
    scene.navigator.begin([('map', GOAL)])
    progress = scene.navigator.progress(START, pace)
    assert progress.time_left == pace.walking_time(START, scene.plans[-1])
    assert scene.navigator.progress(MIDDLE, pace).time_left < progress.time_left


def test_what_is_left_of_a_plan_begins_at_its_nearest_point_and_the_later_of_two():
    plan = Plan.through([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)], 0.0)
    left = remaining_plan(plan, Pose2D(2.2, 1.0, 0.0))
    assert left.poses[0] == Pose2D(2.0, 1.0, plan.poses[1].yaw)
    assert left.length == pytest.approx(5.0)
    assert remaining_plan(plan, Pose2D(0.0, 0.0, 0.0)).length == 0.0
    assert remaining_plan(plan, Pose2D(9.0, -1.0, 0.0)).length == pytest.approx(6.0)
    single = Plan((START,))
    assert remaining_plan(single, GOAL) == single


def test_the_words_of_the_robot_are_those_of_the_gait():
    activities = {activity.value: activity for activity in Activity}
    assert activities.keys() >= MOVING | STUCK | DISABLED
    assert {activities[word] for word in DISABLED} == {a for a in Activity if a.is_disabled}
    assert all(activities[word].is_terminal for word in STUCK)
    assert {activities[word] for word in MOVING} == {a for a in Activity if a.is_moving}
    assert not any(activities[word].is_terminal for word in MOVING)


def test_a_path_that_is_asked_for_leaves_the_robots_plan_alone():
    scene = Scene()
    plan = path_work(scene.session, ('map', MIDDLE), [('', GOAL), ('map', START)])()
    corners = [tuple(corner) for corner in plan.corners.round(9).tolist()]
    assert (corners[0], corners[1], corners[-1]) == ((2.0, 1.0), (3.0, 1.0), (1.0, 1.0))
    assert path_work(scene.session, None, [('map', GOAL)])().poses[0].distance_to(START) < 1e-9
    assert scene.plans == []
    with pytest.raises(NoGoals):
        path_work(scene.session, None, [])
    check_planner('GridBased', 'mesh')
    check_planner('mesh', 'mesh')
    with pytest.raises(InvalidPlanner, match='GridBased'):
        check_planner('shortest', 'mesh')
    # Silence: where the robot is now is not known.
    for _ in range(30):
        scene.time += 0.1
        scene.session.tick(scene.time, scene.time)
    with pytest.raises(NoRobotPose):
        path_work(scene.session, None, [('map', GOAL)])
