"""
Tells which of the trajectories that were given out the joints follow.

Trajectories travel, and it is not known when one has arrived, or whether. Under load they come
late by any time, or never, and the robot goes on with the one it has. Only the joints tell:
where they are, all at once, must be

- on a trajectory that has begun, at most ``age`` behind; one without a stamp may have begun
  at any time since it was given out,
- or in transition from one of them into a later one: to its first point if that lies ahead, or
  else with the offset between the two at the arrival, which decays within ``joining``.

A trajectory is void once the joints have followed a later one for a while and no longer that one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.trajectory.trajectory_executor import LONGEST_FADING
from quad_gait.faults.command_candidate import Candidate
from quad_gait.faults.joint_path import JointPath

Array = NDArray[np.float64]

_ARRIVAL_SPACING = 0.02
"""Time between two instants at which a later trajectory may have arrived [s]. Legs that swing turn
by more than a joint may be off in a few of them."""

_MOST_ARRIVALS = 101
"""Number of such instants that are tried at most."""

_LARGEST_COUNT = 12
"""Number of trajectories that the joints may follow that are kept."""

_PASSED_BY = 2.0
"""What joints may be off, times this, is how far they are from a trajectory's beginning that they
follow for sure."""

_INSTANT = 0.02
"""Time over which the speed of a command is taken [s]."""

_ALIKE = 0.02
"""Fraction of what joints may be off by which one command fits no worse than another."""

_CONFIRMATION = 0.1
"""Time for which joints must have been on a trajectory without a break before earlier ones are void
[s]: in transition into one that came late they pass by others, for a few instants."""

_EXPIRY = 0.5
"""Time past its end after which a trajectory that was not followed is void [s]."""


@dataclass(frozen=True)
class TrackerOptions:
    """How far sound joints are from their commands, and how late."""

    tolerance: float = 0.07
    """Distance that a joint may have from its command at rest [rad]."""
    lag: float = 0.01
    """Time by which a joint may be behind while others are not [s]."""
    age: float = 0.06
    """Time by which all joints may be behind, or measurements old [s]."""
    joining: float = LONGEST_FADING
    """Time in which joints join a trajectory that came late [s]."""


class Explanation(NamedTuple):
    """The command that fits the joints best."""

    posture: Array
    """Where the joints should be, shape (n,) [rad]."""
    allowed: Array
    """Distance that sound joints may have from there, shape (n,) [rad]."""
    off: NDArray[np.bool_]
    """Joints that are not there, shape (n,)."""
    is_latest: bool
    """Whether it is the latest trajectory that should run."""
    is_sure: bool
    """Whether the joints have just left an earlier one for it, or no other can be followed."""
    is_joined: bool
    """Whether it is the trajectory itself, and not the transition into it."""


class CommandTracker:
    """
    Keeps the trajectories that may be followed, and finds the one that is.

    Parameters
    ----------
    options : TrackerOptions, optional
        How far sound joints are from their commands.
    """

    def __init__(self, options: TrackerOptions | None = None) -> None:
        self._options = TrackerOptions() if options is None else options
        self.forget()

    def __bool__(self) -> bool:
        """Return whether any command is known."""
        return bool(self._candidates)

    @property
    def is_exact(self) -> bool:
        """Whether no trajectory starts on arrival: how late such a one has come is not known."""
        return not any(candidate.path.starts_on_arrival for candidate in self._candidates)

    def forget(self) -> None:
        """Know no trajectory."""
        self._candidates: list[Candidate] = []
        self._followed: Candidate | None = None
        self._time = self._time_before = -np.inf

    def hold(self, time: float, positions: Array) -> None:
        """Take notice of joints that hold a posture, shape (n,) [rad], before all else."""
        path = JointPath.hold(positions, time, self._options.tolerance)
        self._candidates.insert(0, Candidate(path, matched=time))

    def add(self, path: JointPath) -> None:
        """Take notice of a trajectory that is given out; of two at one time the later counts."""
        if self._candidates and self._candidates[-1].path.given >= path.given:
            last = self._candidates.pop()
            if last is self._followed:
                self._followed = None
        self._candidates.append(Candidate(path))
        if len(self._candidates) > _LARGEST_COUNT:
            # The first one may still be followed; of the others the oldest goes.
            later = self._candidates[1:]
            self._candidates.remove(next(c for c in later if c is not self._followed))

    def commanded(self, time: float) -> Array | None:
        """Return where the joints are commanded to be, shape (n,) [rad]; None if unknown."""
        followed = self.followed
        return None if followed is None else followed.path.at(time - followed.delay)[0]

    @property
    def followed(self) -> Candidate | None:
        """The trajectory that the joints follow, or the latest; None if none is known."""
        if self._followed is None and self._candidates:
            return self._candidates[-1]
        return self._followed

    def latest(self, time: float) -> tuple[Array, Array] | None:
        """
        Return where the latest trajectory that has begun has the joints, and what they may be off.

        Each of shape (n,) [rad]; None if none has begun, or the latest was never followed.
        """
        for candidate in reversed(self._candidates):
            if candidate.is_outdated:
                return None
            if candidate.path.given <= time and candidate.path.begin <= time:
                return candidate.path.at(time - candidate.delay)
        return None

    def speeds(self, time: float) -> Array:
        """Return how fast the joints are commanded to turn, shape (n,) [rad/s]."""
        now, before = self.commanded(time), self.commanded(time - _INSTANT)
        if now is None or before is None:
            return np.zeros(0)
        return np.abs(now - before) / _INSTANT

    def explain(
        self, time: float, positions: Array, strictness: Array | None = None
    ) -> Explanation | None:
        """
        Find the command that fits the joints.

        Parameters
        ----------
        time : float
            When they were measured [s].
        positions : ndarray, shape (n,)
            [rad]
        strictness : ndarray, shape (n,), optional
            By so much less than usual a joint may be off [rad]. Where more than one joint would be
            off by that, or a trajectory starts on arrival, it does not count.

        Returns
        -------
        Explanation or None
            One that fits all joints, or all but one; None if none does.
        """
        if time > self._time:
            self._time_before, self._time = self._time, time
        if self.is_exact and strictness is not None and strictness.any():
            found = self._explain(time, positions, strictness)
            if found is not None:
                return found
        return self._explain(time, positions, 0.0)

    def _explain(
        self, time: float, positions: Array, strictness: Array | float
    ) -> Explanation | None:
        """Find the command that fits, with joints that may be off by less than usual."""
        begun = [c for c in self._candidates if c.path.given <= time and c.path.begin <= time]
        for candidate in reversed(begun):
            posture, allowed = candidate.path.at(time - candidate.delay)
            off = np.abs(positions - posture) > allowed - strictness
            if not off.any():
                self._match(candidate, time)
                goes_on = len(begun) > 1 and self._settle_for(candidate, begun, time, positions)
                self._followed = candidate
                if candidate.path.starts_on_arrival:
                    self._bound_delay(candidate, time, positions)
                latest, sure = self._latest_and_sure(candidate, begun, goes_on)
                return Explanation(posture, allowed, off, latest, sure, is_joined=True)
        return self._search(begun, time, positions, strictness)

    def _match(self, candidate: Candidate, time: float) -> None:
        """Note that all joints are on a trajectory."""
        if candidate.matched < self._time_before or np.isinf(candidate.matched):
            candidate.matched_since = time
        candidate.matched = time

    def _bound_delay(self, candidate: Candidate, time: float, positions: Array) -> None:
        """
        Find the largest delay of a trajectory that the joints follow.

        It has one delay: what does not fit now will not later. Without that a joint that is jammed
        in a small motion would be explained by a trajectory that is delayed more and more.
        """
        # While earlier ones may still be followed, the joints may pass by this one on their way.
        factor = 1.0 if len(self._candidates) == 1 else _PASSED_BY
        if not np.isfinite(candidate.latest) or factor == 1.0:
            first, allowed = candidate.path.at(candidate.path.begin)
            if (np.abs(positions - first) > factor * allowed).any():
                postures, allowed, delays = candidate.rows(time, self._options.age)
                fits = (np.abs(positions - postures) <= allowed).all(axis=1)
                if fits.any():
                    latest = float(delays[fits].max()) + self._options.age
                    candidate.latest = min(candidate.latest, latest)

    def _settle_for(
        self, followed: Candidate, begun: list[Candidate], time: float, positions: Array
    ) -> bool:
        """
        Drop earlier trajectories that the joints are no longer on, and later ones that ended.

        Returns
        -------
        bool
            Whether the joints have left an earlier one.
        """
        goes_on = False
        place = begun.index(followed)
        is_confirmed = time - followed.matched_since >= _CONFIRMATION
        for candidate in begun[:place]:
            posture, allowed = candidate.path.at(time - candidate.delay)
            fits = bool((np.abs(positions - posture) <= allowed).all())
            if not fits:
                postures, allowed, _ = candidate.rows(time, self._options.age)
                fits = bool((np.abs(positions - postures) <= allowed).all(axis=1).any())
            if fits:
                self._match(candidate, time)
                # They may be on this one, and on each in between next.
                is_confirmed = False
            elif is_confirmed:
                self._candidates.remove(candidate)
                goes_on = True
        for candidate in begun[place + 1 :]:
            path = candidate.path
            if not path.starts_on_arrival and time > path.end + _EXPIRY:
                # A controller refuses what has ended: it will not be followed any more.
                self._candidates.remove(candidate)
                followed.is_outdated = True
        return goes_on

    def _search(
        self, begun: list[Candidate], time: float, positions: Array, strictness: Array | float
    ) -> Explanation | None:
        """Look at all that may be followed, with delays and in transition into each other."""
        blocks = [(candidate, *candidate.rows(time, self._options.age)) for candidate in begun]
        for k, later in enumerate(self._candidates):
            if later.path.given <= time:
                for earlier in self._candidates[:k]:
                    joining = self._joining(earlier, later, time, positions)
                    if joining is not None:
                        blocks.append((later, *joining))
        if not blocks:
            return None
        postures = np.concatenate([block[1] for block in blocks])
        allowed = np.concatenate([block[2] for block in blocks])
        delays = np.concatenate([block[3] for block in blocks])
        owners = np.repeat(np.arange(len(blocks)), [len(block[1]) for block in blocks])
        fraction = np.abs(positions - postures) / (allowed - strictness)
        off = fraction > 1.0
        count = off.sum(axis=1)
        least = int(count.min())
        if least > 1:
            return None
        rows = np.flatnonzero(count == least)
        # How well all joints but the one that is off fit.
        fit = np.where(off[rows], 0.0, fraction[rows]).max(axis=1)
        # Of trajectories that ask for the same now the latest is followed.
        row = int(rows[np.flatnonzero(fit <= fit.min() + _ALIKE)[-1]])
        owner = blocks[int(owners[row])][0]
        goes_on = False
        is_joined = bool(np.isfinite(delays[row]))
        if is_joined:
            owner.delay = float(delays[row]) if owner.path.starts_on_arrival else 0.0
            self._followed = owner
            if least == 0:
                self._match(owner, time)
                if owner.path.starts_on_arrival:
                    self._bound_delay(owner, time, positions)
                if owner in begun:
                    goes_on = self._settle_for(owner, begun, time, positions)
            else:
                self._drop_others(owner, begun, time, positions, off[row])
        latest, sure = self._latest_and_sure(owner, begun, goes_on)
        return Explanation(postures[row], allowed[row], off[row], latest, sure, is_joined)

    def _latest_and_sure(
        self, owner: Candidate, begun: list[Candidate], goes_on: bool
    ) -> tuple[bool, bool]:
        """Return whether a trajectory is the latest, and whether it is sure that it is followed."""
        is_latest = not begun or (owner is begun[-1] and not owner.is_outdated)
        is_only = len(self._candidates) == 1
        return is_latest, goes_on or (is_latest and is_only)

    def _drop_others(
        self,
        followed: Candidate,
        begun: list[Candidate],
        time: float,
        positions: Array,
        suspect: NDArray[np.bool_],
    ) -> None:
        """Drop earlier trajectories that sound joints have left for longer than a joining."""
        for candidate in begun[: begun.index(followed)]:
            if time - candidate.matched > self._options.joining:
                postures, allowed, _ = candidate.rows(time, self._options.age)
                fits = (np.abs(positions - postures) <= allowed) | suspect
                if not fits.all(axis=1).any():
                    self._candidates.remove(candidate)

    def _joining(
        self, earlier: Candidate, later: Candidate, time: float, positions: Array
    ) -> tuple[Array, Array, Array] | None:
        """
        Return the postures nearest to the joints in transition from one trajectory into another.

        One for each instant at which the later one may have arrived.
        """
        path, options = later.path, self._options
        latest = max(earlier.matched, path.given)
        is_ahead = path.begin > time
        if not is_ahead and not path.starts_on_arrival and time - latest > options.joining:
            return None
        first = min(latest, time)
        count = min(1 + int(np.ceil((time - first) / _ARRIVAL_SPACING)), _MOST_ARRIVALS)
        arrivals: Array = np.linspace(first, time, count, dtype=np.float64)
        before, allowed_before = earlier.path.over(arrivals - earlier.delay)
        if is_ahead or path.starts_on_arrival:
            there, allowed = path.at(path.begin)
            offset = before - there
        else:
            there, allowed = path.at(time)
            offset = before - path.over(arrivals)[0]
        length = np.maximum((offset**2).sum(axis=1), 1e-12)
        fraction = np.clip(((positions - there) * offset).sum(axis=1) / length, 0.0, 1.0)
        postures = there + fraction[:, None] * offset
        # Which part of the transition it is tells nothing of a delay.
        return postures, np.maximum(allowed, allowed_before), np.full(count, np.nan)
