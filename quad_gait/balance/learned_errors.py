"""
What a trot learns of errors that stay, or come back in every cycle.
"""

from __future__ import annotations

import math

from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.foot_laws import Pace, sway_velocity


class LearnedErrors:
    """
    Learns what the body is off in the mean and in each cycle, but for pushes and changes.

    Parameters
    ----------
    options : BalanceOptions
        Gains.
    unit : float
        Velocity sqrt(g h) [m/s].
    """

    def __init__(self, options: BalanceOptions, unit: float) -> None:
        self._options, self._unit = options, unit
        self.trim = (0.0, 0.0)
        """Velocity by which less is asked for than is wanted [m/s]."""
        self.upright = (0.0, 0.0)
        """Roll and pitch for which legs are set so that the body has none in the mean [rad]."""
        self.sway = (0.0, 0.0)
        """Velocity to the left that comes back in every cycle: parts of it that go as the cosine
        and the sine of the phase [m/s]."""

    def learn(
        self, body: BodyEstimate, planned: Pace, due: Pace, wanted: Pace, phase: float
    ) -> None:
        """
        Learn from a measurement.

        Less is asked for of a body that is faster than it should be, legs are set against the tilt
        of one that leans, and standing legs give way to one that sways.

        Parameters
        ----------
        body : BodyEstimate
            How the body moves.
        planned : Pace
            Velocity that is planned.
        due : Pace
            Velocity that it should have.
        wanted : Pace
            Velocity that it is to gather.
        phase : float
            Cycles since the trot began.
        """
        options, unit, dt = self._options, self._unit, self._options.knot_time
        x, y = body.velocity[0] - due.forward, body.velocity[1] - due.left
        change = math.hypot(wanted.forward - planned.forward, wanted.left - planned.left)
        if math.hypot(x, y) > options.pushed * unit or change > options.steady * unit:
            return
        most = options.largest_trim * unit
        self.trim = _integrated(self.trim, (x, y), options.trim_gain * dt, most)
        off = body.roll - body.slope.roll, body.pitch - body.slope.pitch
        gain = -options.upright_gain * dt
        self.upright = _integrated(self.upright, off, gain, options.largest_upright)
        # The mean of a cosine's square is a half.
        error, angle = y - sway_velocity(phase, self.sway), 2.0 * math.pi * phase
        step, kept = 2.0 * options.sway_gain * dt * error, 1.0 - options.sway_fading * dt
        cosine, sine = self.sway
        self.sway = (
            kept * cosine + step * math.cos(angle),
            kept * sine + step * math.sin(angle),
        )


def _integrated(
    sums: tuple[float, float], errors: tuple[float, float], gain: float, most: float
) -> tuple[float, float]:
    """Return integrals of two errors after one more, each within bounds."""
    (a, b), (x, y) = sums, errors
    return min(max(a + gain * x, -most), most), min(max(b + gain * y, -most), most)
