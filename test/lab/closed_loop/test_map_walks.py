"""Robots that come with their own descriptions trot through the room, in physics."""

import math

import numpy as np
import pytest

pytest.importorskip('pybullet')

from quad_common.maps.map_file import load_map
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_lab.closed_loop.map_walk import MapWalk
from quad_planner.parameters import PlannerParameters


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('seed', [1, 2, 4, 5])
def test_a_robot_that_rocks_as_it_stops_is_not_thrown_back_by_its_corrections(seed):
    # Behind its third corner a1 shifted its body by 0.1 m in a cycle, met the ground with the feet
    # that swung, was thrown back, and gave up after the third time.
    rng = np.random.default_rng(seed)
    start = Pose2D(1.2 + 0.02 * rng.normal(), 1.2 + 0.02 * rng.normal(), 0.02 * rng.normal())
    walk = MapWalk(
        PlannerParameters(robot='a1', gait='trot'),
        load_map(sample_map('room')),
        start,
        Pose2D(6.8, 4.8, math.pi / 2.0),
        'bullet',
    )
    try:
        record = walk.run(100.0)
        tilt = math.degrees(walk.loop.record.tilts.max())
    finally:
        walk.close()
    assert record.has_arrived, record.reason
    assert tilt < 8.0
