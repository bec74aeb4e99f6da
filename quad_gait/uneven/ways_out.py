"""
What a robot tries when a stride over uneven ground cannot be made, or leads nowhere.

Within a stride another foot goes first, the body is raised, and a foot that no swing is found
for stays where it stands (`uneven_stride`). What is here changes the strides: a shorter one, a
longer one, one back; then a detour is asked of the planner, and the robot stops. Each is tried
once; all of them anew where the robot has got nearer to its goal than ever before.
"""

from __future__ import annotations

import enum
import math
from typing import NamedTuple

from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.following.step import Step


class WayOut(enum.Enum):
    """What is tried, in this order."""

    SHORTER = 'a shorter stride'
    LONGER = 'a longer stride'
    BACK = 'a stride back'
    DETOUR = 'another path'


ORDER = tuple(WayOut)
"""Ways out in the order in which they are tried."""

_SHORTER, _LONGER, _BACK = 0.5, 1.35, 0.5
"""Factors of the stride that was wanted; that back is a part of the largest one."""

_RECOVERY = 1.25
"""Factor by which strides that had to be shorter grow again with each that gets on."""

_STRIDES = 5
"""Strides without any progress after which a way out is tried."""

_PROGRESS = 0.05
"""Fraction of the largest stride that counts as progress."""


class Chosen(NamedTuple):
    """What is walked in the place of a step that was wanted."""

    step: Step
    """Step that is walked."""
    remark: str = ''
    """Which way out it is, and why, as a sentence; empty if it is none."""
    is_detour: bool = False
    """Whether no step leads on, and another path is needed."""


class WaysOut:
    """
    Watches the progress along a plan, and says what is tried where there is none.

    Parameters
    ----------
    largest_stride : float
        Of the robot [m].
    """

    def __init__(self, largest_stride: float) -> None:
        self._largest = largest_stride
        self.left: float | None = None
        """Distances and turns to the goal, as
        :func:`~quad_gait.following.reference_path.work_left` adds them up [m]; None where no plan
        is followed."""
        self.reset()

    def reset(self) -> None:
        """Begin again: something new is wished for."""
        self._least_left = math.inf
        self._strides = 0
        self._tried = 0
        self._factor = 1.0
        self._next: WayOut | None = None
        self.problem = ''
        """Reason for the way out that was tried last."""

    @property
    def next(self) -> WayOut | None:
        """Way out that the next stride is; None where there is nothing to get out of."""
        return self._next

    def note_left(self, left: float, limit: str = '') -> bool:
        """
        Take how much is left to do before a stride begins.

        Parameters
        ----------
        left : float
            Distances and turns to the goal, as
            :func:`~quad_gait.following.reference_path.work_left` adds them up [m].
        limit : str
            What kept the last stride from being what it was to be; empty if nothing did.

        Returns
        -------
        bool
            False if strides have led nowhere for a while and no way out is left.
        """
        if left < self._least_left - _PROGRESS * self._largest:
            self._least_left = left
            self._strides = self._tried = 0
            self._factor = min(1.0, _RECOVERY * self._factor)
            self._next = None
            return True
        self._strides += 1
        if self._next is not None:
            return True
        if limit:
            return self.fail(limit)
        if self._strides <= _STRIDES:
            return True
        return self.fail(f'{_STRIDES} strides have brought it no nearer to its goal')

    def fail(self, problem: str) -> bool:
        """
        Note that a stride could not be made, or led nowhere.

        Parameters
        ----------
        problem : str
            Reason, as a sentence.

        Returns
        -------
        bool
            Whether there is a way out that was not tried yet.
        """
        self._strides = 0
        self.problem = problem
        if self._tried == len(ORDER):
            return False
        self._next = ORDER[self._tried]
        self._tried += 1
        return True

    def choose(self, step: Step, limit: str = '') -> Chosen | None:
        """
        Look at the progress before a stride begins, and change its step where a way out is due.

        Parameters
        ----------
        step : Step
            What is wanted.
        limit : str
            What kept the last stride from being what it was to be; empty if nothing did.

        Returns
        -------
        Chosen or None
            None if strides have led nowhere for a while and no way out is left.
        """
        if self.left is not None and not self.note_left(self.left, limit):
            return None
        if self.left is not None and self._next is WayOut.DETOUR:
            return Chosen(step, is_detour=True)
        return self.take(step)

    def take(self, step: Step) -> Chosen:
        """Change a step as the way out asks for, and be done with that way out."""
        way, self._next = self._next, None
        if way is None:
            return Chosen(_scaled(step, self._factor))
        remark = f'{way.value} is tried ({self._tried} of {len(ORDER)}): {self.problem}'
        if way is WayOut.BACK:
            back = BodyMotion(forward=-_BACK * self._largest)
            return Chosen(Step(is_turn=False, motion=back), remark)
        if way is WayOut.SHORTER:
            self._factor = _SHORTER
            return Chosen(_scaled(step, self._factor), remark)
        return Chosen(_scaled(step, _LONGER), remark)


def _scaled(step: Step, factor: float) -> Step:
    """Return a part, or a multiple, of a step."""
    if factor == 1.0:
        return step
    motion = step.motion
    part = BodyMotion(factor * motion.forward, factor * motion.left, factor * motion.turn)
    return Step(step.is_turn, part)
