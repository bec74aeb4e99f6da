"""Several robots in one simulation: how they are named, placed, spawned and removed."""

import pytest

from quad_common.errors import ParameterError, PlaceTaken
from quad_common.planar_pose import Pose2D
from quad_sim.fleet_session import FleetSession, session_from_parameters
from quad_sim.fleet_text import robots_from_text
from quad_sim.parameters import SimParameters
from quad_sim.sim_session import SimSession


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
