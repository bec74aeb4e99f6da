"""
Tracking of foot paths by feedback: the backstepping law of S1 (eqs. 12 to 18).

The gait generator finds joint angles in closed form. Here they are found as S1 does it:
joint velocities are commanded so that the foot's error dies out, from whatever joint
angles the leg really has. Where a leg is nearly singular (a straight knee, a foot under
the yaw axis) S1's pseudo-inverse would ask for boundless speeds, and S1 prints one that
does not exist there: (J^T J)^-1 J^T. Here it is damped instead.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ParameterError
from quad_common.robot.robot import Robot

Array = NDArray[np.float64]

DEFAULT_GAIN = 4.0
"""An error falls below 1 % within 2 s, as S1 fig. 10 has it, from 2.3 on [1/s]."""

SINGULAR = 0.05
"""A leg is nearly singular if J's smallest singular value is below this fraction of its largest."""

_LONGEST_STEP = 0.02
"""Step of the integration [s]; shorter if the gain needs it."""


class TrackedLeg(Protocol):
    """What the tracking of one foot needs of a leg."""

    def forward(self, joint_angles: Array) -> Array:
        """Place the foot: shape (..., 3) [rad] to (..., 3) [m]."""

    def jacobian(self, joint_angles: Array) -> Array:
        """Differentiate the foot's position: shape (..., 3) [rad] to (..., 3, 3) [m/rad]."""


class _FootPaths(NamedTuple):
    """Wanted paths of feet; between samples the cubics through positions and velocities."""

    times: Array
    """Times of the samples, rising, shape (n,) [s]."""
    positions: Array
    """Feet at the samples, p_d, shape (n, ..., 3) [m]."""
    velocities: Array
    """Their velocities, p_d', of the same shape [m/s]."""


def damped_inverse(J: Array, singular: float = SINGULAR) -> Array:
    """
    Invert Jacobians, exactly where that is safe and damped near singularities.

    J^+ = J^T (J J^T + mu^2 I)^-1 with mu = 0 as long as the smallest singular value s
    of J is at least eps = ``singular`` times the largest, and mu^2 = eps^2 - s^2 below
    (the variable damping of Nakamura and of Chiaverini). So |J^+ v| <= |v| / eps
    everywhere, and J^+ is continuous.

    Parameters
    ----------
    J : ndarray, shape (..., 3, 3)
        Jacobians [m/rad].
    singular : float
        Fraction of the largest singular value, from 0 to 1.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        [rad/m].
    """
    U, s, Vt = np.linalg.svd(J)
    # The floor keeps a leg that cannot move at all from 0/0.
    eps = np.maximum(singular * s[..., :1], 1e-12)
    damping = np.maximum(eps**2 - s[..., -1:] ** 2, 0.0)
    inverse: Array = np.swapaxes(Vt, -1, -2) @ (
        (s / (s**2 + damping))[..., None] * U.swapaxes(-1, -2)
    )
    return inverse


def backstepping(J: Array, foot: Array, target: Array, target_velocity: Array, K: Array) -> Array:
    """
    Find the joint velocities that let the foot's error die out.

    q' = J^+ (p_d' + K e) with e = p_d - p_e (S1 eqs. 12, 16, 18). With J^+ = J^-1 the
    error obeys e' = -K e, hence V = |e|^2 / 2 falls with V' = -e^T K e < 0 (S1 eq. 17;
    for S1's own V = e^T K e / 2 it would be -|K e|^2).

    Parameters
    ----------
    J : ndarray, shape (..., 3, 3)
        Jacobians at the present joint angles [m/rad].
    foot : ndarray, shape (..., 3)
        Where the foot is, p_e [m].
    target : ndarray, shape (..., 3)
        Where it should be, p_d, in the same frame [m].
    target_velocity : ndarray, shape (..., 3)
        p_d' [m/s].
    K : ndarray, shape () or (3,)
        Gain, the diagonal of S1's K [1/s].

    Returns
    -------
    ndarray, shape (..., 3)
        [rad/s].
    """
    wanted = target_velocity + K * (target - foot)
    velocities: Array = (damped_inverse(J) @ wanted[..., None])[..., 0]
    return velocities


def track_feet(
    robot: Robot,
    times: Array,
    feet: Array,
    foot_velocities: Array,
    start_joint_angles: Array,
    gain: float | Array = DEFAULT_GAIN,
) -> tuple[Array, Array]:
    """
    Track the paths of four feet from the joint angles that the robot really has.

    Between two samples the paths are the cubics through positions and velocities. The
    law is integrated by Runge and Kutta's method of fourth order, in steps of at most
    20 ms. All four legs go together, but the samples one after the other: each depends
    on the one before, which is what feedback is.

    Joint limits are not considered: check the result with
    :meth:`quad_common.robot.robot.Robot.check_joint_limits`.

    Parameters
    ----------
    robot : Robot
        The robot.
    times : ndarray, shape (n,)
        Rising [s].
    feet : ndarray, shape (n, 4, 3)
        Wanted paths in the body frame, p_d [m].
    foot_velocities : ndarray, shape (n, 4, 3)
        Of the feet in the body frame, p_d' [m/s].
    start_joint_angles : ndarray, shape (4, 3)
        At the first sample [rad].
    gain : float or ndarray of shape (3,)
        The diagonal of S1's K, along the body's axes, positive [1/s].

    Returns
    -------
    joint_positions : ndarray, shape (n, 4, 3)
        [rad].
    joint_velocities : ndarray, shape (n, 4, 3)
        What the law commands there [rad/s].

    Raises
    ------
    ParameterError
        If a shape is wrong, a number is not finite, the times do not rise or the gain is
        not positive.
    """
    K = _checked_gain(gain)
    times = np.asarray(times, dtype=float)
    if times.ndim != 1 or len(times) == 0 or not np.all(np.diff(times) > 0.0):
        raise ParameterError('times', times.shape, 'a list of rising numbers')
    p_d = _checked('feet', feet, (len(times), 4, 3))
    rates = _checked('foot_velocities', foot_velocities, (len(times), 4, 3))
    q0 = _checked('start_joint_angles', start_joint_angles, (4, 3))
    paths = _FootPaths(times, p_d, rates)
    return _integrate(robot.foot_positions, robot.foot_jacobians, paths, q0, K)


