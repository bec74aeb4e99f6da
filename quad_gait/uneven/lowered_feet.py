"""
Feet that bear nothing are lowered until all four stand.
"""

from __future__ import annotations

from collections.abc import Sequence

from quad_common.robot.robot import Robot
from quad_gait.state.stance import Stance
from quad_gait.uneven.foot_contact import loaded_legs, unloaded_legs
from quad_gait.uneven.uneven_options import UnevenOptions


class LoweredFeet:
    """
    Tells which feet are lowered, which of them have met the ground, and which come off it.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    """

    def __init__(self, robot: Robot, options: UnevenOptions) -> None:
        self._robot, self._options = robot, options
        self.begin([])

    def begin(self, legs: Sequence[int]) -> None:
        """Lower the feet of legs; no other was lowered before."""
        self._sought: set[int] = set()
        self._begin(legs)

    def _begin(self, legs: Sequence[int]) -> None:
        self.legs = sorted(legs)
        """Legs whose feet are lowered."""
        self.has_lost = False
        """Whether another foot has come off the ground meanwhile."""
        self._asked, self._bearing, self._hanging = set(legs), set[int](), set[int]()

    def look(self, now: Stance, leg: int, is_over: bool, is_quick: bool) -> bool:
        """
        Look at all feet; return whether from now on others are to be lowered.

        Parameters
        ----------
        now : Stance
            The robot as it stands.
        leg : int
            Index of the leg that is to swing: its foot may bear nothing.
        is_over : bool
            Whether the feet are as low as was planned.
        is_quick : bool
            Whether they are lowered quickly: a leg that is set in motion so seems to bear load for
            a measurement.
        """
        before, hung = self._bearing, self._hanging
        self._bearing = set(self.legs) & set(loaded_legs(self._robot, now, self._options))
        found = self._bearing & before if is_quick else self._bearing
        unloaded = {*unloaded_legs(self._robot, now, self._options)}
        self._hanging = unloaded - self._asked - self._sought - {leg}
        self.has_lost = bool(self._hanging & hung)
        if not found and not self.has_lost and not is_over:
            return False
        # Where another foot has come off meanwhile it is lowered with these.
        self._sought.update(found if found or self.has_lost else self.legs)
        return True

    def next_legs(self, now: Stance) -> list[int]:
        """Return the legs whose feet bear nothing, and were not lowered in vain."""
        unloaded = {*unloaded_legs(self._robot, now, self._options), *self.legs}
        return sorted(unloaded - self._sought)

    def go_on(self, asked: Sequence[int], legs: Sequence[int]) -> None:
        """Lower the feet of legs next: as many of those that were asked for as can be at once."""
        self._begin(legs)
        self._asked = set(asked)
