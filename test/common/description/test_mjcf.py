"""A robot read from MJCF is the one that MuJoCo simulates: places, masses, ranges and shapes."""

import re

import numpy as np
import pytest

pytest.importorskip('mujoco')
pytest.importorskip('yourdfpy')

import mujoco
import trimesh
from mjcf_robots import (
    FOOT,
    FOOT_GEOMS,
    STYLES,
    called_here,
    with_angles,
    with_classes,
    with_double_joints,
)

from quad_common.description import reading
from quad_common.description.mjcf import robot_from_mjcf
from quad_common.description.mjcf_shapes import pose_from
from quad_common.description.reading import read_description
from quad_common.description.tree import KinematicTree
from quad_common.errors import (
    DescriptionEntryInvalid,
    DescriptionUnusable,
    JointFiguresMissing,
    LegNotFeasible,
    MassesMissing,
    NotAQuadruped,
)
from quad_common.importing.options import ImportOptions
from quad_common.importing.own_urdf import own_urdf
from quad_common.importing.robot_import import import_robot

FAST = ImportOptions(speed=(20.0,))

TURNING = int(mujoco.mjtJoint.mjJNT_HINGE)


@pytest.fixture(autouse=True)
def _read_here(monkeypatch):
    monkeypatch.setattr(reading, 'call_in_bounds', called_here)


class Pair:
    """A robot as read, and MuJoCo's model of it with nothing fused."""

    def __init__(self, path):
        self.robot = robot_from_mjcf(path)
        self.tree = KinematicTree(self.robot, path)
        spec = mujoco.MjSpec.from_file(str(path))
        spec.compiler.fusestatic = False
        spec.compiler.discardvisual = False
        for key in list(spec.keys):
            key.delete() if hasattr(key, 'delete') else spec.delete(key)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        named = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, self.tree.root)
        # A body without a name is called base.
        self.root = named if named >= 0 else 1

    def bend(self, rng):
        """Bend all hinges at random, let nothing slide; return their angles by name."""
        angles = {}
        mujoco.mj_resetData(self.model, self.data)
        for name, joint in self.tree.joints.items():
            if joint.moves:
                index = self.model.joint(name).id
                turns = self.model.jnt_type[index] == TURNING
                angles[name] = rng.uniform(-1.0, 1.0) if turns else 0.0
                self.data.qpos[self.model.jnt_qposadr[index]] = angles[name]
        mujoco.mj_forward(self.model, self.data)
        return angles

    def in_root(self, points):
        """Take points of MuJoCo's world to the root's frame."""
        rotation = self.data.xmat[self.root].reshape(3, 3)
        return (np.asarray(points) - self.data.xpos[self.root]) @ rotation


def write(tmp_path, worldbody, rest=''):
    path = tmp_path / 'robot.xml'
    path.write_text(f'<mujoco><worldbody>{worldbody}</worldbody>{rest}</mujoco>')
    return path


def link_of(robot, name):
    return next(link for link in robot.links if link.name == name)


def joint_of(robot, name):
    return next(joint for joint in robot.joints if joint.name == name)


@pytest.mark.parametrize('style', STYLES)
def test_bodies_are_where_mujoco_has_them_at_any_angles(tmp_path, style):
    pair = Pair(STYLES[style](tmp_path))
    rng = np.random.default_rng(1)
    for _ in range(5):
        angles = pair.bend(rng)
        seen = 0
        for link in pair.robot.links:
            if link.inertial is None or '_after_' in link.name:
                continue
            body = pair.root if link.name == 'base' else pair.model.body(link.name).id
            center = (pair.tree.pose(link.name, angles) @ link.inertial.origin)[:3, 3]
            np.testing.assert_allclose(center, pair.in_root(pair.data.xipos[body]), atol=1e-12)
            seen += 1
        assert seen >= 9