def step_response(
    leg: TrackedLeg,
    start: Array,
    target: Array,
    gain: float | Array = DEFAULT_GAIN,
    duration: float = 2.0,
    dt: float = 0.01,
) -> tuple[Array, Array, Array]:
    """
    Bring one foot to a target that stands still (S1 sec. V.B, figs. 8 to 10).

    Parameters
    ----------
    leg : TrackedLeg
        The leg.
    start : ndarray, shape (3,)
        Joint angles at the start [rad].
    target : ndarray, shape (3,)
        Wanted foot in the leg's frame, p_d [m].
    gain : float or ndarray of shape (3,)
        The diagonal of S1's K, positive [1/s].
    duration : float
        [s]
    dt : float
        Time between samples, which divide the duration evenly: at most this [s].

    Returns
    -------
    times : ndarray, shape (n,)
        From 0 to the duration [s].
    q : ndarray, shape (n, 3)
        Joint angles [rad].
    e : ndarray, shape (n, 3)
        The foot's error, p_d - p_e [m].

    Raises
    ------
    ParameterError
        If a shape is wrong, a number is not finite, or gain, duration or dt is not
        positive.
    """
    K = _checked_gain(gain)
    for name, value in (('duration', duration), ('dt', dt)):
        if not (np.isfinite(value) and value > 0.0):
            raise ParameterError(name, value, 'a positive number of seconds')
    steps = max(1, int(np.ceil(duration / dt - 1e-9)))
    times = np.linspace(0.0, duration, steps + 1, dtype=np.float64)
    p_d = np.tile(_checked('target', target, (3,)), (len(times), 1))
    q0 = _checked('start', start, (3,))
    path = _FootPaths(times, p_d, np.zeros_like(p_d))
    q, _ = _integrate(leg.forward, leg.jacobian, path, q0, K)
    return times, q, p_d - leg.forward(q)


def _integrate(
    forward: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    paths: _FootPaths,
    q0: Array,
    K: Array,
) -> tuple[Array, Array]:
    """Run the law from q0 [rad]: joint angles and velocities at the samples, shape (n, ..., 3)."""

    def law(q: Array, target: Array, target_velocity: Array) -> Array:
        return backstepping(jacobian(q), forward(q), target, target_velocity, K)

    times, p_d, rates = paths
    positions, velocities = np.empty_like(p_d), np.empty_like(p_d)
    q = q0
    longest = min(_LONGEST_STEP, 0.5 / float(np.max(K)))
    for k in range(len(times)):
        positions[k], velocities[k] = q, law(q, p_d[k], rates[k])
        if k + 1 == len(times):
            break
        span = float(times[k + 1] - times[k])
        steps = max(1, int(np.ceil(span / longest - 1e-9)))
        h = span / steps
        p, v = _cubic(
            p_d[k : k + 2], rates[k : k + 2], span, np.arange(2 * steps + 1) / (2 * steps)
        )
        k1 = velocities[k]
        for i in range(0, 2 * steps, 2):
            if i:
                k1 = law(q, p[i], v[i])
            k2 = law(q + h / 2.0 * k1, p[i + 1], v[i + 1])
            k3 = law(q + h / 2.0 * k2, p[i + 1], v[i + 1])
            k4 = law(q + h * k3, p[i + 2], v[i + 2])
            q = q + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return positions, velocities


def _cubic(ends: Array, rates: Array, span: float, fractions: Array) -> tuple[Array, Array]:
    """Run from one end to the other with given rates there: values and rates at fractions."""
    u = fractions.reshape((-1,) + (1,) * (ends.ndim - 1))
    step, r0, r1 = ends[1] - ends[0], span * rates[0], span * rates[1]
    a, b = r0 + r1 - 2.0 * step, 3.0 * step - 2.0 * r0 - r1
    return ends[0] + u * (r0 + u * (b + u * a)), (r0 + u * (2.0 * b + 3.0 * u * a)) / span


def _checked_gain(gain: float | Array) -> Array:
    K = np.asarray(gain, dtype=float)
    if K.shape not in ((), (3,)) or not np.all(np.isfinite(K) & (K > 0.0)):
        raise ParameterError('gain', gain, 'one or three positive numbers')
    return K


def _checked(name: str, values: Array, shape: tuple[int, ...]) -> Array:
    array = np.asarray(values, dtype=float)
    if array.shape != shape:
        raise ParameterError(name, array.shape, f'an array of shape {shape}')
    if not np.all(np.isfinite(array)):
        raise ParameterError(name, 'not finite', 'an array of finite numbers')
    return array
