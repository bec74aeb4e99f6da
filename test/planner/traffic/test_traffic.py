"""What a planning session is told to do because of other robots."""

import math
import tracemalloc

import numpy as np
import pytest

from quad_common.errors import PlannerTimedOut, RobotLeftOut, RobotsInTheWay
from quad_common.frames.frame_tree import FrameTransform
from quad_common.frames.map_frame import MapFrame
from quad_common.maps.occupancy_grid import OCCUPIED, OccupancyGrid
from quad_common.planar_pose import Pose2D, distance_to_polyline
from quad_common.robot_files.robot_file import load_robot
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import session_from_parameters
from quad_planner.session.given_goal import GoalEnd
from quad_planner.session.immediate_request import ImmediateRequest
from quad_planner.traffic.other_robots import MOST_ROBOTS
from quad_planner.traffic.robot_on_map import RobotOnMap
from quad_planner.traffic.traffic import Traffic

RADIUS = load_robot('a1').standing_radius


class Output:
    """What a session decides."""

    def __init__(self):
        self.plans = []

    def publish_plan(self, plan):
        self.plans.append(plan)
        return len(self.plans)

    def show_map(self, prepared):
        """Show nothing."""

    say = warn = show_map

    def update_status(self):
        """Report nothing."""


class Scene:
    """A robot on a floor of 8 x 4 m that walks from (1, 2) to (7, 2), named b."""

    def __init__(self, cells=None, requests=None, **parameters):
        self.output = Output()
        parameters = {'method': 'shortest', 'any_angle': True, **parameters}
        parameters = PlannerParameters(robot='a1', **parameters)
        self.session = session_from_parameters(
            parameters, load_robot('a1'), MapFrame('map'), ImmediateRequest(), self.output
        )
        self.traffic = Traffic(self.session, 'b', RADIUS, requests or ImmediateRequest())
        cells = np.zeros((80, 160), np.int8) if cells is None else cells
        self.session.take_grid(OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0)), 'map')
        self.time = 0.0
        self.go_on(Pose2D(1.0, 2.0, 0.0))
        self.given = self.session.give_goal('map', Pose2D(7.0, 2.0, 0.0))

    def go_on(self, pose=None, seconds=0.5):
        self.time += seconds
        self.session.take_pose(self.time, pose or self.session.pose)
        self.traffic.update(self.time)

    def tell(self, name, *path, has_fallen=False):
        x, y = path[0]
        line = np.array(path[1:], dtype=float).reshape(-1, 2)
        robot = RobotOnMap(name, Pose2D(x, y, 0.0), RADIUS, line, has_fallen=has_fallen)
        self.traffic.take_robot(self.time, robot)

    @property
    def passes_around(self):
        """Whether its plan leads past (4, 2), and keeps both bodies apart."""
        plan = self.session.plan
        if plan is None or len(plan.poses) < 3:
            return False
        return distance_to_polyline((4.0, 2.0), plan.corners) > 2.0 * RADIUS


def test_around_a_robot_that_blocks_for_long_it_goes_on_without_a_stop():
    scene = Scene()
    while not scene.session.hold_reason or scene.time < 25.0:
        scene.tell('c', (2.3, 2.05), (2.3, 3.5))
        scene.go_on(Pose2D(1.3, 2.0, 0.0))
        if scene.time > 30.0:
            break
    # It wants to go on, and has not moved for long enough to be walked around.
    for _ in range(10):
        scene.tell('c', (2.3, 2.05), (2.3, 3.5))
        scene.go_on()
        assert scene.session.hold_reason == ''
        assert distance_to_polyline((2.3, 2.05), scene.session.plan.corners) > 2.0 * RADIUS - 0.05


def test_beside_a_robot_that_stays_it_passes_as_near_as_its_outline_may():
    cells = np.zeros((80, 160), np.int8)
    cells[:26] = cells[62:] = OCCUPIED
    scene = Scene(cells, footprint='outline', safety_distance=0.05, any_angle=False)
    for _ in range(14):
        scene.tell('c', (4.0, 2.0))
        scene.go_on()
    places = scene.session.plan.corners
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    along = np.arange(0.0, lengths[-1], 0.1)
    for x, y in np.column_stack([np.interp(along, lengths, places[:, k]) for k in (0, 1)]):
        scene.tell('c', (4.0, 2.0))
        scene.go_on(Pose2D(float(x), float(y), 0.0), seconds=1.0)
        scene.tell('c', (4.0, 2.0))
        scene.go_on(seconds=1.0)
        assert scene.session.hold_reason == ''


