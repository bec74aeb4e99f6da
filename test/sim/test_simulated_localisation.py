"""Simulated odometry drifts as stated, and the localiser beside it knows where the robot is."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot_files.robot_file import load_robot
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.simulated_localisation import (
    DriftingOdometry,
    LocalisationOptions,
    SimulatedLocalisation,
)

START = Pose2D(1.0, 2.0, 0.5)
STEP = Pose2D(0.01, 0.0, 0.0)
"""Of a robot that walks ahead, between two observations."""


def drifted(drift, seed, moves):
    """Return where a robot is, and where odometry has it."""
    odometry = DriftingOdometry(drift, np.random.default_rng(seed))
    pose = START
    told = odometry.locate(pose)
    assert told == START
    for move in moves:
        pose = pose @ move
        told = odometry.locate(pose)
    return pose, told


def test_the_length_of_a_way_is_wrong_by_the_drift():
    fractions = []
    for seed in range(200):
        told = drifted(0.03, seed, [STEP] * 300)[1]
        distance = math.hypot(told.x - 1.0, told.y - 2.0)
        fractions.append(distance / 3.0 - 1.0)
        assert abs(fractions[-1]) < 0.09
    # To either side, and as much as stated: a bent path is only a little shorter.
    assert 0.02 < np.sqrt(np.mean(np.square(fractions))) < 0.045
    assert min(fractions) < -0.01 < 0.01 < max(fractions)


def test_the_heading_drifts_with_the_way_and_with_turns():
    straight = [wrap_angle(drifted(0.03, s, [STEP] * 100)[1].yaw - 0.5) for s in range(100)]
    assert 0.02 < np.sqrt(np.mean(np.square(straight))) < 0.045
    turn = [Pose2D(0.0, 0.0, 0.01)] * 200
    turned = [wrap_angle(drifted(0.03, s, turn)[1].yaw - 2.5) for s in range(100)]
    assert 0.04 < np.sqrt(np.mean(np.square(turned))) < 0.09


def test_a_robot_that_stands_does_not_drift():
    assert drifted(0.1, 0, [Pose2D(0.0, 0.0, 0.0)] * 1000)[1] == Pose2D(1.0, 2.0, 0.5)


def test_one_seed_is_one_drift():
    moves = [Pose2D(0.002, 0.001, 0.003)] * 300
    assert drifted(0.03, 5, moves) == drifted(0.03, 5, moves)
    assert drifted(0.03, 5, moves) != drifted(0.03, 6, moves)


def observed(pose):
    simulator = KinematicSimulator(load_robot('titan_viii'), 0.005)
    simulator.reset(pose)
    return simulator.observe()


def test_without_drift_odometry_is_the_truth_itself_and_without_a_rate_nothing_corrects_it():
    exact = SimulatedLocalisation(LocalisationOptions())
    seen = observed(Pose2D(1.0, 2.0, 0.5))
    assert exact.is_exact
    assert exact.observe(seen) is seen
    assert exact.correction(seen, seen) is None


def moved_to(seen, time, pose):
    """Return an observation of a robot that stands elsewhere."""
    half = pose.yaw / 2.0
    return replace(
        seen,
        time=time,
        position=np.array([pose.x, pose.y, seen.position[2]]),
        orientation=np.array([0.0, 0.0, math.sin(half), math.cos(half)]),
    )


def test_the_localiser_speaks_at_its_rate_and_knows_the_robot_within_its_noise():
    options = LocalisationOptions(0.1, rate=2.0, noise=0.02, heading_noise=0.01, seed=3)
    localisation = SimulatedLocalisation(options)
    first = observed(Pose2D(1.0, 2.0, 0.5))
    errors, times = [], []
    for step in range(2000):
        pose = Pose2D(1.0, 2.0, 0.5) @ Pose2D(0.002 * step, 0.0, 0.0)
        seen = moved_to(first, 0.02 * step, pose)
        told = localisation.observe(seen)
        correction = localisation.correction(seen, told)
        if correction is not None:
            place = correction @ told.pose
            times.append(seen.time)
            errors.append((place.x - pose.x, place.y - pose.y, wrap_angle(place.yaw - pose.yaw)))
    assert np.diff(times) == pytest.approx(0.5)
    assert np.std(errors, axis=0) == pytest.approx([0.02, 0.02, 0.01], rel=0.3)
    assert told.pose.distance_to(pose) > 0.1


def test_odometry_of_a_tilted_body_keeps_its_tilt():
    localisation = SimulatedLocalisation(LocalisationOptions(0.3, seed=1))
    first = observed(Pose2D(0.0, 0.0, 0.0))
    localisation.observe(first)
    tilted = moved_to(first, 1.0, Pose2D(1.0, 0.0, 0.0))
    tilted = replace(tilted, orientation=np.array([0.1, 0.0, 0.0, 0.994987]))
    told = localisation.observe(tilted)
    x, y, _, _ = told.orientation
    assert math.hypot(x, y) == pytest.approx(0.1)
    assert np.linalg.norm(told.orientation) == pytest.approx(1.0, abs=1e-5)
    assert told.position[2] == tilted.position[2]


def test_put_back_to_its_start_the_robot_is_where_odometry_says():
    localisation = SimulatedLocalisation(LocalisationOptions(0.3, rate=1.0))
    first = observed(Pose2D(0.0, 0.0, 0.0))
    localisation.observe(first)
    localisation.observe(moved_to(first, 1.0, Pose2D(2.0, 0.0, 0.0)))
    localisation.reset()
    assert localisation.observe(moved_to(first, 2.0, Pose2D(0.0, 0.0, 0.0))).pose == first.pose
