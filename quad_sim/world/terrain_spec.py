"""
Ground by name: what a parameter or an option says of it, and the terrain that it means.

    bumps                              one kind of ground
    slope+noise                        several, added up
    slope:angle=0.1+boxes:height=0.03  with numbers of their own
    stairs:height=0.04,count=10        stairs up, and down again
    hills.yaml                         a height map file
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from quad_common.errors import ParameterError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_file import load_height_map
from quad_common.planar_pose import Pose2D
from quad_sim.world import terrain_courses as courses
from quad_sim.world import terrain_shapes as shapes
from quad_sim.world.terrain import Terrain
from quad_sim.world.terrain_shapes import Places

KINDS = (
    'bumps',
    'slope',
    'cross_slope',
    'kerb',
    'noise',
    'boxes',
    'stairs',
    'stones',
    'gap',
    'beam',
)
"""Kinds of ground, besides ``flat`` and files."""

_WITH_GAPS = ('stones', 'gap', 'beam')
"""Kinds that lie over a pit."""

FLAT = 'flat'

FILES = ('.yaml', '.yml')
"""Endings of the name of a height map file."""

_DIGITS = 30
"""Largest number of digits of a seed that are read."""

MOST_PARTS = 16
"""Largest number of grounds that are added up."""

RESOLUTION = 0.02
"""Side of a cell of the height field [m]."""

STEEPEST = 0.6
"""Largest angle of a slope: a foot slides on it before [rad]."""


@dataclass(frozen=True)
class TerrainSpec:
    """
    One kind of ground and its numbers, of which it uses those that it has.

    Raises
    ------
    ParameterError
        If a field is not what its description says.
    """

    kind: str
    """One of :data:`KINDS`, or the path of a height map file."""
    height: float = 0.04
    """Height of the highest bumps, boxes and waves of noise, of kerbs and of each stair; by which
    stepping stones differ; 0 to 1 [m]."""
    angle: float = 0.15
    """Angle of slopes, within 0.6 on both sides [rad]."""
    size: float = 0.4
    """Mean diameter of bumps and diagonal of boxes, length of noise's waves, depth of treads, side
    of stepping stones, 0.1 to 10 [m]."""
    length: float = 1.5
    """Length of each part of a slope, of a kerb, of the landing above stairs, of the path over
    stepping stones and of a beam, 0.1 to 100 [m]."""
    clear: float = 0.8
    """Radius of the level ground around start and goal, 0 to 10 [m]."""
    seed: int = 0
    """Seed of bumps, noise, boxes and stepping stones, at least 0."""
    count: int = 10
    """Number of stairs up, and of those down, 1 to 100."""
    gap: float = 0.09
    """Width of a gap, and of those between stepping stones, 0.01 to 10 [m]."""
    width: float = 0.8
    """Width of a beam, 0.01 to 100 [m]."""
    depth: float = 0.3
    """Depth of the pit below gaps, stepping stones and beams, 0 to 10 [m]."""

    def __post_init__(self) -> None:
        """Check the fields."""
        if self.kind not in KINDS and not self.is_file:
            raise ParameterError(
                'terrain',
                self.kind,
                f'{FLAT}, one of {", ".join(KINDS)}, a height map file (.yaml), '
                "or several of them with '+' between",
            )
        for name, (low, high) in _RANGES.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise ParameterError(f'terrain_{name}', value, f'from {low:g} to {high:g}')

    @property
    def is_file(self) -> bool:
        """Whether it is a height map file."""
        return self.kind.endswith(FILES)

    def scaled(self, factor: float, seed: int) -> TerrainSpec:
        """Return the same ground for a robot so many times as large, drawn with another seed."""
        return dataclasses.replace(
            self,
            height=factor * self.height,
            size=factor * self.size,
            length=factor * self.length,
            clear=factor * self.clear,
            gap=factor * self.gap,
            width=factor * self.width,
            depth=factor * self.depth,
            seed=seed,
        )


_RANGES = {
    'height': (0.0, 1.0),
    'angle': (-STEEPEST, STEEPEST),
    'size': (0.1, 10.0),
    'length': (0.1, 100.0),
    'clear': (0.0, 10.0),
    'seed': (0, 2**63 - 1),
    'count': (1, 100),
    'gap': (0.01, 10.0),
    'width': (0.01, 100.0),
    'depth': (0.0, 10.0),
}

_WHOLE = ('seed', 'count')
"""Numbers that are whole."""


def specs_from_text(text: str, **numbers: float) -> tuple[TerrainSpec, ...]:
    """
    Read what ground is wanted.

    Parameters
    ----------
    text : str
        As at the head of this module; empty or ``flat`` for none.
    **numbers : float
        Fields of :class:`TerrainSpec` for every part that has none of its own.

    Returns
    -------
    tuple of TerrainSpec
        The parts; none for flat ground.

    Raises
    ------
    ParameterError
        If there is no such ground, or a number is not valid.
    """
    parts = [part.strip() for part in text.split('+')]
    if parts == ['']:
        return ()
    # Level ground adds nothing to another part.
    parts = [part for part in parts if part != FLAT]
    if len(parts) > MOST_PARTS:
        raise ParameterError('terrain', text, f'of at most {MOST_PARTS} parts')
    return tuple(_spec(part, numbers) for part in parts)


def needs_footholds(text: str) -> bool:
    """Tell whether ground by name, as at the head of this module, has no continuous path."""
    return any(spec.kind in _WITH_GAPS for spec in specs_from_text(text))


def make_terrain(
    specs: tuple[TerrainSpec, ...],
    bounds: tuple[float, float, float, float],
    start: Pose2D,
    level_at: Places = (),
    resolution: float = RESOLUTION,
) -> Terrain | None:
    """
    Make the ground that is wanted.

    Parameters
    ----------
    specs : tuple of TerrainSpec
        The parts: fields are added up, then blocks are put upon them.
    bounds : tuple of float
        What it spans: x_min, y_min, x_max, y_max; a file that is the only part spans its own [m].
    start : Pose2D
        Pose of the robot: slopes and kerbs lie ahead of it.
    level_at : tuple of (float, float)
        Where bumps, noise and boxes leave the ground level, for example the start and the goal.
    resolution : float
        Side of a cell of the height field [m].

    Returns
    -------
    Terrain or None
        None for flat ground.

    Raises
    ------
    MapError
        If a height map file cannot be used, or the bounds have too many cells.
    """
    if not specs:
        return None
    if len(specs) == 1 and specs[0].is_file:
        return Terrain(load_height_map(specs[0].kind))
    level = HeightMap.level(bounds, resolution)
    field = level.with_heights(
        sum((_field(spec, level, start, level_at) for spec in specs), np.zeros_like(level.heights))
    )
    blocks = []
    for spec in specs:
        if spec.kind == 'kerb':
            blocks.append(shapes.kerb(level, start, spec.height, spec.length, spec.clear))
        elif spec.kind == 'boxes':
            scatter = shapes.Scatter(spec.size, level_at=level_at, clear=spec.clear)
            blocks += shapes.boxes(field, _rng(spec), spec.height, scatter)
        elif spec.kind == 'stairs':
            stairs = courses.Stairs(spec.height, spec.size, spec.count, spec.length)
            blocks += courses.staircase(level, start, stairs, spec.clear)
        elif spec.kind == 'stones':
            blocks += courses.stones(level, start, _rng(spec), _stones(spec), spec.clear)
        elif spec.kind == 'beam':
            blocks.append(courses.beam(start, spec.width, spec.length, spec.clear))
    return Terrain(field, tuple(blocks))


def _stones(spec: TerrainSpec) -> courses.Stones:
    return courses.Stones(spec.size, spec.gap, spec.height, spec.length)


def _field(
    spec: TerrainSpec, level: HeightMap, start: Pose2D, level_at: Places
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return the heights that a part adds to the field, shape (rows, columns) [m]."""
    if spec.kind == 'bumps':
        scatter = shapes.Scatter(spec.size, 0.5, level_at, spec.clear, gap=0.0)
        made = shapes.bumps(level, _rng(spec), spec.height, scatter)
    elif spec.kind == 'noise':
        made = shapes.noise(level, _rng(spec), spec.height, spec.size, level_at, spec.clear)
    elif spec.kind == 'slope':
        made = shapes.slope(level, start, spec.angle, spec.length, spec.clear)
    elif spec.kind == 'cross_slope':
        made = shapes.cross_slope(level, start, spec.angle)
    elif spec.kind in _WITH_GAPS:
        length = {'stones': _stones(spec).whole_length, 'gap': spec.gap}.get(spec.kind, spec.length)
        pit = courses.Pit(length, spec.depth, level_at, spec.clear)
        made = courses.pit(level, start, pit)
    elif spec.is_file:
        return load_height_map(spec.kind).height_at(level.centers, beyond=0.0)
    else:
        made = level
    return made.heights


def _rng(spec: TerrainSpec) -> np.random.Generator:
    # Each kind has numbers of its own: bumps stay where they are when boxes come to them.
    return np.random.default_rng((spec.seed, KINDS.index(spec.kind)))


def _spec(part: str, numbers: dict[str, float]) -> TerrainSpec:
    """Read one part: a kind, and numbers after a colon."""
    kind, _, given = part.partition(':')
    own: dict[str, float] = dict(numbers)
    for item in filter(None, given.split(',')):
        name, _, value = (piece.strip() for piece in item.partition('='))
        if name not in _RANGES:
            raise ParameterError('terrain', part, f'with numbers named {", ".join(_RANGES)}')
        try:
            own[name] = int(value[:_DIGITS]) if name in _WHOLE else float(value)
        except ValueError as error:
            whole = 'a whole number' if name in _WHOLE else 'a number'
            raise ParameterError(f'terrain_{name}', value, whole) from error
    return dataclasses.replace(TerrainSpec(kind.strip()), **own)  # type: ignore[arg-type]
