"""
A gait, as data: which foot swings when and how, how the body moves and sways meanwhile.

Gaits are YAML files; the ones that ship lie in ``quad_gait/gaits``. Times are seconds
from the start of a cycle. At the start and the end of a cycle all feet are down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

from quad_common.errors import FileUnusable, ParameterError
from quad_common.files.bounded_file import is_file, user_path
from quad_common.files.yaml_document import read_yaml
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.gait_document import gait_fields

_GAITS = Path(__file__).parents[1] / 'gaits'

_MIRROR = {'lf': 'rf', 'rf': 'lf', 'lh': 'rh', 'rh': 'lh'}

FOOTHOLDS = ('initial_posture', 'mid_stance')
"""Under the body's end pose (S0), or where the foot is under its hip in mid-stance (S4)."""

SWING_PATHS = ('smooth', 'ellipse')
"""Lifted and lowered vertically at rest, or along half an ellipse (S2 eq. 5)."""

_WHAT = 'gait file'

_LEAST_SWAY_TIME = 0.05
"""Least time for the body to sway in, while all feet are down [s]."""

_GRAVITY = 9.80665
"""[m/s^2]"""


@dataclass(frozen=True)
class Swing:
    """One foot in the air."""

    leg: str
    """lf, rf, lh or rh."""
    liftoff: float
    """Time in the cycle [s]."""
    touchdown: float
    """Time in the cycle [s]."""


@dataclass(frozen=True)
class Gait:
    """One cycle of a gait, in which every foot swings once."""

    name: str
    """Name of the gait."""
    cycle_period: float
    """Duration of a cycle [s]."""
    swings: tuple[Swing, ...]
    """Swings in order of liftoff."""
    swing_height: float
    """Height to which a foot is lifted [m]."""
    body_progress: tuple[tuple[float, float], ...] | None = None
    """Knots (time [s], fraction of the cycle's body motion), with rests before and after;
    None for a body that moves on steadily from cycle to cycle."""
    footholds: str = 'mid_stance'
    """One of :data:`FOOTHOLDS`."""
    swing_path: str = 'smooth'
    """One of :data:`SWING_PATHS`."""
    support_depth: float = 0.0
    """Depth by which feet push down in mid-stance, as a fraction of the swing height; S2's rho."""
    sway_start: float = 0.0
    """Time at which the body begins to move towards the first support triangle [s]."""
    sway_weight: tuple[float, float] = (0.0, 0.0)
    """Fraction of the distance to a support triangle's centroid, forward and left; S4's mu."""
    pendulum_rate: float = 0.0
    """
    Rate of the inverted pendulum that a body on two feet is, sqrt(g / h) [1/s]; set by
    :meth:`fitted` for gaits that are not static.
    """
    is_static: bool = True
    """Whether the robot could stop at any time without falling: three feet always down."""

    @property
    def is_steady(self) -> bool:
        """Whether the body moves on from cycle to cycle, without a rest between them."""
        return self.body_progress is None

    @property
    def support_edges(self) -> tuple[float, ...]:
        """When one group of standing feet takes over from another, with both ends [s]."""
        # Feet that are in the air at the same time belong to one group.
        groups: list[tuple[float, float]] = []
        for swing in sorted(self.swings, key=lambda swing: swing.liftoff):
            if groups and swing.liftoff < groups[-1][1]:
                groups[-1] = (groups[-1][0], max(groups[-1][1], swing.touchdown))
            else:
                groups.append((swing.liftoff, swing.touchdown))
        changes = ((before[1] + after[0]) / 2.0 for before, after in pairwise(groups))
        return (0.0, *changes, self.cycle_period)

    @property
    def longest_swing(self) -> float:
        """Duration of the longest swing [s]."""
        return max(swing.touchdown - swing.liftoff for swing in self.swings)

    @property
    def acceleration_fraction(self) -> float:
        """
        Length in which a cycle gathers its speed from rest, as a fraction of that at speed.

        The cycle that loses its speed covers the rest of it. A pendulum does all of it over
        its last support, where it falls forward at first.
        """
        if self.pendulum_rate == 0.0:
            return 0.5
        edges = self.support_edges
        return (edges[-1] - edges[-2]) / (2.0 * self.cycle_period)

    @property
    def sways(self) -> bool:
        """Whether the body sways."""
        return any(self.sway_weight)

    @property
    def motion_start(self) -> float:
        """When the first joint begins to move, of a robot at rest [s]."""
        if self.body_progress is None:
            return 0.0
        first_swing = self.swings[0].liftoff
        sway = self.sway_start if self.sways else first_swing
        return min(first_swing, sway, self.body_progress[0][0])

    def swing(self, leg: str) -> Swing:
        """Return the swing of a leg."""
        return next(swing for swing in self.swings if swing.leg == leg)

    def duty_factor(self, leg: str) -> float:
        """Return the fraction of the cycle in which a foot is on the ground."""
        swing = self.swing(leg)
        return 1.0 - (swing.touchdown - swing.liftoff) / self.cycle_period

    def mirrored(self) -> Gait:
        """Return the gait with left and right exchanged."""
        return replace(
            self, swings=tuple(replace(swing, leg=_MIRROR[swing.leg]) for swing in self.swings)
        )

    def with_period(self, cycle_period: float) -> Gait:
        """Return the gait slower or faster, all its times in proportion."""
        factor = cycle_period / self.cycle_period
        progress = self.body_progress
        return replace(
            self,
            cycle_period=cycle_period,
            swings=tuple(
                Swing(swing.leg, factor * swing.liftoff, factor * swing.touchdown)
                for swing in self.swings
            ),
            body_progress=(
                None
                if progress is None
                else tuple((factor * t, fraction) for t, fraction in progress)
            ),
            sway_start=factor * self.sway_start,
        )

    def fitted(self, robot: Robot) -> Gait:
        """
        Return the gait with the period and swing height that a robot's data give it.

        Parameters
        ----------
        robot : Robot
            Where it says nothing of this gait, the period stays and feet are lifted in
            proportion to the hips' height, as TITAN-VIII's are.

        Returns
        -------
        Gait
            The gait for this robot.
        """
        settings = robot.gaits.get(self.name)
        period = settings.cycle_period if settings else None
        height = settings.swing_height if settings else None
        fitted = self if period is None else self.with_period(period)
        if height is None:
            height = self.swing_height * robot.relative_size
        if not self.is_static:
            rate = math.sqrt(_GRAVITY / robot.center_height)
            fitted = replace(fitted, pendulum_rate=rate)
        return replace(fitted, swing_height=height)


