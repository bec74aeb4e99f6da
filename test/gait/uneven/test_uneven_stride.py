"""Strides over uneven ground: a swing at a time, ended by what the foot meets."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from quad_common.errors import FootholdNotFound, ParameterError
from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, Twist2D
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_common.rotations import tilt_from_quaternion
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.footsteps import footstep_options
from quad_gait.footsteps.footstep_options import FootstepOptions
from quad_gait.parameters import GaitParameters
from quad_gait.state.measurement import Measurement
from quad_gait.state.stance import Stance
from quad_gait.state.state_estimator import StateEstimator
from quad_gait.supervisor import Supervisor
from quad_gait.uneven import uneven_stride
from quad_gait.uneven.foot_contact import may_stand
from quad_gait.uneven.stride_goal import StrideGoal
from quad_gait.uneven.swing_planner import SwingPlanner
from quad_gait.uneven.uneven_options import UnevenOptions, check_suits_uneven_ground
from quad_gait.uneven.uneven_stride import UnevenStride
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.engines.registry import AUTO, ENGINES
from quad_sim.simulation import Simulation
from quad_sim.world.terrain import Block, Terrain
from quad_sim.world.world import world_from_map

TITAN = load_robot('titan_viii')
ORIGIN = Pose2D(0.0, 0.0, 0.0)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
AHEAD = BodyMotion(forward=0.2)
WEIGHT = TITAN.mass * 9.80665
ENGINE = 'mujoco' if ENGINES['mujoco'].is_installed else AUTO
"""Walks take a third of the time in it; fixed walks climb the same in PyBullet."""


def controller_for(robot, height_map=None, **options):
    gait = load_gait('crawl', robot)
    controller = Supervisor(
        robot,
        gait,
        turning_gait_for(gait, robot),
        SupervisorOptions(uneven=UnevenOptions(), **options),
    )
    controller.set_height_map(height_map)
    return controller


def world_with(*blocks, resolution=0.02):
    field = HeightMap.level((-2.0, -2.0, 4.0, 2.0), resolution)
    return replace(world_from_map(None), terrain=Terrain(field, blocks))


def walked(robot, world, length, height_map=None, turn_first=False):
    """Walk straight on in physics, and return the walk and the controller."""
    controller = controller_for(robot, height_map)
    walk = ClosedLoop(robot, controller, ENGINE, world)
    try:
        walk.run(0.5)
        end = [0.0, length] if turn_first else [length, 0.0]
        controller.set_plan(Plan.through([[0.0, 0.0], end], math.pi / 2 if turn_first else 0.0))
        over = (Activity.ARRIVED, Activity.BLOCKED, Activity.STOPPED, Activity.FALLEN)
        walk.run(120.0, lambda: controller.activity in over)
    finally:
        walk.close()
    return walk, controller


SOFT = 0.003
"""By which ground gives way under a foot that bears load [m]."""


class Legs:
    """
    A robot that does what it is told, over ground of a height under each foot.

    A foot that is commanded below its ground stays on it, and its load rises.
    """

    def __init__(self, heights=(0.0, 0.0, 0.0, 0.0)):
        self.time = 1.0
        self.joints = TITAN.initial_joint_angles.copy()
        self.ground = TITAN.neutral_feet[:, 2] + heights
        self.trajectory = None
        self.orientation = LEVEL
        self.edge = math.inf
        """Beyond this x there is no ground [m]."""
        self.bearing = None
        """Legs whose feet bear load in any case, and no others; None: those that are down."""

    def stance(self):
        feet = TITAN.foot_positions(self.joints)
        ground = np.where(feet[:, 0] > self.edge, -1.0, self.ground)
        under = np.clip(ground - feet[:, 2] + SOFT, 0.0, None)
        if self.bearing is not None:
            under = np.isin(np.arange(4), self.bearing)
        return Stance.measured(
            TITAN, self.time, ORIGIN, self.orientation, self.joints.reshape(-1), None
        ), np.where(under > 0.0, 0.3 * WEIGHT, 0.0)

    def measure(self):
        stance, loads = self.stance()
        return replace(stance, find_loads=lambda: loads)

    def run(self, stride, seconds):
        for _ in range(round(seconds / 0.02)):
            trajectory = stride.update(self.measure())
            if trajectory is not None:
                self.trajectory, self.heard = trajectory, self.time
            if stride.is_over:
                return True
            self.time += 0.02
            t = self.trajectory
            at = self.time - self.heard
            if at >= t.times[0]:
                joints = [np.interp(at, t.times, t.positions[:, k]) for k in range(12)]
                self.joints = np.reshape(joints, (4, 3))
        return False


def stride_for(motion=AHEAD, height_map=None, robot=TITAN):
    gait = load_gait('crawl')
    goal = StrideGoal.of(robot, gait, motion, ORIGIN)
    return UnevenStride(robot, gait.swing_height, goal, height_map, UnevenOptions())


def test_legs_swing_in_the_order_of_the_gait_and_one_at_a_time():
    legs, stride = Legs(), stride_for()
    lifted = []
    for _ in range(600):
        if legs.run(stride, 0.02):
            break
        up = [leg for leg, down in zip(LEGS, stride.in_contact) if not down]
        assert len(up) <= 1
        lifted += [leg for leg in up if lifted[-1:] != [leg]]
    assert stride.is_over
    assert lifted == [swing.leg for swing in load_gait('crawl').swings]


def test_without_loads_feet_land_where_the_ground_is_expected():
    robot = TITAN
    simulation = Simulation(KinematicSimulator(robot, 0.01), robot, ORIGIN)
    stride = stride_for()
    for _ in range(1000):
        seen = simulation.observe()
        stance = Stance.measured(
            robot, seen.time, seen.pose, seen.orientation, seen.joint_positions, None
        )
        trajectory = stride.update(stance)
        if trajectory is not None:
            simulation.accept(trajectory)
        if stride.is_over:
            break
        simulation.step()
    assert stride.is_over
    assert simulation.observe().pose.x == pytest.approx(0.2, abs=0.003)
    assert stance.feet[:, 2] == pytest.approx(np.full(4, stance.feet[0, 2]), abs=2e-3)


@pytest.mark.parametrize('height', [-0.03, 0.03])
def test_a_foot_stops_where_it_meets_the_ground(height):
    # The first leg to swing is the left hind one.
    legs = Legs()
    legs.ground[2] += height
    legs.joints[2] = TITAN.legs[2].inverse(TITAN.neutral_feet[2] + [0.0, 0.0, height])
    stride = stride_for()
    feet = []
    while len(feet) < 400 and not (feet and stride.in_contact[2] and len(feet) > 60):
        legs.run(stride, 0.02)
        feet.append(legs.measure().feet[2, 2])
    assert feet[-1] == pytest.approx(legs.ground[2], abs=0.008)


def lifted(**options):
    """Return legs of which the left hind one was just lifted, over a map of level ground."""
    shown = HeightMap.level((-1.0, -1.0, 1.0, 1.0), 0.02)
    legs, stride = Legs(), stride_for(**{'height_map': shown, **options})
    while stride.in_contact[2]:
        legs.run(stride, 0.02)
    legs.run(stride, 0.3)
    return legs, stride


def lean_by(legs, angle):
    """Let the body tip over its two feet: seen from the level, those on its sides sink, or rise."""
    legs.orientation = np.array([math.sin(angle / 2.0), 0.0, 0.0, math.cos(angle / 2.0)])


def below_its_neighbour(feet):
    """Return how far hind feet are below front feet of their side: leaning changes both alike."""
    return feet[:2, 2] - feet[2:, 2]


@pytest.mark.parametrize(
    ('lean', 'has_map', 'slips'),
    [(0.01, True, False), (0.03, True, True), (-0.12, True, True), (0.12, False, False)],
)
def test_feet_are_put_down_at_once_where_another_one_slips(lean, has_map, slips):
    legs, stride = lifted() if has_map else lifted(height_map=None)
    lean_by(legs, lean)
    legs.run(stride, 0.02)
    assert ('a foot has slipped, so lh is put down again' in stride.limit) == slips
    if slips:
        ends = legs.trajectory.positions.reshape(-1, 4, 3)[[0, -1]]
        start, end = (below_its_neighbour(TITAN.foot_positions(joints)) for joints in ends)
        assert end[0] > start[0] + 0.003
        assert end[1] == pytest.approx(start[1], abs=0.003)
    legs.orientation = LEVEL
    assert legs.run(stride, 30.0)


def test_a_foot_put_down_at_once_is_lowered_until_its_load_is_sure():
    legs, stride = lifted()
    lean_by(legs, 0.12)
    # Two feet hang. A leg that is set in motion quickly seems to bear load for a moment.
    legs.bearing = [0, 3]
    legs.run(stride, 0.02)
    start = below_its_neighbour(legs.measure().feet)
    legs.bearing = [0, 1, 2, 3]
    legs.run(stride, 0.02)
    legs.bearing = [0, 3]
    legs.run(stride, 0.14)
    lowered = below_its_neighbour(legs.measure().feet) - start
    assert lowered[0] > 0.008
    assert lowered[1] < -0.008
    # One that bears load twice has met the ground, the other one is lowered on.
    legs.bearing = [0, 1, 3]
    legs.run(stride, 0.06)
    met = below_its_neighbour(legs.measure().feet)
    legs.run(stride, 0.1)
    lowered = below_its_neighbour(legs.measure().feet) - met
    assert lowered[0] > 0.008
    assert lowered[1] == pytest.approx(0.0, abs=0.004)


def meet_something(legs, stride):
    """Let the first foot bear load while it is on its way to its place."""
    start = top = legs.measure().feet[2, 2]
    while top < start + 0.02 or legs.measure().feet[2, 2] > top + 1e-5:
        top = legs.measure().feet[2, 2]
        legs.run(stride, 0.02)
    legs.run(stride, 0.06)
    legs.bearing = [0, 1, 2, 3]
    legs.run(stride, 0.04)
    legs.bearing = None
    return top


def test_a_foot_is_lifted_over_what_it_meets_on_its_way():
    legs, stride = Legs(), stride_for()
    top = meet_something(legs, stride)
    assert not stride.in_contact[2]
    heights = []
    while not stride.in_contact[2]:
        legs.run(stride, 0.02)
        heights.append(legs.measure().feet[2, 2])
    assert max(heights) > top + 0.02
    assert heights[-1] == pytest.approx(legs.ground[2], abs=0.008)
    assert legs.run(stride, 30.0)


def test_a_foot_that_meets_something_again_and_again_stands_on_it(monkeypatch):
    # Unless that is a wall, which this is as high as.
    monkeypatch.setattr(uneven_stride, 'may_stand', lambda *_: True)
    legs, stride = Legs(), stride_for()
    for _ in range(2):
        meet_something(legs, stride)
        assert not stride.in_contact[2]
    meet_something(legs, stride)
    assert stride.in_contact[2]


def test_a_step_up_is_no_slip_where_motors_tell_no_loads():
    level = HeightMap.level((-1.0, -1.0, 1.0, 1.0), 0.02)
    kerb = level.with_heights(np.where(level.centers[..., 0] > 0.3, 0.05, 0.0))
    legs, stride = Legs(), stride_for(height_map=kerb)
    legs.measure = lambda: replace(legs.stance()[0], find_loads=lambda: None)
    assert legs.run(stride, 30.0)
    assert 'slipped' not in stride.limit
    heights = legs.measure().feet[:, 2]
    assert np.ptp(heights) == pytest.approx(0.05, abs=0.002)


def test_a_foot_that_finds_no_ground_goes_back_to_where_it_stood():
    legs, stride = Legs(), stride_for()
    start = legs.measure().feet[2].copy()
    while stride.in_contact[2]:
        legs.run(stride, 0.02)
    # The front feet stand beyond it, but only the hind one is looked at.
    legs.edge = start[0] + 0.1
    farthest = start[0]
    for _ in range(400):
        legs.run(stride, 0.02)
        farthest = max(farthest, legs.measure().feet[2, 0])
        if stride.in_contact[2]:
            break
    assert farthest > legs.edge
    assert stride.in_contact[2]
    assert legs.measure().feet[2] == pytest.approx(start, abs=0.08)
    assert legs.measure().feet[2, 2] == pytest.approx(start[2], abs=0.01)


def test_a_foot_on_its_way_back_stands_on_what_it_meets():
    legs, stride = Legs(), stride_for()
    while stride.in_contact[2]:
        legs.run(stride, 0.02)
    legs.edge = legs.measure().feet[2, 0] + 0.1
    farthest = -math.inf
    while legs.measure().feet[2, 0] > farthest - 0.03:
        farthest = max(farthest, legs.measure().feet[2, 0])
        legs.run(stride, 0.02)
    legs.bearing = [0, 1, 2, 3]
    legs.run(stride, 0.3)
    # It does not go again to where there was no ground.
    assert stride.in_contact[2]


def test_a_foot_that_finds_no_ground_anywhere_is_named():
    legs, stride = Legs(), stride_for()
    while stride.in_contact[2]:
        legs.run(stride, 0.02)
    legs.ground[2] -= 1.0
    with pytest.raises(FootholdNotFound, match='foot lh met no ground'):
        legs.run(stride, 10.0)


def test_a_foot_in_the_air_is_lowered_before_the_first_swing():
    legs, stride = Legs(), stride_for()
    legs.ground[1] -= 0.02
    legs.run(stride, 0.8)
    assert legs.measure().feet[1, 2] == pytest.approx(legs.ground[1], abs=0.005)


@pytest.mark.parametrize('leg', range(4))
def test_a_foot_in_the_air_that_gets_no_farther_down_swings_first(monkeypatch, leg):
    """Its leg was stretched to the end: each stride failed before it began."""
    legs, stride = Legs(), stride_for()
    legs.ground[leg] -= 0.02

    gets_no_farther(monkeypatch, leg)
    assert stride.update(legs.measure()) is not None
    assert stride.leg == leg


@pytest.mark.parametrize('leg', range(4))
def test_a_foot_that_was_lowered_in_vain_swings_first(leg):
    """Another one was lifted, the body led over a foot that hung in the air, and the robot fell."""
    legs, stride = Legs(), stride_for()
    legs.ground[leg] -= 0.12
    before = legs.measure().feet[leg, 2]
    # The search takes 0.65 s.
    legs.run(stride, 0.8)
    assert legs.measure().feet[leg, 2] < before - 0.05
    while stride.in_contact.all():
        legs.run(stride, 0.02)
    assert stride.leg == leg


def test_a_lift_that_never_came_to_the_joints_is_given_out_again():
    """The foot that was to be in the air stood still: that was taken for something it had met."""
    legs, stride = Legs(), stride_for()
    while stride.in_contact[2]:
        legs.run(stride, 0.02)
    # It was lost, with the foot still on the ground.
    legs.bearing = [0, 1, 2, 3]
    stood, due, again = below_its_neighbour(legs.measure().feet)[0], stride.end, None
    while again is None:
        legs.time += 0.02
        assert legs.time < due + 2.0
        again = stride.update(legs.measure())
    assert legs.time > due - 1.0
    lifted = below_its_neighbour(TITAN.foot_positions(again.positions[-1].reshape(4, 3)))[0]
    assert lifted < stood - 0.01


def test_a_lost_shift_is_given_out_again():
    """Its samples were compared with those of the swing before, whose foot stands by then."""
    legs, stride = Legs(), stride_for()
    while stride.leg != 1 or stride.in_contact[1]:
        legs.run(stride, 0.02)
    # As where a foot is searched deeper for: it may feel from the beginning.
    stride._swinging = replace(stride._swinging, feels_from=0)
    # From where the last foot has landed on, nothing comes to the joints.
    while not stride.in_contact[1]:
        legs.run(stride, 0.02)
    assert not stride.is_over
    given, due = 0, stride.end
    while not stride.is_over:
        legs.time += 0.02
        assert legs.time < due + 8.0
        given += stride.update(legs.measure()) is not None
    assert given == 2


@pytest.mark.parametrize('leg', range(4))
def test_no_other_foot_is_lifted_while_one_hangs_in_the_air(monkeypatch, leg):
    legs, stride = Legs(), stride_for()
    legs.ground[leg] -= 0.02
    gets_no_farther(monkeypatch, leg)

    def swings(planner, now, commanded, ground, swinging, place, stands=True):
        if swinging == leg:
            raise FootholdNotFound(LEGS[leg], 0.1)
        raise AssertionError('another leg was to swing')

    monkeypatch.setattr(SwingPlanner, 'swing', swings)
    with pytest.raises(FootholdNotFound):
        stride.update(legs.measure())


def test_a_foot_that_can_be_lowered_is_while_another_one_cannot(monkeypatch):
    legs, stride = Legs(), stride_for()
    legs.ground[[1, 3]] -= 0.02
    gets_no_farther(monkeypatch, 1)
    trajectory = stride.update(legs.measure())
    moved = np.abs(trajectory.positions - trajectory.positions[0]).max(axis=0).reshape(4, 3)
    assert np.flatnonzero(moved.max(axis=1) > 1e-4).tolist() == [3]


def test_feet_are_not_swung_where_two_hang(monkeypatch):
    legs, stride = Legs(), stride_for()
    legs.ground[[1, 3]] -= 0.02
    gets_no_farther(monkeypatch, 1, 3)
    with pytest.raises(FootholdNotFound):
        stride.update(legs.measure())


def gets_no_farther(monkeypatch, *hanging):
    """Let some legs be stretched to the end."""
    search = SwingPlanner.search

    def searched(planner, now, commanded, legs, quickly=False):
        for leg in hanging:
            if leg in legs:
                raise FootholdNotFound(LEGS[leg], 0.0)
        return search(planner, now, commanded, legs, quickly)

    monkeypatch.setattr(SwingPlanner, 'search', searched)


@pytest.mark.parametrize('sees', [True, False])
def test_a_kerb_is_climbed_with_the_body_level(sees):
    world = world_with(Block(Pose2D(1.0, 0.0, 0.0), 1.2, 3.0, 0.05))
    heights = world.terrain.height_map if sees else None
    walk, controller = walked(TITAN, world, 0.9, heights)
    assert controller.activity is Activity.ARRIVED, controller.reason
    assert max(walk.record.tilts) < math.radians(2.5)
    assert min(walk.record.margins) > 0.01
    if sees:
        assert walk.simulation.contacts_seen == set()


def test_a_small_robot_climbs_a_kerb_and_its_shins_keep_off_the_edge():
    world = world_with(Block(Pose2D(0.45, 0.0, 0.0), 0.6, 1.2, 0.021), resolution=0.01)
    walk, controller = walked(load_robot('genibo'), world, 0.6, world.terrain.height_map)
    assert controller.activity is Activity.ARRIVED, controller.reason
    assert walk.simulation.contacts_seen == set()
    assert max(walk.record.tilts) < math.radians(1.5)


def test_the_robot_turns_on_bumps():
    blocks = [
        Block(Pose2D(x, y, 0.3), 0.15, 0.1, 0.03)
        for x, y in [(0.35, 0.4), (-0.3, 0.35), (0.3, -0.35), (-0.05, 0.6), (0.35, 0.15)]
    ]
    world = world_with(*blocks)
    walk, controller = walked(TITAN, world, 0.4, world.terrain.height_map, turn_first=True)
    assert controller.activity is Activity.ARRIVED, controller.reason
    assert walk.record.poses[-1].yaw == pytest.approx(math.pi / 2, abs=0.05)
    assert max(walk.record.tilts) < math.radians(4.0)


def test_steering_works_as_on_flat_ground():
    controller = controller_for(TITAN, twist_timeout=math.inf)
    walk = ClosedLoop(TITAN, controller, ENGINE)
    try:
        walk.run(0.5)
        controller.set_twist(Twist2D(forward=0.03))
        walk.run(15.0)
        assert walk.record.poses[-1].x > 0.25
        controller.stop()
        walk.run(12.0)
        assert controller.activity is Activity.STANDING
    finally:
        walk.close()


def test_a_problem_is_said_and_stays_said(monkeypatch):
    # Footsteps are looked for again and again, and not found: it need not be everywhere.
    briefly = partial(FootstepOptions, most_expansions=100, coarse_expansions=100)
    monkeypatch.setattr(footstep_options, 'FootstepOptions', briefly)
    controller = controller_for(TITAN)
    walk = ClosedLoop(TITAN, controller, ENGINE, world_with())
    try:
        walk.run(0.5)
        controller.set_plan(Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0))
        walk.run(1.0)
        # A map that shows a hole of half a metre under every place for a foot.
        centers = HeightMap.level((-1.0, -1.0, 2.0, 1.0), 0.02).centers
        deep = np.where(np.abs(centers[..., 0] % 0.4 - 0.2) < 0.15, -0.5, 0.0)
        controller.set_height_map(HeightMap(deep, 0.02, (-1.0, -1.0)))
        # Every way out is tried before.
        assert walk.run(120.0, lambda: controller.activity is Activity.STOPPED)
        said = controller.reason
        walk.run(2.0)
    finally:
        walk.close()
    assert not walk.record.has_fallen
    assert controller.activity is Activity.STOPPED
    assert controller.reason == said


def test_a_map_that_shows_holes_all_around_makes_no_robot_fall():
    # Footsteps left its feet near together; going back over three of them it tipped over.
    controller = controller_for(TITAN)
    walk = ClosedLoop(TITAN, controller, ENGINE, world_with())
    try:
        walk.run(0.5)
        controller.set_plan(Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0))
        walk.run(1.0)
        centers = HeightMap.level((-1.0, -1.0, 2.0, 1.0), 0.02).centers
        gaps = TITAN.neutral_feet[:, None, None, :2] - centers
        near = np.hypot(gaps[..., 0], gaps[..., 1]).min(axis=0) < 0.12
        controller.set_height_map(HeightMap(np.where(near, 0.0, -0.5), 0.02, (-1.0, -1.0)))
        walk.run(20.0)
    finally:
        walk.close()
    assert not walk.record.has_fallen
    assert max(walk.record.tilts) < math.radians(10.0)


def test_the_measured_margin_counts_the_tilt():
    joints = TITAN.initial_joint_angles.reshape(-1)
    level = Measurement(0.0, ORIGIN, 0.0, joints, np.zeros(12), LEVEL)
    half = math.radians(10.0) / 2.0
    tilted = replace(level, orientation=np.array([0.0, math.sin(half), 0.0, math.cos(half)]))
    standing = np.ones(4, dtype=bool)
    judge = StateEstimator(TITAN).judge
    margins = [judge(now).stability_margin(standing) for now in (level, tilted)]
    assert margins[0] > margins[1] + 0.02
    assert tilt_from_quaternion(tilted.orientation) == pytest.approx(2.0 * half)
    polygon = judge(level).support_polygon(standing)
    assert polygon == pytest.approx(TITAN.neutral_feet[[0, 2, 3, 1], :2], abs=1e-9)


def test_the_wave_walks_uneven_ground_in_its_own_order_of_legs():
    parameters = GaitParameters(gait='wave', ground='uneven')
    controller = Supervisor.from_parameters(parameters, TITAN)
    walk = ClosedLoop(TITAN, controller, 'kinematic')
    swung = []
    try:
        walk.run(0.5)
        controller.set_plan(Plan.through([[0.0, 0.0], [0.4, 0.0]], 0.0))

        def is_over():
            standing = controller.in_contact_at(walk.time)
            if not standing.all() and (not swung or swung[-1] != int(np.argmin(standing))):
                swung.append(int(np.argmin(standing)))
            return controller.activity is Activity.ARRIVED

        assert walk.run(60.0, is_over)
        assert walk.simulation.observe().pose.distance_to(Pose2D(0.4, 0.0, 0.0)) < 0.02
    finally:
        walk.close()
    order = [LEGS.index(swing.leg) for swing in load_gait('wave', TITAN).swings]
    assert len(swung) >= 8
    assert swung == (order * len(swung))[: len(swung)]


def test_a_gait_on_two_feet_is_refused():
    with pytest.raises(ParameterError, match="'gait' is 'trot'; it must be one with three feet"):
        check_suits_uneven_ground(load_gait('trot'))


@pytest.mark.parametrize('name', ['crawl', 'turn', 'crab', 'wave'])
def test_gaits_on_three_feet_are_taken(name):
    check_suits_uneven_ground(load_gait(name))


@pytest.mark.parametrize(
    ('rise', 'stands'), [(-0.2, True), (0.08, True), (0.12, True), (0.16, False)]
)
def test_what_is_higher_than_a_step_is_no_ground_to_stand_on(rise, stands):
    legs = Legs()
    met = legs.measure()
    met.feet[2, 2] += rise
    assert may_stand(TITAN, met, 2) == stands


@pytest.mark.parametrize('impossible', [(), ('swing_back',), ('swing_back', 'way_back')])
def test_a_foot_that_meets_a_wall_goes_back_or_stands_on_it_where_it_cannot(
    monkeypatch, impossible
):
    legs, stride = Legs(), stride_for(height_map=HeightMap.level((-1.0, -1.0, 1.0, 1.0), 0.02))
    start, apart = legs.measure().feet[2, :2], distances_from(legs.measure(), 2)
    monkeypatch.setattr(uneven_stride, 'may_stand', lambda *_: False)
    monkeypatch.setattr(uneven_stride, '_MOST_RAISES', 0)
    for name in impossible:
        monkeypatch.setattr(SwingPlanner, name, no_swing)
    meet_something(legs, stride)
    if len(impossible) < 2:
        assert stride.leg == 2
        # By another path, or as it came: joints at the end of their range get nowhere else.
        while stride.leg == 2:
            legs.run(stride, 0.02)
        if impossible:
            assert distances_from(legs.measure(), 2) == pytest.approx(apart, abs=0.002)
        else:
            assert legs.measure().feet[2, :2] == pytest.approx(start, abs=0.02)
    else:
        assert stride.leg != 2
        # It is known that it stands there: it is no slip when the next foot is lifted.
        assert stride._felt.slip(legs.measure(), -1) < 0.008


def distances_from(stance, leg):
    """Return the distances of a foot from the others, wherever the body is, shape (3,) [m]."""
    return np.linalg.norm(np.delete(stance.feet, leg, axis=0) - stance.feet[leg], axis=1)


def no_swing(*_):
    raise FootholdNotFound('lh', 0.0)
