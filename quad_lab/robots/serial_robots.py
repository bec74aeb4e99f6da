"""
Descriptions of quadrupeds whose legs fit no closed formulas.
"""

import numpy as np

BUILDS = {
    # Hips whose first axes are turned outward by 20 degrees and downward by 10.
    'skewed': ((0.93, 0.34, -0.16), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)),
    'pitch_roll_pitch': ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    # Knees whose axes are not parallel to the pitch axes.
    'turned_knee': ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.2, 0.96, 0.2)),
}
"""Axes of a left leg's joints, from the body outward, by the name of the build."""

_SIDES = {'FL': (1, 1), 'FR': (1, -1), 'RL': (-1, 1), 'RR': (-1, -1)}

_LINK = """  <link name="{name}">
    <inertial>
      <origin xyz="{x} {y} {z}"/><mass value="{mass}"/>
      <inertia ixx="{i}" ixy="0" ixz="0" iyy="{i}" iyz="0" izz="{i}"/>
    </inertial>
    <collision><origin xyz="{x} {y} {z}"/><geometry>{shape}</geometry></collision>
  </link>
"""

_JOINT = """  <joint name="{name}" type="{kind}">
    <parent link="{parent}"/><child link="{child}"/><origin xyz="{x} {y} {z}"/>
    <axis xyz="{axis}"/><limit lower="{low}" upper="{high}" effort="30" velocity="20"/>
  </joint>
"""


def serial_urdf(build: str) -> str:
    """Write the URDF of a robot of 13 kg; legs hang straight down at 0, right ones are mirrored."""
    own = np.array(BUILDS[build])
    own /= np.linalg.norm(own, axis=1, keepdims=True)
    box = '<box size="0.4 0.14 0.1"/>'
    text = [f'<robot name="{build}">\n', _link('body', (0.0, 0.0, 0.0), 7.0, 0.1, box)]
    for leg, (end, side) in _SIDES.items():
        # Axes are pseudovectors: a mirror across the middle turns their parts in its plane.
        turned = own * ([1.0, 1.0, 1.0] if side > 0 else [-1.0, 1.0, -1.0])
        turned = turned * ([1.0, 1.0, 1.0] if end > 0 else [1.0, -1.0, 1.0])
        turned[1:] *= np.sign(turned[1:, 1])[:, None] if build != 'pitch_roll_pitch' else 1.0
        ranges = ((-0.9, 0.9), (-0.5, 2.2), (-2.6, -0.3))
        if build == 'pitch_roll_pitch':
            ranges = ((-0.5, 2.2), (-0.9, 0.9), (-2.6, -0.3))
            turned[[0, 2]] *= np.sign(turned[[0, 2], 1])[:, None]
        parents = ('body', f'{leg}_hip', f'{leg}_thigh')
        children = (f'{leg}_hip', f'{leg}_thigh', f'{leg}_calf')
        places = ((0.2 * end, 0.06 * side, 0.0), (0.0, 0.08 * side, 0.0), (0.0, 0.0, -0.22))
        for parent, child, place, axis, (low, high) in zip(
            parents, children, places, turned, ranges
        ):
            written = ' '.join(map(repr, axis.tolist()))
            x, y, z = place
            text.append(
                _JOINT.format(
                    name=f'{child}_joint', kind='revolute', parent=parent, child=child,
                    x=x, y=y, z=z, axis=written, low=low, high=high,
                )
            )  # fmt: skip
        rod = '<cylinder radius="0.02" length="0.2"/>'
        text.append(
            _link(children[0], (0.0, 0.04 * side, 0.0), 0.5, 1e-3, '<sphere radius="0.04"/>')
        )
        text.append(_link(children[1], (0.0, 0.0, -0.11), 0.8, 4e-3, rod))
        text.append(_link(children[2], (0.0, 0.0, -0.11), 0.2, 1e-3, rod))
        text.append(_link(f'{leg}_foot', (0.0, 0.0, 0.0), 0.03, 1e-5, '<sphere radius="0.02"/>'))
        text.append(
            _JOINT.format(
                name=f'{leg}_foot_joint', kind='fixed', parent=children[2], child=f'{leg}_foot',
                x=0.0, y=0.0, z=-0.22, axis='1 0 0', low=0, high=0,
            )
        )  # fmt: skip
    return ''.join([*text, '</robot>\n'])


def _link(
    name: str, place: tuple[float, float, float], mass: float, inertia: float, shape: str
) -> str:
    x, y, z = place
    return _LINK.format(name=name, x=x, y=y, z=z, mass=mass, i=inertia, shape=shape)
