"""
A robot that carries a mass it does not know of.
"""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

from quad_common.robot.robot import Robot


def loaded(robot: Robot, payload: float) -> Robot:
    """
    Add a mass to the body, as large as the body and where the body's own center of mass is.

    Parameters
    ----------
    robot : Robot
        The robot.
    payload : float
        The mass [kg].

    Returns
    -------
    Robot
        What a simulator is to load; a controller has the robot as it was.
    """
    if payload == 0.0:
        return robot
    if not robot.own_urdf:
        return replace(robot, body_mass=robot.body_mass + payload)
    root = ElementTree.fromstring(robot.own_urdf)
    inertial = _body(root)
    mass = inertial.find('mass')
    assert mass is not None
    before = float(mass.get('value', '0'))
    mass.set('value', repr(before + payload))
    inertia = inertial.find('inertia')
    if inertia is not None:
        for name, value in inertia.attrib.items():
            inertia.set(name, repr(float(value) * (before + payload) / before))
    return replace(robot, own_urdf=ElementTree.tostring(root, encoding='unicode'))


def _body(root: ElementTree.Element) -> ElementTree.Element:
    """Return the inertia of the heaviest link among those that are one with the root."""
    links = {link.get('name'): link for link in root.iter('link')}
    joints = [
        (joint.find('parent'), joint.find('child'), joint.get('type'))
        for joint in root.findall('joint')
    ]
    pairs = [
        (parent.get('link'), child.get('link'), kind)
        for parent, child, kind in joints
        if parent is not None and child is not None
    ]
    own = set(links) - {child for _, child, _ in pairs}
    while True:
        more = {child for parent, child, kind in pairs if kind == 'fixed' and parent in own} - own
        if not more:
            break
        own |= more
    inertials = [links[name].find('inertial') for name in sorted(own, key=str)]
    return max((part for part in inertials if part is not None), key=_mass_of)


def _mass_of(inertial: ElementTree.Element) -> float:
    mass = inertial.find('mass')
    return 0.0 if mass is None else float(mass.get('value', '0'))
