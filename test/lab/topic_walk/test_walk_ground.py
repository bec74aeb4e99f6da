"""Which nodes walk over terrain, and how, by the options of a walk."""

from pathlib import Path

import pytest

from quad_common.planar_pose import Pose2D
from quad_lab.topic_walk import walk
from quad_lab.topic_walk.walk import WalkOptions

ROOM = Path(__file__).parents[3] / 'maps' / 'room.yaml'


class Started:
    """In place of processes: what they would have been started with."""

    def __init__(self):
        self.parameters = {}

    def start(self, name, **parameters):
        self.parameters[name] = parameters


def started(**others):
    nodes = Started()
    here, there = Pose2D(1.2, 1.2, 0.0), Pose2D(2.0, 1.2, 0.0)
    walk._start_nodes(nodes, WalkOptions(ROOM, here, there, robot='cuhk', **others))
    return nodes.parameters


@pytest.mark.parametrize(
    ('gait', 'balance', 'ground'),
    [
        ('crawl', False, 'uneven'),
        ('crawl', True, 'uneven'),
        ('trot', True, 'flat'),
    ],
)
def test_feet_feel_for_terrain_unless_the_gait_keeps_its_balance(gait, balance, ground):
    nodes = started(gait=gait, balance=balance, terrain='bumps')
    assert nodes['gait_node'].get('ground', 'flat') == ground
    assert nodes['gait_node']['balance'] is balance
    assert nodes['sim_node']['terrain'] == 'bumps'


def test_level_ground_is_not_felt_for():
    assert 'ground' not in started(gait='crawl', balance=False)['gait_node']


@pytest.mark.parametrize('gait', ['crawl', 'trot'])
def test_over_terrain_the_simulator_waits_for_the_gait_unless_a_pace_is_asked_for(gait):
    options = {'gait': gait, 'balance': True, 'terrain': 'bumps'}
    assert started(**options)['sim_node']['real_time_factor'] == 0.0
    assert started(**options, real_time_factor=1.5)['sim_node']['real_time_factor'] == 1.5
