"""Small quadrupeds in MJCF, in the styles in which people write it."""

import pickle
from itertools import product
from pathlib import Path

import numpy as np

from quad_common.description.bounded_call import CallFailed
from quad_common.errors import QuadError

LEGS = ('FL', 'FR', 'RL', 'RR')
"""Names of the legs."""

THIGH, CALF, SIDE = 0.2, 0.19, 0.06
"""Lengths of thigh, calf and hip [m]."""

FOOT = 0.02
"""Radius of the feet [m]."""


def corner(leg, ahead=0.2, aside=0.06):
    """Return where a leg's hip is: x forward, y left [m]."""
    return (ahead if leg[0] == 'F' else -ahead), (aside if leg[1] == 'L' else -aside)


def called_here(function, *arguments, bounds):
    """
    Stand in for a call in a process of its own, which takes most of a second to begin.

    Tests of what is read are not about the process; those of `call_in_bounds` are.
    """
    assert bounds.seconds > 0
    try:
        return pickle.loads(pickle.dumps(function(*arguments)))
    except QuadError:
        raise
    except Exception as error:
        raise CallFailed(type(error).__name__, str(error)) from None


def write_box(path, low, high):
    """Write a box as an OBJ file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [f'v {x} {y} {z}' for x, y, z in product(*zip(low, high))]
    faces = ('1 2 4', '1 4 3', '5 7 8', '5 8 6', '1 5 6', '1 6 2', '3 4 8', '3 8 7', '1 3 7')
    lines += [f'f {face}' for face in (*faces, '1 7 5', '2 6 8', '2 8 4')]
    path.write_text('\n'.join(lines) + '\n')


def with_classes(folder: Path) -> Path:
    """Write a robot of classes and defaults: seen meshes, invisible capsules, servos."""
    write_box(folder / 'assets/trunk.obj', (-0.25, -0.08, -0.05), (0.3, 0.08, 0.06))
    write_box(folder / 'assets/links/thigh.obj', (-0.03, -0.02, -0.21), (0.02, 0.02, 0.03))
    legs, servos = '', ''
    for leg in LEGS:
        x, y = corner(leg)
        side = SIDE if y > 0.0 else -SIDE
        legs += f"""
      <body name="{leg}_hip" pos="{x} {y} 0">
        <inertial pos="-0.005 0.001 0" quat="0.5 0.5 0.5 0.5" mass="0.68"
          diaginertia="0.00073 0.00047 0.0004"/>
        <joint class="abduction" name="{leg}_hip_joint"/>
        <geom class="collision" type="cylinder" size="0.04 0.02" quat="1 1 0 0"/>
        <body name="{leg}_thigh" pos="0 {side} 0">
          <inertial pos="-0.003 0 -0.03" mass="1.0" diaginertia="0.0048 0.0046 0.0007"/>
          <joint class="hip" name="{leg}_thigh_joint"/>
          <geom class="visual" mesh="thigh"/>
          <geom class="collision" size="0.015" fromto="0 0 0 0 0 -{THIGH}"/>
          <body name="{leg}_calf" pos="0 0 -{THIGH}">
            <inertial pos="0.004 0.001 -0.12" mass="0.2"
              fullinertia="0.0015 0.0015 0.00004 0 0 0.00001"/>
            <joint class="knee" name="{leg}_calf_joint"/>
            <geom class="collision" size="0.01" fromto="0 0 0 0 0 -{CALF - 0.03}"/>
            <geom class="foot" name="{leg}"/>
            <site name="{leg}" pos="0 0 -{CALF}"/>
          </body>
        </body>
      </body>"""
        for kind in (('abduction', 'hip'), ('hip', 'thigh'), ('knee', 'calf')):
            servos += f"""
    <position class="{kind[0]}" name="{leg}_{kind[1]}" joint="{leg}_{kind[1]}_joint"/>"""
    robot = folder / 'robot.xml'
    robot.write_text(f"""<mujoco model="classy">
  <compiler angle="radian" meshdir="assets"/>
  <default>
    <default class="classy">
      <joint axis="0 1 0" damping="2" armature="0.01"/>
      <position kp="100" forcerange="-23.7 23.7"/>
      <default class="abduction">
        <joint axis="1 0 0" range="-0.86 0.86"/><position ctrlrange="-0.86 0.86"/>
      </default>
      <default class="hip"><joint range="-0.69 4.5"/></default>
      <default class="knee">
        <joint range="-2.82 -0.89"/><position forcerange="-35.5 35.5"/>
      </default>
      <default class="visual">
        <geom type="mesh" contype="0" conaffinity="0" group="2" material="dark"/>
      </default>
      <default class="collision"><geom group="3" type="capsule"/></default>
      <default class="foot"><geom group="3" size="{FOOT}" pos="0 0 -{CALF}"/></default>
    </default>
  </default>
  <asset>
    <material name="dark" rgba="0.1 0.1 0.1 1"/>
    <mesh file="trunk.obj"/>
    <mesh name="thigh" file="links/thigh.obj" scale="1 -1 1"/>
  </asset>
  <worldbody>
    <body name="trunk" pos="0 0 0.4" childclass="classy">
      <freejoint/>
      <inertial pos="0.02 0.002 -0.0005" mass="5.2" diaginertia="0.0717 0.063 0.0168"/>
      <geom class="visual" mesh="trunk"/>
      <geom class="collision" type="box" size="0.12 0.05 0.05"/>{legs}
    </body>
  </worldbody>
  <actuator>{servos}
  </actuator>
  <keyframe><key name="home" qpos="{'0 ' * 3}1 {'0 ' * 3}{'0 0.9 -1.8 ' * 4}"/></keyframe>
