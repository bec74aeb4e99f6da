"""Any URDF becomes a robot that can be drawn, with its links where its joints put them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from quad_common.errors import InvalidMessage
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot
from quad_common.rotations import matrix_from_quaternion
from quad_view.scene.robot_model import RobotModel, model_from_urdf, product, rotated

ROBOTS = ('titan_viii', 'pukyong', 'cuhk', 'genibo')

TWO_LINKS = """
<robot name="two">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="hull"><visual><geometry><box size="1 2 3"/></geometry><material name="red"/></visual>
  </link>
  <link name="arm"><visual><origin xyz="0.5 0 0"/>
    <geometry><mesh filename="/nowhere/arm.stl" scale="2 2 2"/></geometry></visual></link>
  <link name="slide"/>
  <joint name="elbow" type="revolute">
    <parent link="hull"/><child link="arm"/><origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>
    <axis xyz="0 0 2"/>
  </joint>
  <joint name="slider" type="prismatic">
    <parent link="arm"/><child link="slide"/><axis xyz="0 1 0"/><mimic joint="elbow" multiplier="2"
    offset="0.5"/>
  </joint>
</robot>
"""


def placed(model: RobotModel, positions: dict[str, float]) -> list[np.ndarray]:
    """Return the position of every link in the root's frame."""
    where, turns = model.poses(positions)
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for index, link in enumerate(model.links):
        if link.parent < 0:
            found.append((np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])))
            continue
        position, turn = found[link.parent]
        found.append((position + rotated(turn, where[index]), product(turn, turns[index])))
    return [position for position, _ in found]


@pytest.mark.parametrize('name', ROBOTS)
def test_feet_are_where_the_kinematics_of_the_legs_put_them(name):
    robot = load_robot(name)
    model = model_from_urdf(urdf_from_robot(robot))
    rng = np.random.default_rng(1)
    for _ in range(5):
        angles = rng.uniform(robot.lower, robot.upper)
        positions = dict(zip(robot.joint_names, angles.ravel(), strict=True))
        links = placed(model, positions)
        feet = [leg.forward(q) for leg, q in zip(robot.legs, angles, strict=True)]
        for foot in feet:
            assert min(np.linalg.norm(link - foot) for link in links) < 1e-6


def test_every_shape_of_a_robot_is_read():
    model = model_from_urdf(urdf_from_robot(load_robot('titan_viii')))
    kinds = [shape.kind for link in model.links for shape in link.shapes]
    assert kinds.count('box') == 1
    assert kinds.count('sphere') >= 4
    assert max(link.depth for link in model.links) == 3


def test_joints_turn_slide_and_follow_one_another():
    model = model_from_urdf(TWO_LINKS)
    assert model.joint_names == ('', 'elbow', 'elbow')
    where, turns = model.poses({'elbow': math.pi / 2, 'of somebody else': 7.0})
    np.testing.assert_allclose(where[1], (1.0, 0.0, 0.0))
    np.testing.assert_allclose(
        matrix_from_quaternion(turns[1]), np.diag([-1.0, -1.0, 1.0]), atol=1e-12
    )
    np.testing.assert_allclose(where[2], (0.0, math.pi + 0.5, 0.0))
    np.testing.assert_allclose(turns[2], (0.0, 0.0, 0.0, 1.0))


def test_colors_and_meshes_are_read():
    hull, arm, slide = model_from_urdf(TWO_LINKS).links
    assert hull.shapes[0].color == (255, 0, 0)
    assert arm.shapes[0].kind == 'mesh'
    assert (arm.shapes[0].mesh, arm.shapes[0].size) == ('/nowhere/arm.stl', (2.0, 2.0, 2.0))
    assert slide.shapes == ()


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('', 'no XML'),
        ('<robot/>', '0 links'),
        ('<sdf><link name="a"/></sdf>', 'below <robot>'),
        ('<robot><link name="a"/><link name="b"/></robot>', '2 of its links have no parent'),
        (TWO_LINKS.replace('link="slide"', 'link="hull"'), 'form a circle'),
        (TWO_LINKS.replace('link="arm"', 'link="leg"'), 'joins no two links'),
        (TWO_LINKS.replace('xyz="0 0 2"', 'xyz="0 0 0"'), 'no direction'),
        (TWO_LINKS.replace('size="1 2 3"', 'size="1 2 nan"'), 'is no number'),
        (TWO_LINKS.replace('size="1 2 3"', 'size="1 2"'), 'not three numbers'),
    ],
)
def test_what_is_no_robot_is_refused_with_the_reason(text, reason):
    with pytest.raises(InvalidMessage, match=reason):
        model_from_urdf(text)
