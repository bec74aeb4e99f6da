"""
Descriptions of a robot with one fault each, which an import must name.
"""

from __future__ import annotations

import re
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from quad_common.errors import QuadError
from quad_common.importing.options import ImportOptions
from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot

Change = Callable[[str], str]

_LONGEST = 5.0
"""Time of the processor after which an import counts as hanging [s]."""


@dataclass(frozen=True)
class BrokenImport:
    """One fault, and what the import said of it."""

    fault: str
    """Fault that was put into the description."""
    said: str
    """Sentence of the error; empty if there was none."""
    is_named: bool
    """Whether the fault was refused in one sentence, in time."""


def good_description() -> str:
    """Return the URDF of a robot that ships: nothing of others is needed."""
    return urdf_from_robot(load_robot('genibo'))


_MESHES = {
    'flat.obj': 'v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n',
    'line.obj': 'v 0 0 0\nv 0.1 0 0\nv 0.2 0 0\nf 1 2 3\n',
    'text.stl': 'no mesh',
    'empty.obj': '# nothing\n',
    'archive.zip': 'PK',
}
"""Meshes that faults name, by their files beside the description."""


def _replaced(pattern: str, by: str, count: int = 1) -> Change:
    """Replace what matches a pattern, at most so many times; all of it if the count is 0."""

    def change(text: str) -> str:
        changed, made = re.subn(pattern, lambda match: match.expand(by), text, count=count)
        if not made:
            raise AssertionError(f'nothing to change: {pattern}')
        return changed

    return change


def _with_mesh(use: str, attributes: str) -> Change:
    """Put a mesh in the place of the first shape of a use."""
    return _replaced(rf'(?s)(<{use}>.*?<geometry>).*?(</geometry>)', rf'\1<mesh {attributes}/>\2')


