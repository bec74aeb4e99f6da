"""
The accelerometer measures the mean of the last 20 ms, as one with a filter against aliasing does.
"""

from __future__ import annotations

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_sim.engines.registry import ENGINES, make_simulator
from quad_sim.engines.simulator import GRAVITY, Accelerometer

AT_REST = [0.0, 0.0, GRAVITY]
SOLID = [name for name, engine in ENGINES.items() if engine.has_world and engine.is_installed]


def test_before_any_step_it_measures_gravity():
    assert Accelerometer(0.005).specific_force(np.array([1.0, 0.0, 0.0])).tolist() == AT_REST


def test_a_jolt_within_a_step_counts_by_what_it_changes_in_20_ms():
    accelerometer = Accelerometer(0.005)
    for velocity in (0.0, 0.0, 0.3, 0.3):
        accelerometer.note((velocity, 0.0, 0.0))
    force = accelerometer.specific_force(np.array([0.3, 0.0, 0.0]))
    assert force == pytest.approx([0.3 / 0.02, 0.0, GRAVITY])
    # Three steps later it is over.
    for _ in range(3):
        accelerometer.note((0.3, 0.0, 0.0))
    assert accelerometer.specific_force(np.array([0.3, 0.0, 0.0])) == pytest.approx(AT_REST)


def test_what_was_before_a_reset_counts_no_more():
    accelerometer = Accelerometer(0.005)
    accelerometer.note((5.0, 0.0, 0.0))
    accelerometer.reset()
    accelerometer.note((0.0, 0.0, 0.0))
    assert accelerometer.specific_force(np.zeros(3)) == pytest.approx(AT_REST)


@pytest.mark.parametrize('step', [0.03, 0.002])
def test_a_constant_acceleration_is_measured_with_any_step(step):
    accelerometer = Accelerometer(step)
    times = step * np.arange(30)
    for time in times:
        accelerometer.note((2.0 * time, 0.0, 0.0))
    force = accelerometer.specific_force(np.array([2.0 * (times[-1] + step), 0.0, 0.0]))
    assert force == pytest.approx([2.0, 0.0, GRAVITY])


@pytest.mark.parametrize('backend', SOLID)
def test_a_push_is_measured_as_what_the_body_gains_by_it(backend):
    robot = load_robot('titan_viii')
    simulator = make_simulator(backend, robot, None)
    try:
        simulator.reset(Pose2D(0.0, 0.0, 0.0))
        angles, still = robot.initial_joint_angles.reshape(-1), np.zeros(12)
        for _ in range(200):
            simulator.step(angles, still)
        before = simulator.observe().linear_velocity_base_in_base
        simulator.push(np.array([200.0, 0.0, 0.0]))
        for _ in range(4):
            simulator.step(angles, still)
        seen = simulator.observe()
    finally:
        simulator.close()
    gained = seen.linear_velocity_base_in_base - before
    assert gained[0] > 0.01
    # Bullet measures at the body's center of mass.
    assert seen.specific_force_in_base[0] == pytest.approx(gained[0] / 0.02, rel=0.2)