def test_robots_stay_where_they_are_on_a_map_in_another_frame():
    scene = Scene()
    frame, grid = scene.session.map.frame, scene.session.map.planner.prepared.grid
    turn = FrameTransform('map', 'other', (8.0, 4.0, 0.0), (0.0, 0.0, 1.0, 0.0))
    frame.add([turn])
    scene.tell('c', (4.0, 2.5), (4.0, 3.5), (3.0, 3.5))
    scene.go_on()
    scene.session.take_grid(grid, 'other')
    robot = scene.traffic.others['c']
    assert np.allclose(robot.line, [(4.0, 1.5), (4.0, 0.5), (5.0, 0.5)])
    assert abs(robot.pose.yaw) == pytest.approx(math.pi)
    # It has not walked there: that would be too fast for anybody to wait for it.
    scene.traffic.take_robot(scene.time + 0.4, robot)
    assert scene.traffic._speeds.of('c', 7.0) == 7.0
    # What it says itself is no path in the frame before.
    assert len(scene.traffic.own_word().path) == 0
    scene.go_on()
    assert np.allclose(scene.traffic.own_word().path[-1], (1.0, 2.0))


def test_robots_on_a_map_that_nothing_relates_to_the_new_one_are_forgotten():
    scene = Scene()
    scene.tell('c', (4.0, 2.5))
    scene.go_on()
    scene.session.take_grid(scene.session.map.planner.prepared.grid, 'moon')
    assert scene.traffic.others == {}
    scene.session.take_pose(scene.time, Pose2D(1.0, 3.0, 0.0))
    scene.session.give_goal('moon', Pose2D(7.0, 3.0, 0.0))
    scene.go_on()
    assert scene.traffic._speeds.of('b', 7.0) == 7.0


def test_only_the_beginning_of_a_path_is_seen_from_another_frame_with_its_goal():
    line = np.array([(1.0, 0.0), (2.0, 0.0), (3.0, 1.0)])
    robot = RobotOnMap('c', Pose2D(0.0, 0.0, 0.0), RADIUS, line).beginning(1)
    moved = robot.seen_from(Pose2D(1.0, 2.0, math.pi / 2.0))
    assert np.allclose(moved.path, [(1.0, 3.0)])
    assert np.allclose(moved.destination, (0.0, 5.0))


def test_a_robot_alone_is_left_alone():
    scene = Scene()
    before = list(scene.output.plans)
    scene.go_on()
    assert scene.output.plans == before
    assert scene.session.hold_reason == ''


def test_before_a_crossing_it_waits_and_then_goes_on_to_the_same_goal():
    scene = Scene()
    scene.tell('a', (2.0, 0.3), (2.0, 3.7))
    scene.go_on()
    assert scene.session.hold_reason == 'waiting for a to pass'
    assert scene.output.plans[-1] is None
    assert scene.session.goal == Pose2D(7.0, 2.0, 0.0)
    scene.tell('a', (2.0, 3.4), (2.0, 3.7))
    scene.go_on()
    assert scene.session.hold_reason == ''
    assert scene.output.plans[-1].poses[-1] == Pose2D(7.0, 2.0, 0.0)


def test_with_the_right_of_way_it_goes_on():
    scene = Scene()
    before = list(scene.output.plans)
    scene.tell('c', (2.0, 0.3), (2.0, 3.7))
    scene.go_on()
    assert scene.output.plans == before


def test_on_the_path_of_one_that_comes_it_leaves_it_and_says_so():
    scene = Scene()
    scene.tell('a', (6.0, 2.0), (0.5, 2.0))
    scene.go_on()
    assert scene.session.hold_reason == 'giving way to a'
    place = scene.output.plans[-1].poses[-1]
    assert abs(place.y - 2.0) > 2.0 * RADIUS + 0.2


def test_the_goal_stays_in_force_when_the_place_to_wait_at_is_reached():
    scene = Scene()
    scene.tell('a', (6.0, 2.0), (0.5, 2.0))
    scene.go_on()
    scene.session.take_followed(len(scene.output.plans), 'map', None)
    scene.go_on(scene.output.plans[-1].poses[-1])
    assert scene.session.goal == Pose2D(7.0, 2.0, 0.0)
    scene.traffic.forget_robot('a')
    scene.go_on()
    scene.go_on()
    assert scene.session.hold_reason == ''
    assert scene.output.plans[-1].poses[-1] == Pose2D(7.0, 2.0, 0.0)


