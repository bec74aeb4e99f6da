"""
Robots that people know by name and whose descriptions come with an installed package.

Nothing of these descriptions is kept here but where they are, and the figures they lack.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from quad_common.importing.options import ImportOptions


@dataclass(frozen=True)
class KnownRobot:
    """A robot by the package that holds its description."""

    package: str
    """Package that holds the description, by the name it is imported by."""
    file: str
    """Path of the description in that package."""
    options: ImportOptions = field(default_factory=ImportOptions)
    """What the description lacks."""
    source: str = ''
    """Source of these options."""

    @property
    def path(self) -> Path | None:
        """Path of the description; None if the package is not installed."""
        found = importlib.util.find_spec(self.package)
        if found is None or not found.submodule_search_locations:
            return None
        return Path(next(iter(found.submodule_search_locations))) / self.file


def _of_pybullet(file: str, source: str = '', **options: Any) -> KnownRobot:
    return KnownRobot('pybullet_data', file, ImportOptions(**options), source)


KNOWN_ROBOTS = {
    'a1': _of_pybullet(
        'a1/a1.urdf', 'Unitree A1: 33.5 N m, 21 rad/s', effort=(33.5,), speed=(21.0,)
    ),
    'aliengo': _of_pybullet(
        'aliengo/aliengo.urdf',
        'Unitree Aliengo: 44, 44 and 55 N m, 20, 20 and 16 rad/s',
        effort=(44.0, 44.0, 55.0),
        speed=(20.0, 20.0, 16.0),
    ),
    'laikago': _of_pybullet(
        'laikago/laikago_toes_zup.urdf',
        'chosen: its description has 100 N m and 100 rad/s for want of figures',
        effort=(40.0,),
        speed=(20.0,),
    ),
    'mini_cheetah': _of_pybullet(
        'mini_cheetah/mini_cheetah.urdf',
        'Katz, Di Carlo and Kim 2019: 17 N m and 40 rad/s, geared 1.55 times at the knee',
        effort=(17.0, 17.0, 26.0),
        speed=(40.0, 40.0, 26.0),
    ),
    'spirit40': _of_pybullet('quadruped/spirit40.urdf'),
    'vision60': _of_pybullet('quadruped/vision60.urdf'),
    'microtaur': _of_pybullet(
        'quadruped/microtaur/microtaur.urdf',
        'chosen, as of servos of 4.1 N m: its description has 100 N m and 100 rad/s; with knees '
        'forward it stands on the corners of its toes, otherwise on the flats of its calves',
        effort=(4.1,),
        speed=(4.8,),
        knees='forward',
    ),
}
"""Robots by the names under which they can be asked for."""


def known_names() -> tuple[str, ...]:
    """Return the names of those whose description is installed."""
    return tuple(name for name, known in KNOWN_ROBOTS.items() if known.path is not None)
