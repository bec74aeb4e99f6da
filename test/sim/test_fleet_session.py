"""Several robots in one simulation: how they are named, placed, spawned and removed."""

import pytest

from quad_common.errors import (
    ParameterError,
    PlaceTaken,
    QuadError,
    RobotIsAlone,
    RobotNotFound,
    RobotUnknown,
    TooManyObstacles,
)
from quad_common.planar_pose import Pose2D
from quad_sim.fleet_session import FleetSession, session_from_parameters
from quad_sim.fleet_text import robots_from_text
from quad_sim.parameters import SimParameters
from quad_sim.sim_session import SimSession
from quad_sim.world.obstacle_changes import ObstacleChange
from quad_sim.world.world import Obstacle


class Recorded:
    """What a session publishes."""

    def __init__(self):
        self.clock, self.readings = [], {}

    def publish_clock(self, time):
        self.clock.append(time)

    def publish_readings(self, readings, name=''):
        self.readings[name] = readings


def session(robots, **parameters):
    made = SimParameters(backend='kinematic', map_file='none', robots=robots, **parameters)
    return session_from_parameters(made, lambda: 0.0)


def test_robots_are_read_by_kind_name_and_place():
    named = robots_from_text('left=cuhk@1,2,0.5; a1')
    assert named['left'].kind == 'cuhk'
    assert named['left'].start == Pose2D(1.0, 2.0, 0.5)
    assert (named['robot2'].kind, named['robot2'].start) == ('a1', None)
    assert list(robots_from_text('titan_viii, cuhk,a1')) == ['robot1', 'robot2', 'robot3']
    assert robots_from_text(' ') == {}


@pytest.mark.parametrize('text', ['a=a1; a=a1', '1a=a1@0,0,0', 'a=@0,0,0', 'a1@1,2', 'a1@x,0,0'])
def test_what_names_no_robots_is_refused(text):
    with pytest.raises(ParameterError, match='names or files of robots'):
        robots_from_text(text)


@pytest.mark.parametrize('place', ['nan,0,0', '0,1e300,0', '0,0,1e17', '-inf,0,0'])
def test_robots_at_no_place_are_refused(place):
    with pytest.raises(ParameterError, match=r"'robots\.(x|y|yaw)' is .* it must be"):
        robots_from_text(f'a1@{place}')


def test_every_robot_is_measured_in_frames_of_its_own_and_time_is_one():
    running, output = session('a1, cuhk'), Recorded()
    assert isinstance(running, FleetSession)
    running.advance(output)
    assert output.readings.keys() == {'robot1', 'robot2'}
    assert {readings.truth.time for readings in output.readings.values()} == {output.clock[-1]}
    frames = {robot.parameters.odom_frame for robot in running.robots.values()}
    assert frames == {'robot1/odom', 'robot2/odom'}
    assert running.frames_on_map == ('map', 'robot1/odom', 'robot2/odom')


def test_robots_without_a_place_stand_apart():
    running = session('titan_viii, titan_viii, a1, cuhk')
    standing = list(running.simulation.standing.values())
    for index, (robot, pose) in enumerate(standing):
        for other, place in standing[index + 1 :]:
            assert pose.distance_to(place) > robot.footprint_radius + other.footprint_radius


def test_a_change_spawns_and_removes_and_leaves_the_others():
    running = session('a=a1@0,0,0; b=a1@2,0,0')
    running.advance(Recorded())
    before = running.robots['b']
    running.take_robots('b=a1; c=cuhk@0,0,0')
    assert list(running.robots) == ['b', 'c']
    assert running.robots['b'] is before
    output = Recorded()
    running.advance(output)
    assert output.readings['c'].truth.time == pytest.approx(0.04)


def test_a_change_that_cannot_be_leaves_all_as_it_was():
    running = session('a=a1@0,0,0; b=a1@2,0,0')
    with pytest.raises(PlaceTaken):
        running.take_robots('a=a1; b=a1; c=a1@0.1,0,0')
    with pytest.raises(ParameterError, match='a is a1'):
        running.take_robots('a=cuhk; b=a1')
    assert list(running.robots) == ['a', 'b']


