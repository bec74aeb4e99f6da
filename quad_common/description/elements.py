"""
What the reader of URDF expects of a file's elements, and would refuse in words of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from quad_common.errors import DescriptionEntryInvalid
from quad_common.errors.quoting import quoted

_NEEDED: dict[str, tuple[tuple[str, ...], dict[str, str]]] = {
    'link': (('name',), {}),
    'joint': (('name', 'type'), {'parent': 'link', 'child': 'link'}),
}
"""Elements, the attributes that each must have, and its children with theirs."""

_SHAPES = {
    'box': ('size',),
    'cylinder': ('radius', 'length'),
    'capsule': ('radius', 'length'),
    'sphere': ('radius',),
    'mesh': ('filename',),
}
"""Shapes that a geometry may be, and the attributes that each must have."""

_ORIGINS = {
    'joint': ('origin',),
    'link': ('inertial/origin', 'visual/origin', 'collision/origin'),
}
"""Where elements have origins."""

_COUNTS = {'xyz': (3,), 'rpy': (3, 4)}
"""Count of the numbers of an origin: a fourth angle, as microtaur's links have, is not read."""


def check_elements(root: Any, path: Path) -> None:
    """
    Refuse elements without what the reader of URDF expects of them, and drop what it stumbles at.

    Parameters
    ----------
    root : lxml.etree.Element
        The robot; capsules become cylinders, and textures without a file are taken away.
    path : Path
        The description, for the sentences of errors.

    Raises
    ------
    DescriptionEntryInvalid
        If an element lacks something, or has another count of numbers than it must have.
    """
    for kind, (attributes, children) in _NEEDED.items():
        for element in root.iterfind(kind):
            for attribute in attributes:
                if not element.get(attribute):
                    raise _invalid(element, path, f'has no {attribute}')
            for child, attribute in children.items():
                found = element.find(child)
                if found is None or not found.get(attribute):
                    raise _invalid(element, path, f'names no {child}')
    for owner, origin in _origins(root):
        for attribute, counts in _COUNTS.items():
            if attribute in origin.attrib:
                _check_count(owner, origin, attribute, counts, path)
    for joint in root.iterfind('joint'):
        _check_joint(joint, path)
    for geometry in root.iter('geometry'):
        _check_geometry(geometry, path)
    for texture in list(root.iter('texture')):
        if not texture.get('filename'):
            texture.getparent().remove(texture)


def _origins(root: Any) -> Iterator[tuple[Any, Any]]:
    """Yield links and joints with the origins in them."""
    for kind, places in _ORIGINS.items():
        for owner in root.iterfind(kind):
            for place in places:
                yield from ((owner, origin) for origin in owner.iterfind(place))


def _check_joint(joint: Any, path: Path) -> None:
    """Check a joint's axis, and that it says whom it follows if it does."""
    axis, mimic = joint.find('axis'), joint.find('mimic')
    # Exporters write anything for the axes of fixed joints, which mean nothing.
    if axis is not None and joint.get('type') != 'fixed':
        if 'xyz' not in axis.attrib:
            raise _invalid(joint, path, 'has an axis without xyz')
        _check_count(joint, axis, 'xyz', (3,), path)
    if mimic is not None and not mimic.get('joint'):
        raise _invalid(joint, path, 'has a mimic that names no joint')


def _check_count(
    owner: Any, element: Any, attribute: str, counts: tuple[int, ...], path: Path
) -> None:
    """Refuse an attribute that is not so many numbers."""
    text = element.get(attribute)
    words = text.split()
    if len(words) not in counts or not all(map(_is_number, words)):
        problem = (
            f'has an {element.tag} with {attribute}={quoted(text)}; it must be {counts[0]} numbers'
        )
        raise _invalid(owner, path, problem)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _check_geometry(geometry: Any, path: Path) -> None:
    """Refuse a geometry that is not one shape with its attributes; make capsules cylinders."""
    owner = geometry.getparent().getparent()
    shapes = [shape for shape in geometry if isinstance(shape.tag, str)]
    if len(shapes) != 1 or shapes[0].tag not in _SHAPES:
        found = ', '.join(str(shape.tag) for shape in shapes) or 'nothing'
        raise _invalid(owner, path, f'has a geometry of {found}')
    for attribute in _SHAPES[shapes[0].tag]:
        if not shapes[0].get(attribute):
            raise _invalid(owner, path, f'has a {shapes[0].tag} without {attribute}')
    if shapes[0].tag == 'capsule':
        # An extension of some engines, which the reader does not know.
        shapes[0].tag = 'cylinder'


def _invalid(owner: Any, path: Path, problem: str) -> DescriptionEntryInvalid:
    """Return the error of a link or a joint; of what belongs to none if there is no owner."""
    name = 'a shape' if owner is None else f"{owner.tag} '{owner.get('name', '')}'"
    return DescriptionEntryInvalid(path, name, problem)