@pytest.mark.parametrize('style', STYLES)
def test_mass_center_and_inertia_are_those_of_mujoco(tmp_path, style):
    pair = Pair(STYLES[style](tmp_path))
    mujoco.mj_resetData(pair.model, pair.data)
    pair.data.qpos[7 if style != 'double_joints' else 0 :] = 0.0
    mujoco.mj_forward(pair.model, pair.data)
    masses = [pair.tree.mass_of(name) for name in pair.tree.links]
    amount = sum(mass.amount for mass in masses)
    assert amount == pytest.approx(pair.model.body_subtreemass[pair.root], abs=1e-12)
    center = sum(mass.amount * mass.center for mass in masses) / amount
    wanted = pair.in_root(pair.data.subtree_com[pair.root])
    # A link between two joints has some of its body's mass, and does not slide with the body.
    np.testing.assert_allclose(center, wanted, atol=1e-12 if style != 'double_joints' else 2e-5)
    moments = sum(np.trace(mass.inertia) for mass in masses)
    bodies = [b for b in range(pair.model.nbody) if pair.model.body_rootid[b] == pair.root]
    if style != 'double_joints':
        assert moments == pytest.approx(pair.model.body_inertia[bodies].sum())


@pytest.mark.parametrize('style', STYLES)
def test_an_imported_leg_puts_its_foot_where_mujoco_does(tmp_path, style):
    path = STYLES[style](tmp_path)
    imported, pair = import_robot(path, FAST), Pair(path)
    assert imported.foot_radius == pytest.approx(FOOT)
    rng = np.random.default_rng(2)
    for _ in range(5):
        # Ranges may not begin at 0, so any angles will do.
        angles = pair.bend(rng)
        for joint in ('nod', 'crane'):
            if joint in angles:
                pair.data.qpos[pair.model.joint(joint).qposadr[0]] = 0.0
        feet = {
            name: pair.in_root(pair.data.geom_xpos[pair.model.geom(name).id])
            for name in FOOT_GEOMS[style]
        }
        for chain, ranged in zip(imported.chains, imported.legs):
            own = np.array([angles[joint.name] for joint in chain.joints])
            prefix = chain.joints[0].name[:2]
            wanted = next(foot for name, foot in feet.items() if name.startswith(prefix))
            found = ranged.leg.forward(own)
            at = imported.to_base[:3, :3] @ wanted + imported.to_base[:3, 3]
            np.testing.assert_allclose(found, at, atol=1e-8)


def test_a1_of_urdf_and_of_mujocos_own_conversion_are_one_robot(tmp_path):
    data = pytest.importorskip('pybullet_data')
    urdf = f'{data.getDataPath()}/a1/a1.urdf'
    spec = mujoco.MjSpec.from_file(urdf)
    spec.compiler.fusestatic = False
    spec.compiler.discardvisual = False
    spec.compile()
    converted = tmp_path / 'a1.xml'
    converted.write_text(spec.to_xml())
    options = ImportOptions(effort=(33.5,), speed=(21.0,))
    of_urdf, of_mjcf = (import_robot(path, options) for path in (urdf, converted))

    assert of_mjcf.leg_type == of_urdf.leg_type
    for one, other in zip(of_mjcf.chains, of_urdf.chains):
        assert [joint.name for joint in one.joints] == [joint.name for joint in other.joints]
    assert of_mjcf.masses.body == pytest.approx(of_urdf.masses.body, abs=1e-6)
    np.testing.assert_allclose(of_mjcf.masses.parts, of_urdf.masses.parts, atol=1e-6)
    np.testing.assert_allclose(of_mjcf.masses.centers, of_urdf.masses.centers, atol=1e-5)
    np.testing.assert_allclose(of_mjcf.initial, of_urdf.initial, atol=1e-4)
    assert of_mjcf.foot_radius == pytest.approx(of_urdf.foot_radius)
    rng = np.random.default_rng(3)
    for one, other in zip(of_mjcf.legs, of_urdf.legs):
        np.testing.assert_allclose(one.lower, other.lower, atol=1e-5)
        np.testing.assert_allclose(one.upper, other.upper, atol=1e-5)
        for angles in rng.uniform(one.lower, one.upper, (10, 3)):
            np.testing.assert_allclose(
                one.leg.forward(angles), other.leg.forward(angles), atol=1e-5
            )


