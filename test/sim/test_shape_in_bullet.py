"""The robot's shape in PyBullet is that of its data, and so are the distances of its parts."""

import numpy as np
import pytest

pytest.importorskip('pybullet')

import pybullet
from pybullet_utils.bullet_client import BulletClient

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.cycle.gait import load_gait
from quad_gait.following.follower_options import FollowerOptions
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import measuring_controller
from quad_sim.engines.bullet_simulator import BulletSimulator
from quad_sim.world.world import world_from_map

ROBOTS = {name: load_robot(name) for name in available_robots()}

FAR = 0.05
"""Parts farther apart than this are not compared [m]."""


@pytest.fixture
def client():
    made = BulletClient(pybullet.DIRECT)
    yield made
    made.disconnect()


def load(client, robot, folder, shape):
    """Load a robot with capsules or cylinders for links; return its body, joints and links."""
    path = folder / f'{shape}.urdf'
    text = urdf_from_robot(robot).replace('<cylinder', f'<{shape}')
    path.write_text(text, encoding='utf-8')
    flags = pybullet.URDF_USE_SELF_COLLISION | pybullet.URDF_USE_IMPLICIT_CYLINDER
    body = client.loadURDF(str(path), flags=flags)
    infos = [client.getJointInfo(body, index) for index in range(client.getNumJoints(body))]
    joints = {info[1].decode(): index for index, info in enumerate(infos)}
    links = {info[12].decode(): index for index, info in enumerate(infos)}
    return body, [joints[name] for name in robot.joint_names], {**links, 'base_link': -1}


def pose(client, body, joints, posture):
    for joint, angle in zip(joints, posture.reshape(-1)):
        client.resetJointState(body, joint, angle)


def distance(client, body, links, pair):
    points = client.getClosestPoints(body, body, 1.0, links[pair.first], links[pair.second])
    return min(point[8] for point in points)


@pytest.mark.parametrize('robot', ROBOTS.values(), ids=ROBOTS)
def test_clearances_agree_with_bullets_closest_points(robot, client, tmp_path):
    shape = robot.own_parts.shape
    postures = np.random.default_rng(7).uniform(robot.lower, robot.upper, (12, 4, 3))
    capsules, cylinders = (load(client, robot, tmp_path, s) for s in ('capsule', 'cylinder'))
    compared = 0
    for posture, clearances in zip(postures, shape.clearances(postures)):
        for body, joints, _ in (capsules, cylinders):
            pose(client, body, joints, posture)
        for pair, clearance in zip(shape.pairs, clearances):
            if not 0.0 < clearance < FAR:
                continue
            compared += 1
            assert distance(client, *capsules[::2], pair) == pytest.approx(clearance, abs=1e-3)
            # A capsule holds the cylinder that the URDF has.
            assert distance(client, *cylinders[::2], pair) > clearance - 1e-4
    assert compared > 50


def test_a_cylinder_in_the_simulator_is_no_thicker_than_the_data_say():
    robot = ROBOTS['cuhk']
    simulator = BulletSimulator(robot, world_from_map(None))
    try:
        simulator.reset(Pose2D(0.0, 0.0, 0.0))
        bullet, body = simulator._bullet, simulator._body
        links = {name: index for index, name in simulator._link_names.items()}
        ball = bullet.createMultiBody(0, bullet.createCollisionShape(pybullet.GEOM_SPHERE, 0.001))
        pitch_axis, knee, _ = robot.legs[0].chain(robot.initial_joint_angles[0])
        # To the outside of the thigh, which moves in the plane of x and z.
        middle = 0.5 * (pitch_axis + knee) + [0.0, 0.05, robot.standing_height]
        bullet.resetBasePositionAndOrientation(ball, middle, (0.0, 0.0, 0.0, 1.0))
        points = bullet.getClosestPoints(body, ball, 1.0, links['lf_thigh'], -1)
        expected = 0.05 - 0.001 - robot.links['thigh'].radius
        assert min(point[8] for point in points) == pytest.approx(expected, abs=1e-4)
    finally:
        simulator.close()


@pytest.mark.sweep(kept=1)
@pytest.mark.slow
@pytest.mark.parametrize(
    ('robot', 'gait', 'turning', 'corners'),
    [
        ('genibo', 'wave', 'crab', [(0.0, 0.0), (0.1, 0.0), (0.15, 0.25)]),
        ('genibo', 'wave', 'in_place', [(0.0, 0.0), (-0.1, -0.15)]),
        ('cuhk', 'trot', 'crab', [(0.0, 0.0), (-0.3, -0.7), (0.5, -1.2), (1.2, -0.6)]),
    ],
)
def test_walks_in_which_parts_touched_are_without_contacts(robot, gait, turning, corners):
    model = ROBOTS[robot]
    follower = FollowerOptions(turning=turning)
    controller = measuring_controller(model, load_gait(gait, model), follower=follower)
    walk = ClosedLoop(model, controller)
    walk.on_observation.append(lambda _: walk.simulation.observe())
    try:
        walk.run(0.1)
        controller.set_plan(Plan.through(corners, -1.2))
        walk.run(120.0, until=lambda: controller.activity is Activity.ARRIVED)
        assert controller.activity is Activity.ARRIVED
        assert sorted(map(str, walk.simulation.contacts_seen)) == []
    finally:
        walk.close()