def available_gaits() -> tuple[str, ...]:
    """Return the names of the gaits that ship with quadwalk."""
    return tuple(sorted(path.stem for path in _GAITS.glob('*.yaml')))


def load_gait(gait: str | Path, robot: Robot | None = None) -> Gait:
    """
    Load a gait by the name of one that ships, or from a YAML file.

    Parameters
    ----------
    gait : str or Path
        Name (``crawl``) or path of a YAML file.
    robot : Robot, optional
        Whom to fit the gait to, see :meth:`Gait.fitted`.

    Returns
    -------
    Gait
        The gait, checked.

    Raises
    ------
    ParameterError
        If there is no such gait, or its data are incomplete or contradict themselves.
    """
    shipped = _GAITS / f'{gait}.yaml'
    try:
        path = shipped if is_file(shipped) else user_path(gait, _WHAT)
    except FileUnusable as error:
        raise ParameterError('gait', str(gait), f'a gait file ({error.reason})') from error
    if not is_file(path):
        names = ', '.join(available_gaits())
        raise ParameterError('gait', str(gait), f'one of {names}, or the path of a gait file')
    try:
        document = read_yaml(path, _WHAT, 'keys such as cycle_period, swings and swing_height')
    except FileUnusable as error:
        raise ParameterError(
            'gait', str(path), f'a complete gait file, see docs/gaits.md ({error.reason})'
        ) from error
    try:
        read = gait_fields(document, path.stem)
        swings = tuple(Swing(*swing) for swing in read.pop('swings'))
        checked = _check(Gait(swings=swings, **read))
    except ParameterError as error:
        raise error.at(f'{_WHAT} {path}: ') from error
    return checked if robot is None else checked.fitted(robot)


def turning_gait_for(gait: Gait, robot: Robot, turning_gait: str = 'auto') -> Gait:
    """
    Choose the gait for turning on the spot.

    Parameters
    ----------
    gait : Gait
        For walking.
    robot : Robot
        The robot.
    turning_gait : str
        Name, path, or ``auto``: ``turn`` (S0) beside a gait that rests between its
        cycles, and the gait itself if it keeps its speed.

    Returns
    -------
    Gait
        Fitted to the robot.
    """
    if turning_gait != 'auto':
        return load_gait(turning_gait, robot)
    return gait if gait.is_steady else load_gait('turn', robot)


