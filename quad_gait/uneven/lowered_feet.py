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
    Tells which feet are lowered, and which of them have met the ground.

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
        self._missed: set[int] = set()
        self.in_vain: list[int] = []
        """Legs whose feet were lowered, met nothing, and bore nothing when last looked at."""
        self.go_on(legs)

    def go_on(self, legs: Sequence[int]) -> None:
        """Lower the feet of legs next."""
        self.legs = sorted(legs)
        """Legs whose feet are lowered."""
        self._bearing: set[int] = set()

    def look(self, now: Stance, is_over: bool, is_quick: bool) -> bool:
        """
        Look at the feet; return whether from now on others are to be lowered.

        Parameters
        ----------
        now : Stance
            The robot as it stands.
        is_over : bool
            Whether the feet are as low as was planned.
        is_quick : bool
            Whether they are lowered quickly: a leg that is set in motion so seems to bear load for
            a measurement.
        """
        before = self._bearing
        self._bearing = set(self.legs) & set(loaded_legs(self._robot, now, self._options))
        found = self._bearing & before if is_quick else self._bearing
        if not found and not is_over:
            return False
        self._sought.update(found or self.legs)
        self._missed.update(() if found else self.legs)
        return True

    def next_legs(self, now: Stance) -> list[int]:
        """Return the legs whose feet bear nothing, and were not lowered in vain."""
        unloaded = set(unloaded_legs(self._robot, now, self._options))
        self.in_vain = sorted(unloaded & self._missed)
        return sorted((unloaded | set(self.legs)) - self._sought)