def test_in_a_dead_end_it_goes_first():
    cells = np.zeros((80, 160), np.int8)
    # A corridor around the robot, closed behind it, and nothing but the other one before it.
    cells[:25], cells[55:], cells[:, :8], cells[:, 100:] = (OCCUPIED,) * 4
    scene = Scene(cells)
    scene.session.give_goal('map', Pose2D(4.2, 2.0, 0.0))
    for _ in range(4):
        scene.tell('a', (4.4, 2.0), (1.0, 2.0))
        scene.go_on()
    assert scene.traffic.goes_first
    assert scene.traffic.own_word().goes_first


def test_one_that_stays_is_planned_around_after_a_while():
    scene = Scene()
    for _ in range(14):
        scene.tell('a', (4.0, 2.0))
        scene.go_on()
    plan = scene.session.plan
    assert plan is not None
    distances = np.linalg.norm(plan.corners - (4.0, 2.0), axis=1)
    assert len(plan.poses) > 2
    assert distances.min() > 2.0 * RADIUS


def test_one_that_has_fallen_is_planned_around_at_once_whoever_has_the_right_of_way():
    for name in 'a', 'c':
        scene = Scene()
        scene.tell(name, (4.0, 2.0), has_fallen=True)
        scene.go_on()
        assert scene.passes_around
        assert scene.session.hold_reason == ''


def test_one_that_has_fallen_says_so_and_wants_no_path():
    scene = Scene()
    scene.go_on()
    scene.traffic.take_tilt(math.radians(35.0))
    word = scene.traffic.own_word()
    assert word.has_fallen
    assert word.is_staying
    scene.traffic.take_tilt(math.radians(5.0))
    assert not scene.traffic.own_word().is_staying


def test_one_that_is_silent_stays_an_obstacle_where_it_was():
    scene = Scene()
    scene.tell('a', (4.0, 2.0), (0.5, 2.0))
    scene.go_on()
    assert scene.session.hold_reason == 'giving way to a'
    for _ in range(25):
        scene.go_on()
    assert scene.traffic.others['a'].is_staying
    assert scene.passes_around
    for _ in range(26):
        scene.go_on(seconds=25.0)
    assert scene.traffic.others == {}


def test_one_that_does_not_move_is_an_obstacle_until_it_moves():
    scene = Scene()
    for _ in range(45):
        scene.tell('a', (4.0, 2.0), (0.5, 2.0))
        scene.go_on(seconds=1.0)
    assert scene.passes_around
    scene.tell('a', (3.8, 2.0), (0.5, 2.0))
    scene.go_on()
    assert scene.session.hold_reason == 'giving way to a'


def test_a_goal_behind_one_that_stays_in_a_corridor_is_given_up_with_its_name():
    cells = np.zeros((80, 160), np.int8)
    cells[:29, 70:120], cells[51:, 70:120] = OCCUPIED, OCCUPIED
    scene = Scene(cells)
    for _ in range(57):
        scene.tell('a', (4.5, 2.0), has_fallen=True)
        scene.go_on(seconds=2.0)
        assert scene.session.plan is None
        assert scene.given.end is None
    for _ in range(10):
        scene.tell('a', (4.5, 2.0), has_fallen=True)
        scene.go_on(seconds=2.0)
    assert scene.given.end is GoalEnd.REFUSED
    assert isinstance(scene.session.problem, RobotsInTheWay)
    assert 'blocked by a' in str(scene.session.problem)
    assert scene.session.goal is None


def test_a_goal_on_which_another_one_stays_is_given_up_too():
    scene = Scene()
    scene.go_on(Pose2D(6.0, 2.0, 0.0))
    for _ in range(70):
        scene.tell('a', (7.0, 2.0))
        scene.go_on(seconds=2.0)
    assert scene.given.end is GoalEnd.REFUSED
    assert scene.session.plan is None


def test_a_stream_of_names_is_cut_off_and_those_known_stay():
    scene = Scene()
    for number in range(MOST_ROBOTS):
        scene.tell(f'r{number}', (4.0, 3.5))
    with pytest.raises(RobotLeftOut, match="robot 'one_more' is ignored: 64 other robots"):
        scene.tell('one_more', (4.0, 3.5))
    scene.tell('r0', (4.0, 3.4))
    assert len(scene.traffic.others) == MOST_ROBOTS
    for _ in range(30):
        scene.go_on()
    # Those that are silent make room.
    scene.tell('one_more', (4.0, 3.5))
    assert len(scene.traffic.others) == MOST_ROBOTS
    assert 'one_more' in scene.traffic.others


