"""
What a robot tries when a stride over uneven ground cannot be made, or leads nowhere.

Within a stride another foot goes first, the body is raised, and a foot that no swing is found
for stays where it stands (`uneven_stride`). What is here changes the strides: a shorter one, a
longer one, one back; then footsteps are planned from where the feet stand, whatever the order of
legs; then a detour is asked of the planner, and the robot stops. Each is tried once; all of them
anew where the robot has got nearer to its goal than ever before.
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
    FOOTSTEPS = 'footsteps planned one by one'
    DETOUR = 'another path'


ORDER = tuple(WayOut)
"""Ways out in the order in which they are tried; footsteps only where there is a height map."""

_SHORTER, _LONGER, _BACK = 0.5, 1.35, 0.5
"""Factors of the stride that was wanted; that back is a part of the largest one."""

_RECOVERY = 1.25
"""Factor by which strides that had to be shorter grow again with each that gets on."""

_STRIDES = 5
"""Strides without any progress after which a way out is tried."""

_MOST_PLANS = 8
"""Times that footsteps are planned again, without the foothold that could not be stepped on."""

_STEPPING = 2.0
"""Largest strides after which footsteps have led out of where they were needed."""

_MOST_EARLY = 2
"""Times that footsteps are planned before strides fail, until the robot has got on."""

_PROGRESS = 0.05
"""Fraction of the largest stride that counts as progress."""


class Chosen(NamedTuple):
    """What is walked in the place of a step that was wanted."""

    step: Step
    """Step that is walked."""
    remark: str = ''
    """Which way out it is, and why, as a sentence; empty if it is none."""
    is_planned: bool = False
    """Whether footsteps take the place of the step, until they have led to where it leads."""
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
        self.knows_ground = False
        """Whether there is a height map, over which footsteps can be planned."""
        self.reset()

    def reset(self) -> None:
        """Begin again: something new is wished for."""
        self._least_left = math.inf
        self._strides = 0
        self._tried = self._early = 0
        self._factor = 1.0
        self._next: WayOut | None = None
        self._plans_left = 0
        self._stepping_from = math.inf
        self.problem = ''
        """Reason for the way out that was tried last."""

    @property
    def _order(self) -> list[WayOut]:
        return [way for way in ORDER if way is not WayOut.FOOTSTEPS or self.knows_ground]

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
            self._strides = self._tried = self._early = 0
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
        if self._plans_left > 0:
            self._plans_left -= 1
            return True
        if self._tried == len(self._order):
            return False
        self._next = self._order[self._tried]
        self._tried += 1
        return True

    @property
    def is_stepping(self) -> bool:
        """Whether footsteps that are planned one by one take the place of strides."""
        return self._plans_left > 0

    @property
    def has_stepped_on(self) -> bool:
        """Whether footsteps have led on far enough for strides to be tried again."""
        if self.left is None or not self.is_stepping:
            return False
        return self.left < self._stepping_from - _STEPPING * self._largest

    def end_footsteps(self) -> None:
        """Go on by strides: footsteps have led to where they were to, or there are none."""
        self._plans_left = 0

    def choose(self, step: Step, limit: str = '', is_strained: bool = False) -> Chosen | None:
        """
        Look at the progress before a stride begins, and change its step where a way out is due.

        Parameters
        ----------
        step : Step
            What is wanted.
        limit : str
            What kept the last stride from being what it was to be; empty if nothing did.
        is_strained : bool
            Whether that has left a foot far from its initial posture.

        Returns
        -------
        Chosen or None
            None if strides have led nowhere for a while and no way out is left.
        """
        if self.left is not None and not self.note_left(self.left, limit):
            return None
        if self.left is not None and self._next is WayOut.DETOUR:
            return Chosen(step, is_detour=True)
        may_step = self.left is not None and self.knows_ground and not self.is_stepping
        if limit and is_strained and may_step and self._next is None and self._early < _MOST_EARLY:
            self._early += 1
            # After more strides that are cut short no foot may find a way on any more.
            return self._by_footsteps(step, f'{WayOut.FOOTSTEPS.value}: {limit}')
        return self.take(step)

    def take(self, step: Step) -> Chosen:
        """Change a step as the way out asks for, and be done with that way out."""
        way, self._next = self._next, None
        if way is None:
            return Chosen(_scaled(step, self._factor))
        remark = f'{way.value} is tried ({self._tried} of {len(self._order)}): {self.problem}'
        if way is WayOut.FOOTSTEPS:
            return self._by_footsteps(step, remark)
        if way is WayOut.BACK:
            back = BodyMotion(forward=-_BACK * self._largest)
            return Chosen(Step(is_turn=False, motion=back), remark)
        if way is WayOut.SHORTER:
            self._factor = _SHORTER
            return Chosen(_scaled(step, self._factor), remark)
        return Chosen(_scaled(step, _LONGER), remark)

    def _by_footsteps(self, step: Step, remark: str) -> Chosen:
        self._plans_left = _MOST_PLANS
        self._stepping_from = math.inf if self.left is None else self.left
        return Chosen(step, remark, is_planned=True)


def _scaled(step: Step, factor: float) -> Step:
    """Return a part, or a multiple, of a step."""
    if factor == 1.0:
        return step
    motion = step.motion
    part = BodyMotion(factor * motion.forward, factor * motion.left, factor * motion.turn)
    return Step(step.is_turn, part)
