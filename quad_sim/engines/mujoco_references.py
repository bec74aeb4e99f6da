"""
Loops over what MuJoCo's constraints drive toward; they run once in each step.

A step of physics takes 30 to 60 microseconds, so that a dozen calls of NumPy would be a third of
it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop

Array = NDArray[np.float64]

CREEP, STIFFENING, IS_NEW = range(3)
"""What is known of a constraint: by which reference its creep is taken back [m/s^2], by how much it
has stiffened [1/s^2], and whether it came with this step."""


@compiled_loop
def aim_motors(
    positions: Array, velocities: Array, angles: Array, wanted: Array, ahead: float
) -> float:
    """
    Find what joints miss, as if velocities were to be reached by position errors alone.

    Parameters
    ----------
    positions, velocities : ndarray, shape (n,)
        Wanted at the end of the step [rad, rad/s].
    angles : ndarray, shape (n,)
        Where the joints are [rad].
    wanted : ndarray, shape (n,)
        Is filled [rad].
    ahead : float
        Error of a position that counts as much as one of a velocity [s].

    Returns
    -------
    float
        Sum of their squares [rad^2]; not a number if one of them is none.
    """
    total = 0.0
    for k in range(len(wanted)):
        missing = velocities[k] * ahead + positions[k] - angles[k]
        wanted[k] = missing
        total += missing * missing
    return total


@compiled_loop
def pull_contacts(
    velocities: Array,
    distances: Array,
    references: Array,
    motors: Array,
    contacts: Array,
    laws: Array,
) -> None:
    """
    Add to the references of a step's constraints: motors, then edges of contacts.

    Parameters
    ----------
    velocities, distances : ndarray, shape (n + m,)
        Of the constraints: ``efc_vel`` [rad/s, m/s], and ``efc_pos``, which is negative where
        geometries are within one another [m].
    references : ndarray, shape (n + m,)
        ``efc_aref``; is added to [rad/s^2, m/s^2].
    motors : ndarray, shape (n,)
        What is added for motors [rad/s^2].
    contacts : ndarray, shape (3, m)
        What is known of each edge of a contact, see `CREEP`; is brought up to date.
    laws : ndarray, shape (4,)
        By how much the creep's reference changes for a velocity [1/s], its most [m/s^2], the part
        of the way to the most stiffness that is gone in a step, and that [1/s^2].
    """
    count = len(motors)
    for k in range(count):
        references[k] += motors[k]
    gain, slip, part, stiffest = laws[0], laws[1], laws[2], laws[3]
    for edge in range(contacts.shape[1]):
        if contacts[IS_NEW, edge] > 0.0:
            # How a foot came down is no creep.
            contacts[IS_NEW, edge] = 0.0
        else:
            change = gain * (velocities[count + edge] - velocities[count + (edge ^ 1)])
            contacts[CREEP, edge] = min(max(contacts[CREEP, edge] + change, -slip), slip)
        contacts[STIFFENING, edge] += part * (stiffest - contacts[STIFFENING, edge])
        references[count + edge] += (
            contacts[CREEP, edge] + contacts[STIFFENING, edge] * distances[count + edge]
        )


def warm_up() -> None:
    """Have the loops compiled, or read what is kept of them, so that no step is late by that."""
    one = np.zeros(1)
    aim_motors(one, one, one, one, 0.0)
    pull_contacts(one, one, one, one, np.zeros((3, 0)), np.zeros(4))