def test_however_long_their_paths_are_robots_make_a_look_at_the_traffic_no_longer():
    scene = Scene()
    along = np.linspace(1.5, 6.5, 990)
    path = np.column_stack([along, 2.0 + 0.5 * (-1.0) ** np.arange(len(along))])
    for number in range(MOST_ROBOTS):
        scene.tell(f'a{number}', (4.0, 2.0), *path)
    others = scene.traffic.others.values()
    assert len(others) == MOST_ROBOTS
    assert sum(len(other.path) for other in others) <= 2000
    assert all(np.array_equal(other.destination, path[-1]) for other in others)
    tracemalloc.start()
    scene.go_on()
    largest = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert scene.session.hold_reason
    # At once the distances from all places of the map to all of one path were half a gigabyte.
    assert largest < 50e6


def test_what_is_far_ahead_on_a_path_counts_as_its_end_only():
    path = np.array([[10.0, 0.0], [10.0, 100.0], [0.0, 100.0]])
    robot = RobotOnMap('a', Pose2D(0.0, 0.0, 0.0), RADIUS, path)
    assert robot.beginning(3) is robot
    assert robot.beginning(3, 1000.0) is robot
    near = robot.beginning(3, 50.0)
    assert near.path == pytest.approx(np.array([[10.0, 0.0], [10.0, 40.0]]))
    assert robot.beginning(1).path == pytest.approx(path[:1])
    for part in (near, robot.beginning(1), near.beginning(1)):
        assert part.destination == pytest.approx(path[-1])
    assert near.staying().destination == pytest.approx([0.0, 0.0])


@pytest.mark.parametrize('moves', [True, False])
def test_a_new_goal_is_planned_to_while_it_waits(moves):
    scene = Scene()
    scene.tell('a', (2.0, 0.3), (2.0, 3.7))
    scene.go_on()
    goal = Pose2D(0.6, 2.0, 0.0) if moves else Pose2D(7.0, 3.0, 0.0)
    scene.session.give_goal('map', goal)
    assert scene.session.goal == goal
    assert scene.output.plans[-1].poses[-1] == goal


def giving_way():
    """A robot on its way to a place off the path of another one."""
    scene = Scene()
    scene.tell('a', (6.0, 2.0), (0.5, 2.0))
    scene.go_on()
    assert scene.session.is_detour
    return scene


def test_without_footing_on_the_way_off_the_path_it_does_not_walk_to_its_goal():
    scene = giving_way()
    scene.session.take_impassable('map', Pose2D(1.0, 2.1, 0.5))
    assert scene.output.plans[-1] is None
    scene.go_on()
    assert scene.session.is_detour


def test_a_map_that_changes_ends_the_way_off_the_path():
    scene = giving_way()
    count = len(scene.output.plans)
    cells = np.zeros((80, 160), np.int8)
    cells[-20:] = OCCUPIED
    scene.session.take_grid(OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0)), 'map')
    assert scene.output.plans[count] is None
    scene.go_on()
    assert scene.session.is_detour
    assert scene.session.plan.poses[-1].y < 2.0


def test_a_body_on_the_way_off_the_path_is_stopped_for():
    scene = giving_way()
    start, place = scene.session.pose, scene.session.plan.poses[-1]
    between = Pose2D((start.x + place.x) / 2.0, (start.y + place.y) / 2.0, 0.0)
    scene.tell('c', (between.x, between.y), (between.x + 2.0, between.y))
    scene.go_on()
    assert scene.session.plan is None
    assert scene.session.hold_reason == 'giving way to a'


class LaterRequests(ImmediateRequest):
    """Searches that are not answered any more once `is_late` is set."""

    is_late = False

    def submit(self, work, done):
        if not self.is_late:
            super().submit(work, done)


def test_a_body_is_stopped_for_while_a_plan_is_searched():
    scene = Scene()
    scene.session._requests = requests = LaterRequests()
    requests.is_late = True
    scene.session.plan_again()
    assert scene.session.pending_goal is not None
    scene.tell('c', (1.7, 2.0), (0.5, 2.0))
    scene.go_on()
    assert scene.session.plan is None
    assert scene.session.hold_reason