def resting(gait: Gait) -> Gait:
    """
    Return a static gait as one that rests between its cycles.

    Parameters
    ----------
    gait : Gait
        With three feet on the ground at any time.

    Returns
    -------
    Gait
        With the same swings; its cycles end in the initial posture. Itself if it rests already.
    """
    if not gait.is_steady:
        return gait
    progress = ((0.0, 0.0), (gait.cycle_period, 1.0))
    return replace(gait, body_progress=progress, footholds='initial_posture')


def _check(gait: Gait) -> Gait:
    period = gait.cycle_period
    if sorted(swing.leg for swing in gait.swings) != sorted(LEGS):
        legs = [swing.leg for swing in gait.swings]
        raise ParameterError('swings', legs, f'one swing for each of {", ".join(LEGS)}')
    for swing in gait.swings:
        if not -1e-9 <= swing.liftoff < swing.touchdown <= period + 1e-9:
            raise ParameterError(
                f'swings.{swing.leg}',
                [swing.liftoff, swing.touchdown],
                f'a liftoff before a touchdown, both within 0 and {period} s, '
                f'for all feet are down at both ends of a cycle',
            )
    _check_progress(gait)
    if not 0.0 <= gait.support_depth < 1.0:
        raise ParameterError('support_depth', gait.support_depth, 'from 0 to below 1')
    for name, value, valid in (
        ('footholds', gait.footholds, FOOTHOLDS),
        ('swing_path', gait.swing_path, SWING_PATHS),
    ):
        if value not in valid:
            raise ParameterError(name, value, f'one of {", ".join(valid)}')
    if gait.is_static:
        _check_three_feet_down(gait)
    _check_sway(gait)
    return gait


def _check_progress(gait: Gait) -> None:
    if gait.body_progress is None:
        return
    times = [t for t, _ in gait.body_progress]
    fractions = [fraction for _, fraction in gait.body_progress]
    rising = all(a < b for a, b in pairwise(times))
    if len(times) < 2 or not rising or times[0] < 0.0 or times[-1] > gait.cycle_period + 1e-9:
        raise ParameterError(
            'body_progress', times, f'at least two rising times in 0 to {gait.cycle_period} s'
        )
    if (
        fractions[0] != 0.0
        or fractions[-1] != 1.0
        or not all(a <= b for a, b in pairwise(fractions))
    ):
        raise ParameterError('body_progress', fractions, 'fractions that rise from 0 to 1')


def _check_three_feet_down(gait: Gait) -> None:
    for before, after in pairwise(gait.swings):
        if after.liftoff < before.touchdown - 1e-9:
            raise ParameterError(
                'swings',
                [(swing.leg, swing.liftoff, swing.touchdown) for swing in gait.swings],
                f'one after the other in a static gait: from {after.liftoff:.3f} s to '
                f'{before.touchdown:.3f} s {before.leg} and {after.leg} are both in the air, '
                f'which leaves two feet down; a gait that means it says is_static: false',
            )


def _check_sway(gait: Gait) -> None:
    if not all(0.0 <= weight <= 1.0 for weight in gait.sway_weight):
        raise ParameterError(
            'sway_weight', gait.sway_weight, 'from 0 (no sway) to 1 (the centroid)'
        )
    if not 0.0 <= gait.sway_start <= gait.swings[0].liftoff + 1e-9:
        raise ParameterError(
            'sway_start', gait.sway_start, 'from 0 s to the first liftoff, for the body to sway in'
        )
    if gait.sways:
        starts = [gait.sway_start, *(swing.touchdown for swing in gait.swings)]
        ends = [*(swing.liftoff for swing in gait.swings), gait.cycle_period]
        if any(end - start < _LEAST_SWAY_TIME - 1e-9 for start, end in zip(starts, ends)):
            raise ParameterError(
                'swings',
                [(swing.liftoff, swing.touchdown) for swing in gait.swings],
                f'at least {_LEAST_SWAY_TIME} s apart, from sway_start to the end of the cycle, '
                f'for the body to sway in while all feet are down; or set sway_weight to 0',
            )
