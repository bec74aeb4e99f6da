"""By drifting odometry and a localiser the robot gets to its goal in the map."""

import math

import pytest

from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.localised_walk import LocalisedWalk
from quad_sim.simulated_localisation import LocalisationOptions

START, GOAL = Pose2D(1.2, 1.2, 0.0), Pose2D(2.0, 1.2, 0.3)
DRIFTING = LocalisationOptions(0.1, 1.0, 0.02, 0.01, seed=4)


def walked(options):
    walk = LocalisedWalk(load_robot('titan_viii'), sample_map(), START, GOAL, options, 'kinematic')
    try:
        return walk.run(200.0)
    finally:
        walk.close()


def test_corrections_bring_the_robot_to_its_goal_in_the_map():
    record = walked(DRIFTING)
    assert (record.has_arrived, record.reason) == (True, 'the goal is reached')
    assert record.position_error < 0.05
    assert record.heading_error < math.radians(5.0)
    assert record.odometry_error > 0.05


def test_without_corrections_it_believes_its_odometry():
    record = walked(LocalisationOptions(0.1, seed=4))
    assert record.has_arrived
    assert record.position_error > 0.05


def test_without_drift_the_pose_is_the_truth():
    record = walked(LocalisationOptions())
    assert record.has_arrived
    assert record.largest_pose_error == 0.0
    assert record.odometry_error == pytest.approx(0.0, abs=1e-12)
