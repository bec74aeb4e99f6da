"""
Plans footsteps from where the feet stand to where the body is to be.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import FootstepsNotFound
from quad_common.footing.leg_room import LegRoom
from quad_common.footing.postures import LOWERINGS
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.footsteps.foothold_map import Foothold, FootholdMap
from quad_gait.footsteps.footstep import Footstep, FootstepPlan
from quad_gait.footsteps.footstep_options import FootstepOptions
from quad_gait.footsteps.footstep_search import search
from quad_gait.footsteps.pieces import Pieces, whole
from quad_gait.footsteps.search_values import Body, Goal, Lattice, Tree, make_tree
from quad_gait.footsteps.shin_check import ShinCheck
from quad_gait.state.body_placement import body_over, heading_over

Array = NDArray[np.float64]

_NODES = 1 << 19
"""Number of stances that are remembered in a search."""

_TOLERANCE = 0.1
"""Fraction of the distance to a target within which footsteps may end beside it."""

_MOST_PLANS = 3
"""Number of plans that are made until there is one over which no shin touches the ground."""

_PIECE = 100
"""Number of stances from which steps are looked for at once."""

_STRIDE = 3
"""Number of steps of a stride after its first one."""

_LEVEL = np.zeros(2)


class _Task(NamedTuple):
    """What a plan is asked for: the parameters of :meth:`FootstepPlanner.plan`."""

    feet: Array
    target: Pose2D
    ground: FootholdMap
    shift: float


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
            Of a few plans the first one over whose first half no shin touches the ground, or the
            one over which the fewest do. The rest is for the caller to look at, or plan again.

        Raises
        ------
        FootstepsNotFound
            If the search finds none.
        """
        return whole(self.planning(feet, target, ground, shift))

    def planning(
        self, feet: Array, target: Pose2D, ground: FootholdMap, shift: float = 0.0
    ) -> Pieces[FootstepPlan]:
        """Plan as :meth:`plan` does, in pieces that take milliseconds each."""
        task = _Task(feet, target, ground, shift)
        options = self._options
        most = [options.coarse_expansions] * (len(options.blocks) - 1) + [options.most_expansions]
        plans: list[tuple[int, FootstepPlan]] = []
        problem: FootstepsNotFound | None = None
        for block, expansions in zip(options.blocks, most):
            try:
                # Over small squares a search takes long: one will do where there is a plan already.
                most_plans = 1 if plans else _MOST_PLANS
                plans.append((yield from self._freest(task, block, expansions, most_plans)))
            except FootstepsNotFound as error:
                problem = error
                continue
            if plans[-1][0] == 0:
                break
        if not plans:
            assert problem is not None
            raise problem
        return min(plans, key=lambda each: each[0])[1]

    def touching(
        self, feet: Array, steps: Sequence[Footstep], ground: FootholdMap, shift: float
    ) -> list[Foothold]:
        """Return the footholds of steps beside which a shin would touch the ground."""
        margin, clearance = self._body.margin, ground.shin_clearance
        check = ShinCheck(self._robot, margin, clearance, ground.heights, shift)
        return check.touching(feet, steps)

    def _freest(
        self, task: _Task, block: int, expansions: int, most_plans: int
    ) -> Pieces[tuple[int, FootstepPlan]]:
        """Return the plan over which the fewest shins touch the ground, and how many do."""
        feet, target, ground, shift = task
        robot, aside = self._robot, self._robot.relative_size * self._options.aside
        there = target.transform(robot.neutral_feet)[:, :2]
        both = np.concatenate([feet[:, :2], there])
        part = both.min(axis=0) - aside, both.max(axis=0) + aside
        touching: list[Foothold] = []
        plans: list[tuple[int, FootstepPlan]] = []
        for _ in range(most_plans):
            lattice = ground.lattice(part, target.yaw, feet, shift, block, touching)
            yield
            try:
                planned = yield from self._planning_over(lattice, target, expansions)
            except FootstepsNotFound:
                if not plans:
                    raise
                break
            steps = planned.steps
            found = self.touching(feet, steps[: steps_walked(len(steps))], ground, shift)
            plans.append((len(found), planned))
            yield
            if not found:
                break
            touching += found
        return min(plans, key=lambda each: each[0])

    def plan_over(
        self, lattice: Lattice, target: Pose2D, expansions: int | None = None
    ) -> FootstepPlan:
        """
        Plan footsteps over a lattice, whose last four places are the feet; as :meth:`plan`.

        From so many stances steps are looked for before there is none, as the options say if not
        given. Where none have all the margin, some with less will do.
        """
        most = self._options.most_expansions if expansions is None else expansions
        return whole(self._planning_over(lattice, target, most))

    def _planning_over(self, lattice: Lattice, target: Pose2D, most: int) -> Pieces[FootstepPlan]:
        try:
            return (yield from self._planned(lattice, target, self._body, most))
        except FootstepsNotFound:
            least = self._robot.relative_size * self._options.least_margin
            if least >= self._body.margin:
                raise
            body = self._body._replace(margin=least)
            return (yield from self._planned(lattice, target, body, most))

    def _planned(
        self, lattice: Lattice, target: Pose2D, body: Body, most: int
    ) -> Pieces[FootstepPlan]:
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
        while end < 0 and tree.state[2] < most:
            before = int(tree.state[2])
            end = yield from self._searched_on(lattice, body, goal, tree)
            if tree.state[2] == before:
                break
        if end < 0:
            raise FootstepsNotFound(distance, int(tree.state[2]))
        end = yield from self._searched_on(lattice, body, goal, tree)
        steps: list[Footstep] = []
        node = end
        while tree.parents[node] >= 0:
            cells, before_cells = tree.cells[node], tree.cells[tree.parents[node]]
            leg = int(np.flatnonzero(cells != before_cells)[0])
            at = lattice.places[cells]
            steps.append(Footstep(leg, at[leg], at))
            node = int(tree.parents[node])
        count = int(tree.state[2])
        return FootstepPlan(
            tuple(reversed(steps)), float(tree.costs[end]), count, tree.is_exhausted
        )

    def _searched_on(self, lattice: Lattice, body: Body, goal: Goal, tree: Tree) -> Pieces[int]:
        """Search on from as many stances as the options say; return as :func:`search` does."""
        end = -1
        for done in range(0, self._options.expansions, _PIECE):
            end = search(lattice, body, goal, tree, min(_PIECE, self._options.expansions - done))
            yield
            if tree.is_exhausted:
                break
        return end

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


def steps_walked(count: int) -> int:
    """Return how many steps of so many are walked at most before the next ones are planned."""
    return (count + 1) // 2 + _STRIDE


def pose_over(robot: Robot, feet: Array) -> Pose2D:
    """Return the pose of a level body over feet, shape (4, 3) [m]."""
    body = body_over(robot, feet, heading_over(robot, feet), _LEVEL, 0.0)
    return Pose2D(float(body.position[0]), float(body.position[1]), body.yaw)