def test_a_corridor_that_becomes_free_again_is_walked():
    cells = np.zeros((80, 160), np.int8)
    cells[:29, 70:120], cells[51:, 70:120] = OCCUPIED, OCCUPIED
    scene = Scene(cells)
    for _ in range(14):
        scene.tell('a', (4.5, 2.0))
        scene.go_on()
    assert scene.session.plan is None
    scene.traffic.forget_robot('a')
    scene.go_on()
    assert scene.session.plan.poses[-1] == Pose2D(7.0, 2.0, 0.0)


def test_after_a_goal_that_is_refused_it_goes_on_to_the_one_before():
    scene = Scene()
    scene.tell('a', (2.0, 0.3), (2.0, 3.7))
    scene.go_on()
    assert scene.session.hold_reason
    scene.session.give_goal('map', Pose2D(70.0, 2.0, 0.0))
    scene.tell('a', (2.0, 3.4), (2.0, 3.7))
    scene.go_on()
    assert scene.session.goal == Pose2D(7.0, 2.0, 0.0)
    assert scene.session.plan is not None


def test_when_time_goes_back_robots_from_before_are_forgotten():
    scene = Scene()
    scene.time = 3600.0
    scene.tell('a', (2.0, 0.3), (2.0, 3.7))
    scene.go_on()
    scene.time = 0.0
    scene.go_on()
    assert scene.traffic.others == {}


def wall(*gaps):
    """A wall across the floor at 4 m, with gaps in these rows."""
    cells = np.zeros((80, 160), np.int8)
    cells[:, 75:85] = OCCUPIED
    for first, last in gaps:
        cells[first:last, 75:85] = 0
    return OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0))


def test_a_door_closed_in_the_map_is_no_fault_of_a_robot_that_stands_elsewhere():
    scene = Scene()
    scene.go_on()
    scene.session.take_grid(wall(), 'map')
    for _ in range(20):
        scene.tell('c', (0.6, 3.5))
        scene.go_on(seconds=9.0)
    assert scene.session.plan is None
    assert scene.given.end is None
    assert scene.session.goal == Pose2D(7.0, 2.0, 0.0)


def test_only_robots_on_the_path_are_named():
    scene = Scene(wall((29, 51)).cells)
    for _ in range(18):
        scene.tell('a', (4.0, 2.0))
        scene.tell('c', (0.6, 3.5))
        scene.go_on(seconds=9.0)
    assert scene.given.end is GoalEnd.REFUSED
    assert scene.session.problem.names == ['a']


class QueuedRequests(ImmediateRequest):
    """Searches that wait until they are worked on."""

    def __init__(self):
        self.waiting = []

    @property
    def is_busy(self):
        return bool(self.waiting)

    def submit(self, work, done):
        self.waiting.append((work, done))

    def work_on_all(self):
        while self.waiting:
            work, done = self.waiting.pop(0)
            plan = work()
            done(lambda: plan)  # noqa: B023


def test_the_path_without_robots_is_searched_beside_the_traffic():
    requests = QueuedRequests()
    scene = Scene(wall((29, 51)).cells, requests)

    def look(times):
        for _ in range(times):
            scene.tell('a', (4.0, 2.0))
            scene.go_on(seconds=9.0)

    look(18)
    # Nothing is said of anybody before the search is over; it is asked for once.
    assert scene.given.end is None
    assert len(requests.waiting) == 1
    requests.work_on_all()
    look(18)
    assert scene.given.end is GoalEnd.REFUSED
    assert scene.session.problem.names == ['a']


def test_maps_that_change_all_the_time_do_not_keep_a_robot_waiting_for_ever():
    requests = QueuedRequests()
    scene = Scene(wall((29, 51)).cells, requests)
    most = 0
    for look in range(40):
        scene.tell('a', (4.0, 2.0))
        scene.go_on(seconds=9.0)
        if scene.given.end is not None:
            break
        most = max(most, len(requests.waiting))
        if look % 3 == 2:
            requests.work_on_all()
        cells = wall((29, 51)).cells.copy()
        cells[2, look % 60] = OCCUPIED
        scene.session.take_grid(OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0)), 'map')
    assert most == 1
    assert scene.given.end is GoalEnd.REFUSED
    assert scene.session.problem.names == ['a']


