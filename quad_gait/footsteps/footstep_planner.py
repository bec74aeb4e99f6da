"""
Plans footsteps from where the feet stand to where the body is to be.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import FootstepsNotFound
from quad_common.footing.leg_room import LegRoom
from quad_common.footing.postures import LOWERINGS
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.footsteps.foothold_map import FootholdMap
from quad_gait.footsteps.footstep_options import FootstepOptions
from quad_gait.footsteps.footstep_search import search
from quad_gait.footsteps.search_values import Body, Goal, Lattice, make_tree
from quad_gait.state.body_placement import body_over, heading_over

Array = NDArray[np.float64]

_NODES = 1 << 19
"""Number of stances that are remembered in a search."""

_TOLERANCE = 0.1
"""Fraction of the distance to a target within which footsteps may end beside it."""

_LEVEL = np.zeros(2)


@dataclass(frozen=True)
class Footstep:
    """One foot goes somewhere."""

    leg: int
    """Index of the leg."""
    foothold: Array
    """Center of the foot where it is to stand, shape (3,) [m]."""
    feet: Array
    """Centers of all feet then, shape (4, 3) [m]."""


@dataclass(frozen=True)
class FootstepPlan:
    """Steps one after the other, and what they cost."""

    steps: tuple[Footstep, ...]
    """The steps; none where the robot is there."""
    cost: float
    """Number of steps, and some more for legs far from their initial posture and for turns."""
    expansions: int
    """Number of stances from which steps were looked for."""
    is_best: bool
    """Whether no path over this lattice costs less."""


class FootstepPlanner:
    """
    Plans footsteps; it remembers nothing but the robot.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : FootstepOptions
        How.
    """

    def __init__(self, robot: Robot, options: FootstepOptions) -> None:
        self._robot = robot
        self._options = options

    def plan(
        self, feet: Array, target: Pose2D, ground: FootholdMap, shift: float = 0.0
    ) -> FootstepPlan:
        """
        Plan footsteps.

        Parameters
        ----------
        feet : ndarray, shape (4, 3)
            Centers of the feet, which stand [m].
        target : Pose2D
            Where the body is to be over them.
        ground : FootholdMap
            Where feet may stand.
        shift : float
            Height that is added to the map's, so that it fits the feet [m].

        Returns
        -------
        FootstepPlan

        Raises
        ------
        FootstepsNotFound
            If the search finds none.
        """
        robot, aside = self._robot, self._robot.relative_size * self._options.aside
        there = target.transform(robot.neutral_feet)[:, :2]
        both = np.concatenate([feet[:, :2], there])
        low, high = both.min(axis=0) - aside, both.max(axis=0) + aside
        lattice = ground.lattice(low, high, target.yaw, feet, shift)
        return self.plan_over(lattice, target)

    def plan_over(self, lattice: Lattice, target: Pose2D) -> FootstepPlan:
        """Plan footsteps over a lattice, whose last four places are the feet; as :meth:`plan`."""
        try:
            return self._planned(lattice, target, self._body)
        except FootstepsNotFound:
            least = self._robot.relative_size * self._options.least_margin
            if least >= self._body.margin:
                raise
            return self._planned(lattice, target, self._body._replace(margin=least))

    def _planned(self, lattice: Lattice, target: Pose2D, body: Body) -> FootstepPlan:
        options, scale = self._options, self._robot.relative_size
        middle = lattice.places[-4:, :2].mean(axis=0)
        distance = math.hypot(*(middle - (target.x, target.y)))
        near, far = options.distance_tolerance, options.far_tolerance
        goal = Goal(
            target.x,
            target.y,
            target.yaw,
            min(max(_TOLERANCE * distance, scale * near), scale * far),
            options.angle_tolerance,
            options.weight,
            options.strain,
        )
        tree = make_tree(_NODES, len(lattice.places) - 4)
        end = -1
        while end < 0 and tree.state[2] < options.most_expansions:
            before = int(tree.state[2])
            end = search(lattice, body, goal, tree, options.expansions)
            if tree.state[2] == before:
                break
        if end < 0:
            raise FootstepsNotFound(distance, int(tree.state[2]))
        end = search(lattice, body, goal, tree, options.expansions)
        steps: list[Footstep] = []
        node = end
        while tree.parents[node] >= 0:
            cells, before_cells = tree.cells[node], tree.cells[tree.parents[node]]
            leg = int(np.flatnonzero(cells != before_cells)[0])
            at = lattice.places[cells]
            steps.append(Footstep(leg, at[leg], at))
            node = int(tree.parents[node])
        is_best = bool(tree.state[1] == 0)
        return FootstepPlan(
            tuple(reversed(steps)), float(tree.costs[end]), int(tree.state[2]), is_best
        )

    @cached_property
    def _body(self) -> Body:
        robot, options, scale = self._robot, self._options, self._robot.relative_size
        room = LegRoom.of(robot)
        arms = robot.neutral_feet[:, None, :2] - robot.neutral_feet[None, :, :2]
        apart = np.hypot(arms[..., 0], arms[..., 1])
        center = robot.center_of_mass(robot.initial_joint_angles)
        return Body(
            room.neutral,
            room.lowest,
            room.highest,
            room.side,
            scale * np.array(LOWERINGS),
            float(center[0]),
            float(center[1]),
            scale * options.longest_step,
            scale * options.margin,
            options.separation * float(apart[apart > 0.0].min()),
            options.breadth * float(arms[[0, 2], [1, 3], 1].min()),
        )


def pose_over(robot: Robot, feet: Array) -> Pose2D:
    """Return the pose of a level body over feet, shape (4, 3) [m]."""
    body = body_over(robot, feet, heading_over(robot, feet), _LEVEL, 0.0)
    return Pose2D(float(body.position[0]), float(body.position[1]), body.yaw)