def test_ranges_are_in_radians_whatever_the_file_counts_in(tmp_path):
    robot = robot_from_mjcf(with_angles(tmp_path))
    limit = joint_of(robot, 'FL_HAA').limit
    np.testing.assert_allclose([limit.lower, limit.upper], np.radians([-49, 49]))
    # Ranges are of qpos, whatever angle is called the reference.
    limit = joint_of(robot, 'FL_KFE').limit
    np.testing.assert_allclose([limit.lower, limit.upper], np.radians([-90, 35]))


def test_kinds_of_joints_are_those_of_urdf(tmp_path):
    robot = robot_from_mjcf(with_double_joints(tmp_path))
    kinds = {joint.name: joint.type for joint in robot.joints}
    assert kinds['FL_roll'] == 'revolute'
    assert kinds['crane'] == 'prismatic'
    # The base is free: what moves it in the world is left out, with what it stands on.
    assert not {'x', 'y', 'z'} & set(kinds)
    assert not {'rail', 'slider'} & {link.name for link in robot.links}
    path = write(
        tmp_path,
        """<body name="a"><freejoint/><geom size=".1"/><body name="b">
        <joint name="turns" axis="0 0 1"/><geom size=".1"/>
        <body name="c" pos="0 0 1"><geom size=".1"/></body></body></body>""",
    )
    kinds = {joint.name: joint.type for joint in robot_from_mjcf(path).joints}
    assert kinds == {'turns': 'continuous', 'c_fixed': 'fixed'}


def test_a_body_with_two_joints_becomes_two_links_that_move_alike(tmp_path):
    robot = robot_from_mjcf(with_double_joints(tmp_path))
    between = joint_of(robot, 'FL_roll').child
    assert joint_of(robot, 'FL_pitch').parent == between
    assert joint_of(robot, 'FL_pitch').child == 'FL_leg'
    light, heavy = link_of(robot, between).inertial.mass, link_of(robot, 'FL_leg').inertial.mass
    assert light + heavy == pytest.approx(0.6)
    assert light < 0.05 * heavy
    assert not link_of(robot, between).collisions


@pytest.mark.parametrize(
    ('style', 'wanted'),
    [
        # Of servos, by class.
        ('classes', (23.7, 23.7, 35.5)),
        # Of motors, by gear and control.
        ('angles', (27.0, 27.0, 36.0)),
        # Of joints; of two directions the weaker one.
        ('double_joints', (12.0, 15.0, 15.0)),
    ],
)
def test_largest_torques_are_those_of_actuators_and_joints(tmp_path, style, wanted):
    imported = import_robot(STYLES[style](tmp_path), FAST)
    np.testing.assert_allclose(imported.effort, np.tile(wanted, (4, 1)))


def test_a_servo_without_a_limit_has_no_torque_and_speeds_are_asked_for(tmp_path):
    path = with_classes(tmp_path)
    with pytest.raises(JointFiguresMissing, match=r'no largest speed of the joints .* --speed'):
        import_robot(path)
    robot = tmp_path / 'robot.xml'
    robot.write_text(robot.read_text().replace(' forcerange="-23.7 23.7"', ''))
    with pytest.raises(JointFiguresMissing, match=r'effort of the joints FL_hip_joint'):
        import_robot(path, FAST)


def test_capsules_are_cylinders_with_balls_and_what_mujoco_hides_is_not_seen(tmp_path):
    robot = robot_from_mjcf(with_classes(tmp_path))
    thigh = link_of(robot, 'FL_thigh')
    assert [shape.geometry.mesh is not None for shape in thigh.visuals] == [True]
    kinds = [
        'cylinder' if shape.geometry.cylinder else 'sphere' if shape.geometry.sphere else ''
        for shape in thigh.collisions
    ]
    assert kinds == ['cylinder', 'sphere', 'sphere']
    assert thigh.collisions[0].geometry.cylinder.length == pytest.approx(0.2)
    ends = sorted(shape.origin[2, 3] for shape in thigh.collisions[1:])
    np.testing.assert_allclose(ends, [-0.2, 0.0], atol=1e-12)
    np.testing.assert_allclose(thigh.visuals[0].material.color.rgba, [0.1, 0.1, 0.1, 1.0])


