"""
A gait, as data: which foot swings when, how the body moves and sways meanwhile.

Gaits are YAML files; the ones that ship lie in ``quad_gait/gaits``. Times are seconds
from the start of a cycle, which begins and ends in the initial posture.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml

from quad_common.errors import ParameterError
from quad_common.robot import LEGS

_GAITS = Path(__file__).parent / 'gaits'

_MIRROR = {'lf': 'rf', 'rf': 'lf', 'lh': 'rh', 'rh': 'lh'}


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
    cycle_period: float
    """[s]"""
    swings: tuple[Swing, ...]
    """In order of liftoff."""
    body_progress: tuple[tuple[float, float], ...]
    """Knots (time [s], share of the cycle's body motion); before and after: at rest."""
    swing_height: float
    """How high a foot is lifted [m]."""
    sway_start: float
    """When the body begins to move towards the first support triangle [s]."""
    sway_weight: float
    """Share of the way to a support triangle's centroid, S4's mu."""

    @property
    def motion_start(self) -> float:
        """When the first joint begins to move [s]."""
        first_swing = self.swings[0].liftoff
        sway = self.sway_start if self.sway_weight > 0.0 else first_swing
        return min(first_swing, sway, self.body_progress[0][0])

    def duty_factor(self, leg: str) -> float:
        """Return the share of the cycle in which a foot is on the ground."""
        swing = next(swing for swing in self.swings if swing.leg == leg)
        return 1.0 - (swing.touchdown - swing.liftoff) / self.cycle_period

    def mirrored(self) -> Gait:
        """Return the gait with left and right exchanged."""
        return replace(
            self, swings=tuple(replace(swing, leg=_MIRROR[swing.leg]) for swing in self.swings)
        )


def available_gaits() -> tuple[str, ...]:
    """Return the names of the gaits that ship with quadwalk."""
    return tuple(sorted(path.stem for path in _GAITS.glob('*.yaml')))


def load_gait(gait: str | Path) -> Gait:
    """
    Load a gait by the name of one that ships, or from a YAML file.

    Parameters
    ----------
    gait : str or Path
        Name (``crawl``) or path of a YAML file.

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
    path = shipped if shipped.is_file() else Path(gait)
    if not path.is_file():
        names = ', '.join(available_gaits())
        raise ParameterError('gait', str(gait), f'one of {names}, or the path of a gait file')
    try:
        document = yaml.safe_load(path.read_text(encoding='utf-8'))
        unchecked = _gait_from_document(document, path.stem)
    except ParameterError:
        raise
    except (yaml.YAMLError, KeyError, TypeError, ValueError, AttributeError) as error:
        why = f'{type(error).__name__}: {" ".join(str(error).split())}'
        raise ParameterError(
            'gait', str(path), f'a complete gait file, see docs/gaits.md ({why})'
        ) from error
    return _check(unchecked)


def _gait_from_document(document: Any, name: str) -> Gait:
    if not isinstance(document, Mapping):
        raise TypeError('it must hold a mapping')
    unknown = set(document) - {field.name for field in fields(Gait)}
    if unknown:
        raise ParameterError('gait', sorted(unknown), 'without keys that mean nothing here')
    swings = (Swing(leg, float(up), float(down)) for leg, (up, down) in document['swings'].items())
    return Gait(
        name=str(document.get('name', name)),
        cycle_period=float(document['cycle_period']),
        swings=tuple(sorted(swings, key=lambda swing: swing.liftoff)),
        body_progress=tuple((float(t), float(share)) for t, share in document['body_progress']),
        swing_height=float(document['swing_height']),
        sway_start=float(document['sway_start']),
        sway_weight=float(document['sway_weight']),
    )


def _check(gait: Gait) -> Gait:
    period = gait.cycle_period
    if not (math.isfinite(period) and period > 0.0):
        raise ParameterError('cycle_period', period, 'a positive number of seconds')
    if sorted(swing.leg for swing in gait.swings) != sorted(LEGS):
        legs = [swing.leg for swing in gait.swings]
        raise ParameterError('swings', legs, f'one swing for each of {", ".join(LEGS)}')
    for swing in gait.swings:
        if not 0.0 <= swing.liftoff < swing.touchdown <= period:
            raise ParameterError(
                f'swings.{swing.leg}',
                [swing.liftoff, swing.touchdown],
                f'a liftoff before a touchdown, both within 0 and {period} s',
            )
    times = [t for t, _ in gait.body_progress]
    shares = [share for _, share in gait.body_progress]
    rising = all(a < b for a, b in pairwise(times))
    if len(times) < 2 or not rising or times[0] < 0.0 or times[-1] > period:
        raise ParameterError(
            'body_progress', times, f'at least two rising times in 0 to {period} s'
        )
    if shares[0] != 0.0 or shares[-1] != 1.0 or any(b < a for a, b in pairwise(shares)):
        raise ParameterError('body_progress', shares, 'shares that rise from 0 to 1')
    if not gait.swing_height > 0.0:
        raise ParameterError('swing_height', gait.swing_height, 'positive')
    if not 0.0 <= gait.sway_weight <= 1.0:
        raise ParameterError(
            'sway_weight', gait.sway_weight, 'from 0 (no sway) to 1 (the centroid)'
        )
    if not 0.0 <= gait.sway_start <= gait.swings[0].liftoff:
        raise ParameterError(
            'sway_start', gait.sway_start, 'from 0 s to the first liftoff, for the body to sway in'
        )
    if gait.sway_weight > 0.0:
        starts = [gait.sway_start, *(swing.touchdown for swing in gait.swings)]
        ends = [*(swing.liftoff for swing in gait.swings), period]
        if any(end - start < 0.05 for start, end in zip(starts, ends)):
            raise ParameterError(
                'swings',
                [(swing.liftoff, swing.touchdown) for swing in gait.swings],
                'at least 0.05 s apart, from sway_start to the end of the cycle, for the body '
                'to sway in while all feet are down; or set sway_weight to 0',
            )
    return gait
