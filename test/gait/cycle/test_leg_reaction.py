"""A trotting body gives way to its legs, so that no moment is left that two feet cannot give."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from quad_common.planar_pose import Twist2D
from quad_common.robot.leg_moments import LegCycle, leg_moments
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot

pytest.importorskip('yourdfpy')

from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import CycleEnds
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import (
    CycleOptions,
    generate_cycle,
    generate_steady_cycle,
    leg_reaction,
)

GRAVITY = 9.80665
SAMPLES = 128


@pytest.fixture(scope='module')
def robot(tmp_path_factory):
    """A cuhk with legs that are heavy beside its body, and their inertias."""
    shipped = load_robot('cuhk')
    links = {kind: replace(link, mass=6.0 * link.mass) for kind, link in shipped.links.items()}
    folder = tmp_path_factory.mktemp('cuhk')
    description = folder / 'described.urdf'
    description.write_text(urdf_from_robot(replace(shipped, links=links)))
    return load_robot(write_robot(import_robot(description), folder / 'imported.yaml')[0])


@pytest.fixture(scope='module')
def without(robot):
    """The same robot in a file that says nothing of inertias."""
    return replace(robot, exact_masses=replace(robot.exact_masses, inertias=None))


def trot(robot):
    return load_gait('trot', robot)


def steady(robot, motion):
    gait = trot(robot)
    return generate_steady_cycle(robot, gait, motion, CycleOptions(gait.cycle_period / SAMPLES))


def first_wave(values):
    """The sine of a support in samples of a cycle."""
    return -2.0 * np.fft.rfft(values[:-1])[2].imag / (len(values) - 1)


def little(robot, side):
    motion = 0.05 * robot.hip_height
    return BodyMotion(left=motion) if side else BodyMotion(forward=motion)


@pytest.mark.parametrize('side', [0, 1])
def test_the_body_makes_up_for_the_first_wave_of_its_legs_moments(robot, without, side):
    motion = little(robot, side)
    giving, stiff = steady(robot, motion), steady(without, motion)
    gait = giving.gait
    heights = np.full(SAMPLES + 1, robot.standing_height)
    cycle = LegCycle(stiff.joint_positions[:-1], heights[:-1], gait.cycle_period)
    legs = leg_moments(robot.stacked_legs, robot.exact_masses, cycle)[:, side]
    legs = first_wave(np.append(legs, legs[0]))
    wave = first_wave(giving.body[:, side] - stiff.body[:, side])
    height = GRAVITY / gait.pendulum_rate**2
    rate = 4.0 * np.pi / gait.cycle_period
    # A mass that swings by a wave weighs m g c ahead, and takes -m h c'' to be swung.
    body = robot.mass * wave * (GRAVITY + height * rate**2)
    size = abs(motion.forward) + abs(motion.left)
    assert abs(legs) > 0.01 * robot.mass * GRAVITY * size
    assert body == pytest.approx(-legs, rel=0.05)


def test_heavy_legs_take_more_than_a_thousandth_of_the_stride(robot):
    assert np.abs(leg_reaction(robot, trot(robot))).max() > 1e-3


@pytest.mark.parametrize('gait', ['crawl', 'wave'])
def test_static_gaits_give_way_to_nothing(robot, gait):
    assert not np.any(leg_reaction(robot, load_gait(gait, robot)))


def test_without_inertias_the_body_moves_as_if_legs_had_no_mass(without):
    assert not np.any(leg_reaction(without, trot(without)))


def test_supports_of_unequal_length_are_left_as_they_are(robot):
    gait = trot(robot)
    later = [
        replace(swing, liftoff=swing.liftoff + 0.02, touchdown=swing.touchdown + 0.02)
        for swing in gait.swings[2:]
    ]
    period = gait.cycle_period + 0.04
    uneven = replace(gait, swings=(*gait.swings[:2], *later), cycle_period=period)
    assert uneven.support_edges[1] != pytest.approx(period / 2.0, abs=1e-3)
    assert not np.any(leg_reaction(robot, uneven))


MOTIONS = [
    (Twist2D(), Twist2D(0.1, 0.0, 0.4)),
    (Twist2D(0.1, 0.05, 0.4), Twist2D(0.1, 0.05, 0.4)),
    (Twist2D(0.0, 0.1, 0.0), Twist2D(0.08, 0.0, -0.4)),
    (Twist2D(0.1, 0.0, 0.4), Twist2D()),
]


def planned(robot, entry, exit):
    gait = trot(robot)
    period, part = gait.cycle_period, gait.acceleration_fraction
    motion = BodyMotion.during(entry.scaled(1.0 - part).plus(exit.scaled(part)), period)
    options = CycleOptions(period / 400)
    start = steady(robot, BodyMotion.during(entry, period)).end_feet if entry else None
    return generate_cycle(robot, gait, motion, CycleEnds(start, entry, exit), options)


@pytest.mark.parametrize(('entry', 'exit'), MOTIONS)
def test_speeds_are_the_derivative_of_places(robot, entry, exit):
    cycle = planned(robot, entry, exit)
    step = cycle.times[1]
    middle = 0.5 * (cycle.joint_velocities[1:] + cycle.joint_velocities[:-1])
    found = np.diff(cycle.joint_positions, axis=0) / step
    assert found == pytest.approx(middle, abs=0.02 * np.abs(middle).max())


@pytest.mark.parametrize(('entry', 'exit'), MOTIONS)
def test_the_body_goes_as_far_as_without(robot, without, entry, exit):
    giving, stiff = (planned(own, entry, exit) for own in (robot, without))
    assert giving.body[[0, -1]] == pytest.approx(stiff.body[[0, -1]], abs=1e-12)
    assert np.abs(giving.body - stiff.body).max() > 1e-5


def test_cycles_join_in_joint_angles_and_speeds(robot):
    speeds = [Twist2D(), Twist2D(0.1, 0.0, 0.3), Twist2D(0.1, 0.05, 0.0), Twist2D()]
    gait = trot(robot)
    options = CycleOptions(gait.cycle_period / 100)
    feet, before = None, None
    for entry, exit in pairwise(speeds):
        part = gait.acceleration_fraction
        mean = entry.scaled(1.0 - part).plus(exit.scaled(part))
        motion = BodyMotion.during(mean, gait.cycle_period)
        cycle = generate_cycle(robot, gait, motion, CycleEnds(feet, entry, exit), options)
        if before is not None:
            assert cycle.joint_positions[0] == pytest.approx(before.joint_positions[-1], abs=1e-9)
            assert cycle.joint_velocities[0] == pytest.approx(before.joint_velocities[-1], abs=1e-6)
        feet, before = cycle.end_feet, cycle
