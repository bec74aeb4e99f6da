"""
How thick an imported robot's legs count: as far as they reach toward the body.
"""

import math
from xml.etree import ElementTree

import numpy as np
import pytest

from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot

pytest.importorskip('yourdfpy')

from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot

LENGTH = 0.065


def with_box_thighs(folder, thin, deep):
    """Write GENIBO with boxes as thighs, thin across the leg's plane and deep in it [m]."""
    root = ElementTree.fromstring(urdf_from_robot(load_robot('genibo')))
    axes = {
        joint.find('child').get('link'): np.array(joint.find('axis').get('xyz').split(), float)
        for joint in root.iter('joint')
        if joint.find('axis') is not None
    }
    for link in root.iter('link'):
        if link.get('name').endswith('_thigh'):
            across = np.abs(axes[link.get('name')])
            size = [LENGTH, *np.where(across[1:] > 0.5, thin, deep)]
            geometry = link.find('collision').find('geometry')
            geometry.clear()
            ElementTree.SubElement(geometry, 'box', size=' '.join(map(str, size)))
            link.find('collision').find('origin').set('rpy', '0 0 0')
    path = folder / 'boxes.urdf'
    path.write_text(ElementTree.tostring(root, encoding='unicode'))
    return path


def imported(path):
    """Import a description and load what is written."""
    return load_robot(str(write_robot(import_robot(path), path.with_suffix('.yaml'))[0]))


@pytest.mark.parametrize('roll', [0.0, 0.2, 0.45])
@pytest.mark.parametrize(('thin', 'deep'), [(0.018, 0.018), (0.01, 0.04), (0.03, 0.03)])
def test_edges_of_a_rolled_thigh_reach_no_farther_than_what_parts_keep(tmp_path, thin, deep, roll):
    robot = imported(with_box_thighs(tmp_path, thin, deep))
    edge = 0.5 * thin * math.cos(roll) + 0.5 * deep * math.sin(roll)
    assert robot.shape.radii['thigh'] + robot.own_parts.least >= edge


def test_thin_and_deep_thighs_are_thinner_than_their_edges_are_away(tmp_path):
    robot = imported(with_box_thighs(tmp_path, 0.01, 0.03))
    assert robot.shape.radii['thigh'] == pytest.approx(0.6 * math.hypot(0.005, 0.015), rel=1e-3)
