"""
Poses of the body over four feet that are tried where legs do not reach from the initial one.
"""

from __future__ import annotations

TILTS = (0.0, 0.5, 1.0)
"""Fractions of the ground's tilt that the body may take."""

LOWER = (0.0, 0.03, 0.06)
"""Distance by which the body may be lower than in its initial posture [m]."""

HIGHER = (-0.02, -0.04)
"""The same where it is higher, so that its parts keep away from thighs: tried last [m]."""

LOWERINGS = (*LOWER, *HIGHER)
"""Distances by which the body may be lower than in its initial posture, of TITAN-VIII [m]."""