_OF_FILES: dict[str, Change] = {
    'an empty file': lambda text: '',
    'no XML': lambda text: 'robot: genibo',
    'cut in the middle': lambda text: text[: len(text) // 2],
    'another format': lambda text: '<sdf version="1.7"/>',
    'no robot': lambda text: '<robot name="none"/>',
    'a document type': lambda text: '<!DOCTYPE robot [<!ENTITY a "b">]>' + text,
    'entities of entities': lambda text: (
        '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;">]>' + text
    ),
    'bytes that are no text': lambda text: text[:200] + '\udcff' + text[200:],
    'a null byte': lambda text: text[:200] + '\0' + text[200:],
    'nested too deeply': lambda text: '<robot>' + '<link>' * 5000,
}
"""Faults of the file as a whole."""

_OF_THE_TREE: dict[str, Change] = {
    'a link twice': _replaced(r'(<link name="lf_thigh">)', r'\1</link>\1'),
    'a joint twice': _replaced(r'(?s)(<joint name="lf_hip_pitch_joint".*?</joint>)', r'\1\1'),
    'a parent that is not there': _replaced('parent link="lf_hip"', 'parent link="moon"'),
    'a child that is not there': _replaced('child link="lf_thigh"', 'child link="moon"'),
    'a loop': _replaced('parent link="base_link"', 'parent link="lf_thigh"'),
    'two trees': _replaced(r'(?s)<joint name="lf_hip_roll_joint".*?</joint>', ''),
    'a link at two joints': _replaced('child link="rf_hip"', 'child link="lf_hip"'),
    'a joint without parent': _replaced(r'<parent link="lf_hip" ?/>', ''),
    'a joint without child': _replaced(r'<child link="lf_thigh" ?/>', ''),
    'a joint without name': _replaced('<joint name="lf_hip_pitch_joint"', '<joint'),
    'a joint without kind': _replaced(' type="revolute"', ''),
    'an unknown kind of joint': _replaced('type="revolute"', 'type="elastic"'),
    'a sliding joint': _replaced('type="revolute"', 'type="prismatic"'),
    'a joint that follows another': _replaced(
        r'(joint name="lf_knee_pitch_joint" type="revolute">)',
        r'\1<mimic joint="lf_hip_pitch_joint" multiplier="-2"/>',
    ),
    'a joint that follows none': _replaced(
        r'(joint name="lf_knee_pitch_joint" type="revolute">)', r'\1<mimic/>'
    ),
    'a name of two lines': _replaced('lf_knee_pitch_joint', 'lf_knee&#10;joint'),
    'a name of 300 characters': _replaced('lf_knee_pitch_joint', 300 * 'k'),
    'a fixed joint in a leg': _replaced('type="revolute"', 'type="fixed"'),
}
"""Faults of links and joints, and of what hangs where."""

_OF_PLACES: dict[str, Change] = {
    'an axis of zero': _replaced(r'axis xyz="[^"]*"', 'axis xyz="0 0 0"'),
    'an axis of two numbers': _replaced(r'axis xyz="[^"]*"', 'axis xyz="1 0"'),
    'an axis that is no number': _replaced(r'axis xyz="[^"]*"', 'axis xyz="1 0 nan"'),
    'an axis of words': _replaced(r'axis xyz="[^"]*"', 'axis xyz="up"'),
    'three axes that are parallel': _replaced(
        r'(?s)(joint name="lf_hip_roll_joint".*?axis xyz=")[^"]*', r'\g<1>0 1 0'
    ),
    'an axis across the others': _replaced(r'axis xyz="0 1 0"', 'axis xyz="1 0 0"'),
    'an axis without numbers': _replaced(r'axis xyz="0 1 0"', 'axis'),
    'an origin of one number': _replaced(r'origin xyz="[^"]*"', 'origin xyz="0.04"'),
    'an origin of two numbers': _replaced(r'origin xyz="[^"]*"', 'origin xyz="0.04 0"', 4),
    'a place of a joint of one number': _replaced(
        r'(?s)(joint name="lf_hip_roll_joint".*?origin xyz=")[^"]*', r'\g<1>0.04'
    ),
    'an origin of one angle': _replaced(r'rpy="[^"]*"', 'rpy="0.1"'),
    'an origin of five angles': _replaced(r'rpy="[^"]*"', 'rpy="0 0 0 0 0"'),
    'an origin of words': _replaced(r'origin xyz="[^"]*"', 'origin xyz="here"', 4),
    'an origin far away': _replaced(
        r'(?s)(joint name="lf_hip_roll_joint".*?origin xyz=")[^"]*', r'\g<1>1e30 0 0'
    ),
    'an origin that is infinite': _replaced(
        r'(?s)(joint name="lf_hip_roll_joint".*?origin xyz=")[^"]*', r'\g<1>inf 0 0'
    ),
}
"""Faults of axes and origins."""

_OF_MASSES: dict[str, Change] = {
    'a mass of words': _replaced(r'mass value="[^"]*"', 'mass value="heavy"'),
    'a negative mass': _replaced(r'mass value="[^"]*"', 'mass value="-1"'),
    'a mass that is no number': _replaced(r'mass value="[^"]*"', 'mass value="nan"'),
    'a mass of a tenth of a gram': _replaced(r'mass value="[^"]*"', 'mass value="0.0001"'),
    'an infinite mass': _replaced(r'mass value="[^"]*"', 'mass value="inf"'),
    'a mass of planets': _replaced(r'mass value="[^"]*"', 'mass value="1e24"'),
    'an inertia that is no number': _replaced(r'ixx="[^"]*"', 'ixx="nan"'),
    'an inertia of words': _replaced(r'ixx="[^"]*"', 'ixx="some"'),
    'an infinite inertia': _replaced(r'izz="[^"]*"', 'izz="inf"'),
    'no masses': _replaced(r'(?s)<inertial>.*?</inertial>', '', 0),
    'a leg without mass': _replaced(r'(?s)(<link name="lf_thigh">.*?mass value=")[^"]*', r'\g<1>0'),
}
"""Faults of masses and inertias."""

_OF_LIMITS: dict[str, Change] = {
    'no efforts': _replaced(r' effort="[^"]*"', '', 0),
    'no speeds': _replaced(r' velocity="[^"]*"', '', 0),
    'an effort of zero': _replaced(r' effort="[^"]*"', ' effort="0"', 0),
    'a negative speed': _replaced(r' velocity="[^"]*"', ' velocity="-8"'),
    'an effort of words': _replaced(r' effort="[^"]*"', ' effort="strong"'),
    'limits exchanged': _replaced(r' lower="([^"]*)" upper="([^"]*)"', r' lower="\2" upper="\1"'),
    'limits of words': _replaced(r' lower="[^"]*"', ' lower="low"'),
    'limits that are no number': _replaced(r' lower="[^"]*"', ' lower="nan"'),
    'a joint that is locked': _replaced(
        r' lower="[^"]*" upper="[^"]*"', ' lower="0.3" upper="0.3"'
    ),
    'a range in which nothing stands': _replaced(
        r'(?s)(joint name="lf_knee_pitch_joint".*?) lower="[^"]*" upper="[^"]*"',
        r'\1 lower="-0.11" upper="-0.10"',
    ),
}
"""Faults of what joints can do."""

_OF_SHAPES: dict[str, Change] = {
    'a mesh that is not there': _with_mesh('collision', 'filename="missing.stl"'),
    'a mesh that is none': _with_mesh('collision', 'filename="text.stl"'),
    'a mesh on a line': _with_mesh('collision', 'filename="line.obj"'),
    'a mesh that is shrunk to a point': _with_mesh('collision', 'filename="flat.obj" scale="0"'),
    'a mesh without corners': _with_mesh('collision', 'filename="empty.obj"'),
    'a mesh in an archive': _with_mesh('collision', 'filename="archive.zip"'),
    'a scale of two numbers': _with_mesh('collision', 'filename="line.obj" scale="1 1"'),
    'a scale of four numbers': _with_mesh('collision', 'filename="line.obj" scale="1 1 1 1"'),
    'a seen scale that is no number': _with_mesh('visual', 'filename="line.obj" scale="nan 1 1"'),
    'a seen ball of astronomers': _replaced(r'sphere radius="[^"]*"', 'sphere radius="1e30"'),
    'balls without any number': _replaced(r'sphere radius="[^"]*"', 'sphere radius="nan"', 0),
    'an infinite ball': _replaced(r'sphere radius="[^"]*"', 'sphere radius="inf"', 0),
    'a cylinder without a number': _replaced(r'cylinder radius="[^"]*"', 'cylinder radius="nan"'),
    'an infinite cylinder': _replaced(r' length="[^"]*"', ' length="inf"', 0),
    'a negative cylinder': _replaced(r' length="[^"]*"', ' length="-0.1"', 0),
    'a box of two numbers': _replaced(r'box size="[^"]*"', 'box size="0.2 0.1"', 2),
    'a box of four numbers': _replaced(r'box size="[^"]*"', 'box size="0.2 0.1 0.1 0.1"', 2),
    'a negative box': _replaced(r'box size="[^"]*"', 'box size="0.2 -0.1 0.1"', 2),
    'a box of words': _replaced(r'box size="[^"]*"', 'box size="large"', 2),
    'a ball without radius': _replaced(r'<sphere radius="[^"]*" ?/>', '<sphere/>', 0),
    'a shape of no kind': _replaced(
        r'(?s)(<collision>.*?<geometry>).*?(</geometry>)', r'\1<cone radius="1"/>\2', 0
    ),
}
"""Faults of what links look like."""

_OF_LEGS: dict[str, Change] = {
    'three legs': _replaced(
        r'(?s)<joint name="lf_hip_roll_joint".*?type="revolute"',
        '<joint name="lf_hip_roll_joint" type="fixed"',
    ),
    'legs at one place': _replaced(
        r'(?s)(joint name="(?:rf|lf|lh|rh)_hip_roll_joint".*?origin xyz=")[^"]*',
        r'\g<1>0 0 0',
        4,
    ),
    'a leg on the wrong side': _replaced(
        r'(?s)(joint name="rf_hip_roll_joint".*?origin xyz=")[^"]*', r'\g<1>0.075 0.06 0'
    ),
    'a thigh without length': _replaced(
        r'(?s)(joint name="lf_knee_pitch_joint".*?origin xyz=")[^"]*', r'\g<1>0 0 0'
    ),
}
"""Faults of the legs as a whole."""

BROKEN_DESCRIPTIONS: dict[str, Change] = {
    **_OF_FILES,
    **_OF_THE_TREE,
    **_OF_PLACES,
    **_OF_MASSES,
    **_OF_LIMITS,
    **_OF_SHAPES,
    **_OF_LEGS,
}
"""The faults by their names, each as what it makes of a good description."""


def import_broken(fault: str, change: Change) -> BrokenImport:
    """
    Import a description with a fault.

    Parameters
    ----------
    fault : str
        Name of the fault.
    change : callable
        Puts it into a good description.
    """
    text = change(good_description())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'broken.urdf'
        for name, mesh in _MESHES.items():
            (path.parent / name).write_text(mesh)
        path.write_bytes(text.encode('utf-8', 'surrogateescape'))
        began = time.process_time()
        try:
            robot = import_robot(path, ImportOptions())
            data_file, _ = write_robot(robot, Path(folder) / 'robot.yaml')
            load_robot(data_file)
        except QuadError as error:
            said = str(error)
            in_time = time.process_time() - began < _LONGEST
            return BrokenImport(fault, said, '\n' not in said and len(said) < 700 and in_time)
        except Exception as error:
            return BrokenImport(fault, f'{type(error).__name__}: {error}', False)
    return BrokenImport(fault, '', False)