</mujoco>
""")
    scene = folder / 'scene.xml'
    scene.write_text("""<mujoco model="classy scene">
  <include file="robot.xml"/>
  <statistic center="0 0 0.1" extent="0.8"/>
  <worldbody>
    <light pos="0 0 1.5"/>
    <geom name="floor" size="0 0 0.05" type="plane"/>
    <geom type="box" size="0.1 0.1 0.1" pos="2 0 0.1"/>
    <body name="ball" pos="1 1 0.1"><freejoint/><geom size="0.1"/></body>
  </worldbody>
</mujoco>
""")
    return scene


def with_angles(folder: Path) -> Path:
    """Write a robot of degrees, Euler angles, masses by density, motors, anchors and references."""
    legs, motors = '', ''
    for number, leg in enumerate(LEGS):
        x, y = corner(leg, 0.22, 0.09)
        side = 1.0 if y > 0.0 else -1.0
        # Hind hips look backward, as on robots whose four legs are the same part.
        yaw = 0.0 if leg[0] == 'F' else 180.0
        inward = side if yaw == 0.0 else -side
        legs += f"""
      <body name="{leg}_hip" pos="{x - 0.01 * np.cos(np.radians(yaw))} {y} 0.01" euler="0 0 {yaw}">
        <joint name="{leg}_HAA" axis="1 0 0" pos="0.01 0 0" range="-49 49"/>
        <geom type="capsule" fromto="0.01 0 0 0.01 {0.07 * inward} 0" size="0.03"/>
        <frame pos="0.01 {0.08 * inward} 0" euler="0 0 0">
          <body name="{leg}_thigh" euler="0 30 0">
            <joint name="{leg}_HFE" axis="0 1 0" range="-100 100" ref="10"/>
            <geom type="capsule" fromto="0 0 0 0 0 -{THIGH}" size="0.025"/>
            <body name="{leg}_shank" pos="0.03 0 -{THIGH + 0.02}" euler="0 -60 0">
              <joint name="{leg}_KFE" axis="0 1 0" pos="-0.0323205080756888 0 -0.0159807621135332"
                range="-90 35" ref="-5"/>
              <geom type="capsule" fromto="0 0 0 0 0 -0.18" size="0.015"/>
              <geom name="{leg}_foot" pos="0 0 -0.2" size="{FOOT}" mass="0.05"/>
            </body>
          </body>
        </frame>
      </body>"""
        for name, gear in (('HAA', 9), ('HFE', 9), ('KFE', -12)):
            motors += f"""
    <motor name="m{number}{name}" joint="{leg}_{name}" gear="{gear}" ctrlrange="-3 3"/>"""
    path = folder / 'angular.xml'
    path.write_text(f"""<mujoco model="angular">
  <compiler angle="degree" eulerseq="xyz" inertiagrouprange="0 3"/>
  <default><geom density="900"/></default>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body pos="0 0 0.6" euler="0 0 40">
      <freejoint name="root"/>
      <geom type="box" size="0.25 0.08 0.05"/>
      <body name="head" pos="0.28 0 0.05" euler="0 20 0">
        <geom type="ellipsoid" size="0.05 0.03 0.03" density="200"/>
      </body>{legs}
    </body>
  </worldbody>
  <actuator>{motors}
  </actuator>
