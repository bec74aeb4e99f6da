"""A simulation runs, measures and reports as sim_node has it, without topics."""

import numpy as np
import pytest

from quad_common.errors import QuadError
from quad_common.robot_files.robot_file import load_robot
from quad_common.status import Level
from quad_sim.parameters import SimParameters
from quad_sim.sim_session import SimSession


class Recorded:
    """What a session publishes."""

    def __init__(self):
        self.clock, self.readings = [], []

    def publish_clock(self, time):
        self.clock.append(time)

    def publish_picture(self, time, take):
        raise AssertionError('there is no camera')

    def publish_readings(self, readings, name=''):
        self.readings.append(readings)


class Wall:
    """A wall clock that a test sets."""

    def __init__(self):
        self.time = 0.0

    def __call__(self):
        return self.time


def session(**parameters):
    wall = Wall()
    made = SimParameters(backend='kinematic', map_file='none', **parameters)
    return SimSession(made, load_robot('titan_viii'), wall), wall


def test_between_two_observations_the_clock_ticks_at_100_hz():
    running, _ = session()
    output = Recorded()
    running.advance(output)
    assert np.allclose(output.clock, [0.01, 0.02])
    assert [readings.truth.time for readings in output.readings] == output.clock[1:]


def test_it_waits_for_real_time_and_while_it_is_paused():
    running, wall = session(real_time_factor=1.0)
    running.advance(Recorded())
    assert running.wait() > 0.0
    wall.time = 0.03
    assert running.wait() == 0.0
    running.pause()
    assert (running.wait() > 0.0, running.status().message) == (True, 'paused')
    running.unpause()
    assert running.status().message == 'running'


def test_a_failed_joint_is_news_until_its_status_was_told():
    joint = load_robot('titan_viii').joint_names[0]
    running, _ = session(failing_joint=joint, failure='stuck')
    assert not running.has_news
    running.advance(Recorded())
    assert running.has_news
    status = running.status()
    assert (status.level, status.message) == (Level.WARN, f'{joint} is stuck; reset repairs it')
    assert not running.has_news
    running.reset('')
    assert running.status().level is Level.OK


def test_one_seed_measures_the_same_noise():
    first, second = Recorded(), Recorded()
    for output in (first, second):
        running, _ = session(seed=3)
        running.advance(output)
    assert np.array_equal(first.readings[0].odometry_noise, second.readings[0].odometry_noise)
    assert np.array_equal(first.readings[0].imu_noise, second.readings[0].imu_noise)


def test_nothing_of_a_change_of_parameters_that_is_refused_takes_effect():
    running, _ = session()
    joint = load_robot('titan_viii').joint_names[0]
    change = SimParameters(failing_joint=joint, failure='stuck', robots='a=cuhk')
    with pytest.raises(QuadError, match='robots'):
        running.take_parameters(change)
    running.advance(Recorded())
    assert running.status().level is Level.OK
    running.take_parameters(SimParameters(failing_joint=joint, failure='stuck'))
    running.advance(Recorded())
    assert running.status().message == f'{joint} is stuck; reset repairs it'