def test_what_touches_only_by_a_pair_is_touched(tmp_path):
    body = '<geom name="{}" size=".1" contype="0" conaffinity="0" pos="{} 0 0"/>'
    path = write(
        tmp_path,
        '<geom name="floor" type="plane" size="1 1 1"/><body name="a"><freejoint/>'
        + body.format('paired', 0)
        + body.format('seen', 1)
        + '<body name="b"><joint/><geom size=".1"/></body></body>',
        '<contact><pair geom1="floor" geom2="paired"/></contact>',
    )
    base = link_of(robot_from_mjcf(path), 'a')
    assert [shape.origin[0, 3] for shape in base.collisions] == [0.0]
    assert [shape.origin[0, 3] for shape in base.visuals] == [0.0, 1.0]


@pytest.mark.parametrize(
    ('half', 'kinds'),
    [
        ((0.1, 0.1, 0.11), {'sphere'}),
        ((0.3, 0.1, 0.1), {'cylinder', 'sphere'}),
        ((0.1, 0.3, 0.1), {'cylinder', 'sphere'}),
        ((0.3, 0.3, 0.1), {'box'}),
    ],
)
def test_an_ellipsoid_becomes_the_nearest_of_the_other_shapes(tmp_path, half, kinds):
    path = write(
        tmp_path,
        f"""<body name="a"><freejoint/><geom type="ellipsoid" size="{half[0]} {half[1]} {half[2]}"/>
        <body name="b"><joint/><geom size=".1"/></body></body>""",
    )
    shapes = link_of(robot_from_mjcf(path), 'a').collisions
    found = {
        kind for shape in shapes for kind in ('box', 'cylinder', 'sphere', 'mesh')
        if getattr(shape.geometry, kind) is not None
    }  # fmt: skip
    assert found == kinds
    if 'cylinder' in kinds:
        reach = np.abs([shape.origin[:3, 3] for shape in shapes[1:]]).max(axis=0)
        radius = shapes[1].geometry.sphere.radius
        np.testing.assert_allclose(reach + radius, half, atol=1e-9)


MESHES = {
    'plain': '',
    'scaled and mirrored': 'scale="1 2 -0.5"',
    'with a reference': 'refpos="0.1 0.2 0.3"',
    'turned, scaled evenly': 'refpos="0.1 0 0" refquat="0.7 0.1 0.2 0.3" scale="2 2 2"',
    'with a place of its own, scaled': 'refpos="0.1 0.2 0.3" scale="1 2 3"',
}


@pytest.mark.parametrize('asset', MESHES.values(), ids=MESHES)
@pytest.mark.parametrize('suffix', ['.obj', '.stl'])
def test_the_corners_of_meshes_are_where_mujoco_has_them(tmp_path, asset, suffix):
    folder = tmp_path / 'meshes'
    folder.mkdir()
    shape = trimesh.util.concatenate(
        [
            trimesh.creation.box((0.1, 0.2, 0.3)).apply_translation((0.5, 0.1, 0.05)),
            trimesh.creation.cone(0.05, 0.3).apply_translation((0.2, 0.0, 0.0)),
        ]
    )
    shape.export(folder / f'part{suffix}')
    path = tmp_path / 'robot.xml'
    path.write_text(f"""<mujoco><compiler meshdir="meshes"/>
      <asset><mesh name="part" file="part{suffix}" {asset}/></asset>
      <worldbody><body name="a" pos="1 2 3" euler="10 20 30"><freejoint/>
        <geom name="shape" type="mesh" mesh="part" pos="0.3 0 0" euler="0 40 10"/>
        <body name="b"><joint axis="1 0 0"/><geom size=".1"/></body>
      </body></worldbody></mujoco>""")
    pair = Pair(path)
    (collision,) = link_of(pair.robot, 'a').collisions
    mesh = collision.geometry.mesh
    assert mesh.filename == str(folder.resolve() / f'part{suffix}')
    corners = trimesh.load(mesh.filename, process=False).vertices
    corners = corners * (1.0 if mesh.scale is None else mesh.scale)
    found = corners @ collision.origin[:3, :3].T + collision.origin[:3, 3]

    model = pair.model
    geom = model.geom('shape').id
    placed = pose_from(model.geom_pos[geom], model.geom_quat[geom])
    wanted = model.mesh_vert @ placed[:3, :3].T + placed[:3, 3]
    distances = np.linalg.norm(found[:, None] - wanted[None], axis=-1)
    assert distances.min(axis=1).max() < 1e-6
    assert distances.min(axis=0).max() < 1e-6


