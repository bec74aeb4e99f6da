"""Torques of planned cycles: they hold the robot up, and limits ask whether joints give them."""

import re
from dataclasses import replace

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle import gait_check
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import CycleOptions, generate_steady_cycle
from quad_gait.cycle.joint_torques import (
    TORQUE_USED,
    torque_demand,
    unaided_demand,
    unaided_torques,
)
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.state.foot_forces import foot_forces

UP = np.array([0.0, 0.0, 1.0])
WEIGHT = 9.80665
TITAN, CUHK = load_robot('titan_viii'), load_robot('cuhk')


def cycle_of(robot, gait, motion, samples=80):
    gait = load_gait(gait, robot)
    return generate_steady_cycle(robot, gait, motion, CycleOptions(gait.cycle_period / samples))


def as_strong(robot, gait, motion, fraction):
    """The robot with efforts of which a cycle asks for a fraction at most."""
    demand = unaided_demand(robot, cycle_of(robot, gait, motion))
    return replace(robot, effort=np.full((4, 3), demand.torque / fraction))


@pytest.mark.parametrize('robot', [TITAN, CUHK], ids=lambda robot: robot.name)
def test_torques_of_a_crawl_hold_the_weight_about_the_center_of_mass_on_the_feet_that_stand(robot):
    cycle = cycle_of(robot, 'crawl', BodyMotion(0.2 * robot.largest_stride))
    torques = unaided_torques(robot, cycle)
    for k in range(0, len(cycle.times), 8):
        joints = cycle.joint_positions[k]
        forces = foot_forces(robot, joints, torques[k], UP)
        weight = robot.mass * WEIGHT
        assert forces.sum(axis=0) == pytest.approx([0.0, 0.0, weight], abs=1e-3 * weight)
        assert forces[~cycle.in_contact[k]] == pytest.approx(0.0, abs=1e-6 * weight)
        feet, center = robot.foot_positions(joints), robot.center_of_mass(joints)
        pressed = (forces[:, 2] @ feet[:, :2]) / weight
        assert pressed == pytest.approx(center[:2], abs=1e-3)


def test_a_trot_sideways_takes_forces_that_accelerate_the_body():
    gait = load_gait('trot', TITAN)
    limits = MotionLimits(TITAN, gait)
    cycle = cycle_of(TITAN, 'trot', BodyMotion(left=limits.largest_scale(BodyMotion(left=1.0))))
    torques = unaided_torques(TITAN, cycle)
    sideways = [
        foot_forces(TITAN, cycle.joint_positions[k], torques[k], UP).sum(axis=0)[1]
        for k in range(0, 80, 8)
    ]
    assert np.ptp(sideways) > 0.02 * TITAN.mass * WEIGHT


@pytest.mark.parametrize('gait', ['crawl', 'trot'])
def test_strong_joints_leave_limits_as_they_are_bit_for_bit(gait):
    strong = replace(TITAN, effort=1e3 * TITAN.effort)
    for direction in (BodyMotion(1.0), BodyMotion(left=1.0), BodyMotion(turn=1.0)):
        found = [
            MotionLimits(robot, load_gait(gait, robot)).largest_scale(direction)
            for robot in (TITAN, strong)
        ]
        assert found[0] == found[1]


@pytest.mark.parametrize(('gait', 'fraction'), [('crawl', 0.99 * TORQUE_USED), ('trot', 1.12)])
def test_joints_too_weak_for_what_legs_reach_make_strides_shorter(gait, fraction):
    forward = BodyMotion(1.0)
    strong = MotionLimits(TITAN, load_gait(gait, TITAN)).largest_scale(forward)
    weak = as_strong(TITAN, gait, BodyMotion(), fraction)
    limits = MotionLimits(weak, load_gait(gait, weak))
    most = limits.largest_scale(forward)
    assert 0.0 < most < strong
    assert ' N m' in limits.reason(forward)
    cycle = cycle_of(weak, gait, forward.scaled(most))
    assert torque_demand(weak, cycle).fraction <= TORQUE_USED


def test_joints_too_weak_to_step_on_the_spot_are_named_with_numbers(monkeypatch):
    monkeypatch.setattr(gait_check, 'DIRECTIONS', {'left': BodyMotion(left=1.0)})
    weak = as_strong(TITAN, 'crawl', BodyMotion(), 3.0)
    for problem in gait_check.check_gait(weak, load_gait('crawl', weak)).problems:
        assert re.match(
            r'(stepping on the spot|left: hardly any motion is possible): joint [lr][fh]_hip_pitch_'
            r'joint would have to give \d+\.\d N m .*; 90 % of its largest torque are \d\.\d+ N m',
            problem,
        )


def test_feet_that_pull_at_one_another_never_ask_for_more():
    for fraction in (0.95, 1.2, 3.0):
        weak = as_strong(CUHK, 'trot', BodyMotion(), fraction)
        cycle = cycle_of(weak, 'trot', BodyMotion(left=0.01))
        unaided, aided = unaided_demand(weak, cycle), torque_demand(weak, cycle)
        assert unaided.is_too_much
        assert aided.fraction <= unaided.fraction + 1e-9