</mujoco>
""")
    return path


def with_double_joints(folder: Path) -> Path:
    """Write a robot on a planar base, with two joints in each hip's body and a nodding head."""
    legs = ''
    for leg in LEGS:
        x, y = corner(leg, 0.15, 0.1)
        legs += f"""
          <body name="{leg}_leg" pos="{x} {y} 0">
            <joint name="{leg}_roll" axis="1 0 0" range="-0.8 0.8" actuatorfrcrange="-12 12"/>
            <joint name="{leg}_pitch" axis="0 1 0" pos="0 0 -0.02" range="-1 2.5"
              actuatorfrcrange="-15 20"/>
            <geom type="ellipsoid" size="0.02 0.025 0.12" pos="0 0 -0.1" mass="0.6"/>
            <body name="{leg}_shin" pos="0 0 -0.2">
              <joint name="{leg}_knee" axis="0 1 0" range="-2.6 -0.3" actuatorfrcrange="-15 15"/>
              <geom type="cylinder" fromto="0 0 0 0 0 -0.18" size="0.012" mass="0.15"/>
              <geom name="{leg}_foot" type="sphere" pos="0 0 -0.19" size="{FOOT}" mass="0.05"/>
            </body>
          </body>"""
    path = folder / 'planar.xml'
    path.write_text(f"""<mujoco model="planar">
  <compiler angle="radian"/>
  <worldbody>
    <body name="rail" pos="0 0 1">
      <geom type="box" size="1 0.01 0.01"/>
      <body name="slider">
        <joint name="x" type="slide" axis="1 0 0"/>
        <geom size="0.01" mass="0.1"/>
        <body name="torso" pos="0 0 -0.5">
          <joint name="z" type="slide" axis="0 0 1"/>
          <joint name="y" type="hinge" axis="0 1 0"/>
          <geom type="box" size="0.18 0.07 0.04" mass="4"/>
          <body name="head" pos="0.2 0 0.05">
            <joint name="nod" axis="0 1 0" range="-0.5 0.5" pos="-0.01 0 0"/>
            <joint name="crane" type="slide" axis="1 0 0" range="0 0.05" ref="0.02"/>
            <geom size="0.04" mass="0.3"/>
          </body>{legs}
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
""")
    return path


STYLES = {'classes': with_classes, 'angles': with_angles, 'double_joints': with_double_joints}
"""Writers of robots, by style."""

FOOT_GEOMS = {
    'classes': LEGS,
    'angles': tuple(f'{leg}_foot' for leg in LEGS),
    'double_joints': tuple(f'{leg}_foot' for leg in LEGS),
}
"""Names of the feet's shapes, by style."""