def test_a_mesh_that_no_urdf_can_name_becomes_its_box(tmp_path):
    path = write(
        tmp_path,
        """<body name="a"><freejoint/><geom type="mesh" mesh="wedge" pos="0 0 1"/>
        <body name="b"><joint/><geom size=".1"/></body></body>""",
        '<asset><mesh name="wedge" vertex="0 0 0 1 0 0 0 2 0 0 0 3"/></asset>',
    )
    pair = Pair(path)
    (collision,) = link_of(pair.robot, 'a').collisions
    half = np.asarray(collision.geometry.box.size) / 2.0
    back = np.linalg.inv(collision.origin)
    corners = np.array([[0, 0, 1], [1, 0, 1], [0, 2, 1], [0, 0, 4]]) @ back[:3, :3].T + back[:3, 3]
    np.testing.assert_allclose(np.abs(corners).max(axis=0), half, atol=1e-6)


def test_a_scene_is_its_robot_alone_by_the_name_of_the_robot(tmp_path):
    scene = with_classes(tmp_path)
    imported = import_robot(scene, FAST)
    assert imported.name == 'classy'
    assert imported.tree.root == 'trunk'
    assert len(imported.tree.links) == 13
    assert read_description(scene).name == 'classy'


def test_the_own_urdf_of_a_robot_is_read_by_mujoco_again(tmp_path):
    imported = import_robot(with_classes(tmp_path), FAST)
    model = mujoco.MjModel.from_xml_string(own_urdf(imported, tmp_path / 'converted'))
    assert model.njnt == 12


FOUR_LEGS = ''.join(
    f"""<body name="leg{k}" pos="{x} {y} 0"><joint axis="1 0 0"/><geom size=".02"/>
    <body pos="0 0 -.1"><joint axis="0 1 0"/><geom size=".02"/>
    <body pos="0 0 -.2"><joint name="knee{k}" {{knee}}/><geom size=".02" pos="0 0 -.2"/></body>
    </body></body>"""
    for k, (x, y) in enumerate([(0.2, 0.1), (0.2, -0.1), (-0.2, 0.1), (-0.2, -0.1)])
)
"""Four legs, with names for hips and knees only."""


def test_bodies_and_joints_without_names_get_some(tmp_path):
    legs = re.sub(r' name="\w+"', '', FOUR_LEGS.format(knee='axis="0 1 0"'))
    path = write(tmp_path, f'<body><freejoint/><geom type="box" size=".2 .1 .05"/>{legs}</body>')
    robot = import_robot(path, ImportOptions(effort=(10.0,), speed=(10.0,)))
    names = [joint.name for chain in robot.chains for joint in chain.joints]
    assert len(set(names)) == 12
    assert all(names)


def test_a_ball_joint_is_named(tmp_path):
    legs = FOUR_LEGS.format(knee='type="ball"')
    path = write(tmp_path, f'<body><freejoint/><geom size=".1"/>{legs}</body>')
    with pytest.raises(DescriptionEntryInvalid, match="joint 'knee0' is a ball joint"):
        robot_from_mjcf(path)


def test_of_two_robots_none_is_chosen(tmp_path):
    legs = FOUR_LEGS.format(knee='axis="0 1 0"').replace('name="', 'name="x')
    one = f'<body name="rex"><freejoint/><geom size=".1"/>{legs}</body>'
    path = write(tmp_path, one + one.replace('"x', '"y').replace('rex', 'max'))
    with pytest.raises(DescriptionUnusable, match=r"2 bodies .* \('rex', 'max'\)"):
        robot_from_mjcf(path)


