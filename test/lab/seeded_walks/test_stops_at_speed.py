"""A fast trot stops upright wherever the stop falls in its cycles."""

import math

import numpy as np
import pytest

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import measuring_controller
from quad_sim.engines.registry import ENGINES, engines_with


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('backend', engines_with('has_world'))
@pytest.mark.parametrize('length', [2.8, 2.82, 2.84])
def test_an_imported_robot_stays_level_when_it_stops_from_its_largest_speed(backend, length):
    pytest.importorskip('pybullet_data')
    pytest.importorskip(ENGINES[backend].package)
    robot = load_robot('a1')
    controller = measuring_controller(robot, load_gait('trot', robot))
    loop = ClosedLoop(robot, controller, backend)
    try:
        loop.run(0.1)
        controller.set_plan(Plan((Pose2D(0.0, 0.0, 0.0), Pose2D(length, 0.0, 0.0))))
        loop.run(10.0, until=lambda: controller.activity is Activity.ARRIVED)
        assert controller.activity is Activity.ARRIVED
        assert np.max(loop.record.tilts) < math.radians(8.0)
    finally:
        loop.close()