def test_what_a_robot_has_alone_is_refused_for_several_and_the_other_way_round():
    with pytest.raises(ParameterError, match='camera'):
        session('a1, a1', camera=True)
    alone = session('')
    assert type(alone) is SimSession
    with pytest.raises(ParameterError, match='robots'):
        alone.take_robots('a1, a1')


def test_a_robot_is_not_put_back_to_where_another_one_stands():
    running = session('a=a1@0,0,0; b=a1@2,0,0')
    running.reset('b')
    running.robots['a'].simulation.start_pose = Pose2D(1.9, 0.0, 0.0)
    before = running.simulation.standing['a'][1]
    with pytest.raises(PlaceTaken):
        running.reset('a')
    assert running.simulation.standing['a'][1] == before


def test_a_prefix_of_frames_goes_before_the_names_of_robots():
    running = session('a=a1@0,0,0; b=a1@2,0,0', frame_prefix='x_')
    frames = [robot.parameters.odom_frame for robot in running.robots.values()]
    assert frames == ['x_a/odom', 'x_b/odom']


def test_robots_come_to_an_empty_world_and_leave_it():
    running, output = session('none'), Recorded()
    running.advance(output)
    assert (running.robots, running.robots_text) == ({}, 'none')
    assert output.clock
    running.spawn_robot('left', 'a1', Pose2D(1.0, 2.0, 0.5))
    running.advance(output)
    assert output.readings['left'].truth.time == output.clock[-1]
    assert running.observations()['left'].pose.x == pytest.approx(1.0, abs=1e-6)
    running.remove_robot('left')
    assert (running.robots, running.robots_text) == ({}, 'none')
    with pytest.raises(RobotNotFound):
        running.remove_robot('left')


def test_the_text_of_robots_that_came_one_by_one_is_read_as_the_same_robots():
    running = session('a1, cuhk')
    running.spawn_robot('third', 'a1', Pose2D(-3.0, 1.0 / 3.0, 0.1))
    text = running.robots_text
    assert list(robots_from_text(text)) == ['robot1', 'robot2', 'third']
    assert robots_from_text(text)['third'].start == Pose2D(-3.0, 1.0 / 3.0, 0.1)
    before = dict(running.robots)
    running.take_robots(text)
    assert running.robots == before
    again = session(text)
    assert list(again.robots) == list(running.robots)


def test_a_robot_that_cannot_come_changes_nothing():
    running = session('a=a1@0,0,0')
    before = running.robots_text
    for name, kind, start in (
        ('a', 'a1', Pose2D(3.0, 0.0, 0.0)),
        ('b', 'a1', Pose2D(0.1, 0.0, 0.0)),
        ('b', 'no_such', Pose2D(3.0, 0.0, 0.0)),
        ('b', '/a;b.urdf', Pose2D(3.0, 0.0, 0.0)),
        ('b', 'a1', Pose2D(1e300, 0.0, 0.0)),
    ):
        with pytest.raises(QuadError):
            running.spawn_robot(name, kind, start)
        assert (list(running.robots), running.robots_text) == (['a'], before)


def test_a_robot_alone_stays_alone():
    alone = session('')
    assert not alone.can_spawn
    for change in (
        lambda: alone.spawn_robot('b', 'a1', Pose2D(3.0, 0.0, 0.0)),
        lambda: alone.remove_robot('titan_viii'),
    ):
        with pytest.raises(RobotIsAlone, match='robots:=none'):
            change()
    assert list(alone.observations()) == ['titan_viii']


@pytest.mark.parametrize('backend', ['bullet', 'mujoco'])
def test_obstacles_come_to_a_world_without_robots(backend):
    pytest.importorskip({'bullet': 'pybullet', 'mujoco': 'mujoco'}[backend])
    made = SimParameters(backend=backend, map_file='none', robots='none')
    running = session_from_parameters(made, lambda: 0.0)
    box = Obstacle.box(Pose2D(1.0, 0.0, 0.0), 0.2, 0.2, 0.2)
    running.simulation.change_obstacles([ObstacleChange('box', box)], 1)
    assert list(running.simulation.obstacles) == ['box']
    with pytest.raises(TooManyObstacles):
        running.simulation.change_obstacles([ObstacleChange('other', box)], 1)
    with pytest.raises(RobotUnknown):
        running.spawn_robot('a', 'no_such', Pose2D(1.0, 0.0, 0.0))
    running.close()