def test_legs_that_stand_in_the_world_one_by_one_hang_at_what_is_fixed_to_it(tmp_path):
    trunk = '<geom type="plane" size="1 1 1"/><geom name="trunk" size=".2 .1 .05" type="box"/>'
    pillar = '<body name="pillar"><geom size=".1"/></body>'
    path = write(tmp_path, trunk + pillar + FOUR_LEGS.format(knee='axis="0 1 0"'))
    robot = robot_from_mjcf(path)
    tree = KinematicTree(robot, path)
    # MuJoCo's conversions of URDF lose the root's mass; the ground and other things are not its.
    assert tree.mass_of(tree.root).amount == 0.0
    assert [shape.geometry.box.size.tolist() for shape in tree.links[tree.root].collisions] == [
        [0.4, 0.2, 0.1]
    ]
    assert 'pillar' not in tree.links
    with pytest.raises(MassesMissing, match=f'no mass of {tree.root}; give .* --mass'):
        import_robot(path, FAST)


def test_closed_loops_are_refused_but_not_what_holds_the_robot(tmp_path):
    legs = FOUR_LEGS.format(knee='axis="0 1 0"')
    body = f'<body name="base" pos="0 0 1"><freejoint/><geom size=".1"/>{legs}</body>'
    held = '<equality><weld body1="base"/></equality>'
    robot_from_mjcf(write(tmp_path, body, held))
    closed = '<equality><connect body1="leg0" body2="leg1" anchor="0 0 0"/></equality>'
    with pytest.raises(DescriptionUnusable, match="'leg0' and 'leg1' are tied together"):
        robot_from_mjcf(write(tmp_path, body, closed))


@pytest.mark.parametrize(
    ('constraint', 'follows'),
    [
        ('joint1="knee" joint2="hip" polycoef="0 -2 0 0 0"', 'hip'),
        ('joint1="knee" joint2="hip" active="false"', None),
        ('joint1="knee"', None),
        ('joint1="hip" joint2="knee"', None),
    ],
)
def test_a_joint_that_follows_another_by_a_constraint_is_told(tmp_path, constraint, follows):
    body = (
        '<body><freejoint/><geom size=".1"/><body><joint name="hip"/><geom size=".1"/><body>'
        '<joint name="knee"/><geom size=".1"/></body></body></body>'
    )
    rest = f'<equality><joint {constraint}/></equality>'
    mimic = joint_of(robot_from_mjcf(write(tmp_path, body, rest)), 'knee').mimic
    assert (mimic and mimic.joint) == follows


def test_what_has_no_joints_is_no_quadruped(tmp_path):
    path = write(tmp_path, '<body><freejoint/><geom size=".1"/></body><geom size=".1"/>')
    with pytest.raises(NotAQuadruped, match='no joint that moves'):
        robot_from_mjcf(path)


def test_an_arm_is_no_quadruped_and_its_chains_are_named(tmp_path):
    path = write(
        tmp_path,
        '<body><geom size=".1"/><body><joint/><geom size=".1"/></body></body>',
    )
    with pytest.raises(NotAQuadruped, match='one chain of one joint'):
        import_robot(path)


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('<mujoco><worldbody><body><joint/></body></worldbody></mujoco>', 'mass and inertia'),
        ('<mujoco><worldbody><box/></worldbody></mujoco>', 'unrecognized'),
        ('<mujoco><asset><mesh file="none.obj"/></asset></mujoco>', 'none.obj'),
        ('<mujoco><include file="none.xml"/></mujoco>', 'none.xml'),
    ],
)
def test_what_mujoco_refuses_is_refused_with_its_reason(tmp_path, text, reason):
    path = tmp_path / 'robot.xml'
    path.write_text(text)
    with pytest.raises(DescriptionUnusable, match=f'MuJoCo cannot read it: .*{reason}') as caught:
        read_description(path)
    assert '\n' not in str(caught.value)


def test_warnings_of_mujoco_leave_no_file_behind(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = write(tmp_path, '<body><freejoint/><geom size="nan"/></body>')
    before = mujoco.get_mju_user_warning()
    with pytest.raises(DescriptionUnusable, match='nan size in geom'):
        robot_from_mjcf(path)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    assert mujoco.get_mju_user_warning() is before


def test_a_leg_that_bends_about_wrong_axes_is_named(tmp_path):
    legs = FOUR_LEGS.format(knee='axis="0 0 1"')
    path = write(tmp_path, f'<body><freejoint/><geom size=".1"/>{legs}</body>')
    with pytest.raises(LegNotFeasible, match='moves its foot in one plane only'):
        import_robot(path, ImportOptions(effort=(10.0,), speed=(10.0,)))