def test_a_search_that_runs_out_of_its_time_says_nothing_of_robots(monkeypatch):
    scene = Scene()
    scene.go_on()

    def plan(start, goal):
        raise PlannerTimedOut(1.0)

    monkeypatch.setattr(scene.session.map.planner, 'plan', plan)
    scene.session.take_grid(wall((29, 51)), 'map')
    for _ in range(20):
        scene.tell('a', (5.5, 2.0))
        scene.go_on(seconds=9.0)
    assert scene.given.end is None


def test_a_passage_that_opens_in_the_map_is_walked_by_one_that_waits():
    scene = Scene(wall((30, 52)).cells)
    scene.go_on()
    scene.go_on(Pose2D(2.6, 2.0, 0.0))
    for _ in range(30):
        scene.tell('c', (3.85, 2.05))
        scene.go_on(seconds=1.0)
    assert scene.session.hold_reason
    scene.session.take_grid(wall((30, 52), (0, 24)), 'map')
    for _ in range(2):
        scene.tell('c', (3.85, 2.05))
        scene.go_on(seconds=1.0)
    assert scene.session.hold_reason == ''
    assert scene.session.plan.poses[-1] == Pose2D(7.0, 2.0, 0.0)


def test_before_a_goal_is_given_up_a_path_is_looked_for_once_more(monkeypatch):
    scene = Scene(wall((29, 51)).cells)
    planner = scene.session.map.planner
    for _ in range(12):
        scene.tell('a', (4.0, 2.0), has_fallen=True)
        scene.go_on(seconds=9.0)
    assert scene.session.plan is None
    free = scene.session.map.search_without_bodies(scene.session.pose, scene.session.goal)()
    monkeypatch.setattr(planner, 'plan', lambda start, goal: free)
    for _ in range(6):
        scene.tell('a', (4.0, 2.0), has_fallen=True)
        scene.go_on(seconds=9.0)
    assert scene.given.end is None
    assert scene.session.plan is not None


def test_one_that_has_fallen_itself_gives_way_to_nobody():
    scene = giving_way()
    count = len(scene.output.plans)
    scene.traffic.take_tilt(math.radians(60.0))
    for _ in range(8):
        scene.tell('a', (2.5, 2.0), (0.5, 2.0))
        scene.go_on()
    assert scene.session.hold_reason == 'the robot has fallen'
    assert scene.output.plans[count:] == [None]
    assert scene.session.goal == Pose2D(7.0, 2.0, 0.0)
    scene.traffic.take_tilt(0.0)
    scene.tell('a', (2.5, 2.0), (0.5, 2.0))
    scene.go_on()
    assert scene.session.hold_reason == 'giving way to a'
    assert scene.session.is_detour


def test_after_a_pause_of_its_own_others_have_time_to_speak(monkeypatch):
    scene = Scene()
    for _ in range(4):
        scene.tell('a', (4.0, 3.2), (7.0, 3.2))
        scene.go_on()
    bodies = []
    put = scene.session.map.put_bodies
    monkeypatch.setattr(
        scene.session.map, 'put_bodies', lambda these: bodies.extend(these) or put(these)
    )
    # What comes meanwhile has the time of the last odometry.
    scene.go_on(seconds=12.0)
    scene.go_on()
    assert not scene.traffic.others['a'].is_staying
    assert bodies == []
    for _ in range(25):
        scene.go_on()
    assert scene.traffic.others['a'].is_staying
    assert len(bodies) > 0


def test_a_new_goal_without_a_path_past_robots_is_refused_at_once_and_the_one_before_stays():
    scene = Scene(wall((29, 51)).cells)
    scene.tell('a', (4.0, 2.0), has_fallen=True)
    scene.go_on()
    new = scene.session.give_goal('map', Pose2D(7.0, 2.2, 0.0))
    assert new.end is GoalEnd.REFUSED
    assert scene.session.goal == Pose2D(7.0, 2.0, 0.0)


def test_a_goal_of_an_idle_robot_is_taken_whoever_is_in_the_way():
    scene = Scene(wall((29, 51)).cells)
    scene.session.withdraw_goal()
    for _ in range(3):
        scene.tell('a', (4.0, 2.0), has_fallen=True)
        scene.go_on()
    new = scene.session.give_goal('map', Pose2D(7.0, 2.2, 0.0))
    scene.go_on()
    assert new.end is None
    assert scene.session.plan is None
    assert scene.session.goal == Pose2D(7.0, 2.2, 0.0)
