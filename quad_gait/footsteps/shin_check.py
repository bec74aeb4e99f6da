"""
Footsteps on which a shin would touch the ground.

Where a foot may stand is found once for all stances, its leg as it is in the initial posture. Over
footsteps feet are far from there, and the body goes over three of them for each swing: shins lean
where no foothold tells.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from quad_common.footing.postures import LOWERINGS
from quad_common.footing.shin_room import ShinRoom
from quad_common.maps.height_map import HeightMap
from quad_common.robot.robot import Robot
from quad_gait.footsteps.foothold_map import Foothold
from quad_gait.footsteps.footstep import Footstep
from quad_gait.state.body_balance import centered
from quad_gait.state.body_placement import BodyPose, balanced, body_over, heading_over

Array = NDArray[np.float64]

_LEVEL = np.zeros(2)


class ShinCheck:
    """
    Looks at the shins of planned footsteps.

    Parameters
    ----------
    robot : Robot
        The robot.
    margin : float
        Distance of the center of mass inside the three feet that stand [m].
    clearance : float
        Distance of shins from the ground [m].
    heights : HeightMap
        Of the ground.
    shift : float
        Height that is added to the map's, so that it fits the feet [m].
    """

    def __init__(
        self, robot: Robot, margin: float, clearance: float, heights: HeightMap, shift: float
    ) -> None:
        self._robot, self._margin = robot, margin
        self._room = ShinRoom(robot, clearance, heights, shift)
        self._center = robot.center_of_mass(robot.initial_joint_angles)

    def touching(self, feet: Array, steps: Sequence[Footstep]) -> list[Foothold]:
        """
        Find the footholds beside which a shin would touch the ground.

        Parameters
        ----------
        feet : ndarray, shape (4, 3)
            Centers of the feet before the first step [m].
        steps : sequence of Footstep
            The steps.

        Returns
        -------
        list of Foothold
            Footholds of the steps, each once; those that the feet stand on
            already are not among them.
        """
        moments = list(self._moments(feet, steps))
        if not moments:
            return []
        standing = np.array([each for _, each in moments])
        is_touched = self._room.touched(self._points([body for body, _ in moments], standing))
        is_touched &= np.any(standing[:, :, :2] != feet[:, :2], axis=2)
        found = [
            (int(leg), *standing[moment, leg, :2].tolist())
            for moment, leg in np.argwhere(is_touched)
        ]
        return list(dict.fromkeys(found))

    def _moments(self, feet: Array, steps: Sequence[Footstep]) -> Iterator[tuple[BodyPose, Array]]:
        """Yield where the body is while a foot is lifted, and has come down, and all feet then."""
        for step in steps:
            middle = feet.copy()
            middle[step.leg] = 0.5 * (feet[step.leg] + step.foothold)
            middle[step.leg, 2] = step.foothold[2]
            body = body_over(self._robot, middle, heading_over(self._robot, middle), _LEVEL, 0.0)
            triangle = np.delete(feet[:, :2], step.leg, axis=0)
            inside = partial(balanced, triangle=triangle, margin=self._margin)
            body = centered(body, self._center, inside)
            yield body, feet
            yield body, step.feet
            feet = step.feet

    def _points(self, bodies: Sequence[BodyPose], feet: Array) -> Array:
        """Place points on shins, the body as high as legs reach from, (n, 4, m, 3) [m]."""
        positions = np.array([body.position for body in bodies])
        rotations = np.array([body.rotation for body in bodies])
        points = self._room.points(positions, rotations, feet)
        for lower in LOWERINGS[1:]:
            missing = np.isnan(points).any(axis=(1, 2, 3))
            if not missing.any():
                break
            lowered = positions[missing] - (0.0, 0.0, self._robot.relative_size * lower)
            points[missing] = self._room.points(lowered, rotations[missing], feet[missing])
        return points
