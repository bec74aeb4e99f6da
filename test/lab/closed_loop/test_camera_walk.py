"""A whole walk through a room by the ceiling camera alone."""

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.camera_walk import CameraWalk, CameraWalkOptions
from quad_sim.engines.registry import ENGINES, preferred
from quad_sim.world.obstacle_changes import ObstacleChange
from quad_sim.world.random_room import random_room
from quad_sim.world.world import Obstacle

ENGINE = 'mujoco' if ENGINES['mujoco'].is_installed else 'bullet'
"""MuJoCo draws pictures in a tenth of the time."""


def test_the_camera_alone_leads_to_the_goal_around_an_obstacle_that_is_dropped():
    room = random_room(1, start=Pose2D(1.0, 1.0, 0.0))
    options = CameraWalkOptions(gait='wave', method='shortest', picture_period=2.0, noise=4.0)
    pytest.importorskip(ENGINES[ENGINE].package)
    with preferred(ENGINE):
        walk = CameraWalk(load_robot('titan_viii'), room, options)
    dropped = []

    def drop(walk):
        # On the path, well ahead of the robot, once it is on its way.
        pose = walk.watch.fusion.pose
        if dropped or walk.plan is None or walk.simulation.time < 10.0:
            return
        for corner in walk.plan.corners[1:-1].tolist():
            place = Pose2D(*corner, 0.0)
            if place.distance_to(pose) > 1.5 and place.distance_to(room.goal) > 1.5:
                dropped.append(Obstacle.cylinder(place.x, place.y, 0.15, 0.5))
                walk.simulation.change_obstacles([ObstacleChange('dropped', dropped[0])])
                return

    try:
        record = walk.run(900.0, drop)
    finally:
        walk.close()
    assert record.arrived, record.problem
    assert not record.contacts
    assert record.final_error < 0.05
    assert max(record.pose_errors) < 0.03
    assert np.sqrt(np.mean(np.square(record.pose_errors))) < 0.02
    assert record.plans > 1
    [obstacle] = dropped
    place = np.array([obstacle.pose.x, obstacle.pose.y])
    column, row = np.floor(walk.watch.map.world_to_map(place)).astype(int)
    assert walk.watch.map.cells[row, column] == 100
