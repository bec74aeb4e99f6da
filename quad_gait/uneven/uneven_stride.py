"""
One gait cycle over ground that is not flat: a swing at a time, ended by what the foot meets.

On flat ground a whole cycle is planned ahead. Here each swing is planned when it begins,
from where the feet really stand: the body goes over the three others, level if the legs
reach, the foot is lifted over what is in its way and lowered until it bears load. It may
meet the ground early, or later than expected: the cycle goes on from there.
"""

from __future__ import annotations

import enum
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import FootholdNotFound, GaitError
from quad_common.maps.height_map import HeightMap
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.state.stance import Stance
from quad_gait.uneven.felt_ground import FeltGround
from quad_gait.uneven.foot_contact import Touch, loaded_legs, may_stand, unloaded_legs
from quad_gait.uneven.ground_model import GroundModel
from quad_gait.uneven.joint_motion import MotionOutput
from quad_gait.uneven.lowered_feet import LoweredFeet
from quad_gait.uneven.stride_goal import LegOrder, StrideGoal
from quad_gait.uneven.swing_course import PlannedSwing
from quad_gait.uneven.swing_planner import BIT, SwingPlanner
from quad_gait.uneven.uneven_options import UnevenOptions

Array = NDArray[np.float64]

_MOST_SEARCHES = 3
"""Searches for the ground before a foot is lifted all the same: the swing may free the others."""


_MOST_CATCHES = 4
"""Number of slips in a stride at which feet are put down."""


_MOST_RAISES = 2
"""Number of times that a foot is lifted over what it meets on its way."""


class _Phase(enum.Enum):
    SEEKING = 'seeking'
    SWINGING = 'swinging'
    FINISHING = 'finishing'
    OVER = 'over'


class UnevenStride:
    """
    Carries one step of the body out, leg by leg.

    Parameters
    ----------
    robot : Robot
        The robot.
    swing_height : float
        Of the gait on even ground [m].
    goal : StrideGoal
        Where it leads.
    height_map : HeightMap, optional
        Of the ground, in the plan's frame; without one the feet feel for the ground.
    options : UnevenOptions
        How.
    felt : FeltGround, optional
        What feet have met so far; nothing if not given.
    """

    def __init__(
        self,
        robot: Robot,
        swing_height: float,
        goal: StrideGoal,
        height_map: HeightMap | None,
        options: UnevenOptions,
        felt: FeltGround | None = None,
    ) -> None:
        self._robot, self._options = robot, options
        self._felt = felt or FeltGround(robot)
        self._planner = SwingPlanner(robot, options, swing_height)
        self._goal, self._order = goal, LegOrder(goal.order)
        self.height_map = height_map
        self._phase, self._touch = _Phase.SEEKING, Touch(robot, options)
        self._lowered, self._has_lowered = LoweredFeet(robot, options), False
        self._searches = self._catches = self._raises = 0
        self._return_to: Array | None = None
        self._swinging: PlannedSwing | None = None
        self._stood: Stance | None = None
        self._output = MotionOutput(options.reaction_time)
        self.is_over = False
        """Whether all legs have swung and the body is where it was to go."""
        self.end = -np.inf
        """Time at which what was planned last is done [s]."""
        self.limit = ''
        """What kept a leg from getting as far as it was to; empty if nothing did."""
        self.stuck: int | None = None
        """Index of the leg for which no swing was found, so that the stride was cut short."""

    @property
    def leg(self) -> int:
        """Index of the leg that swings, or is next."""
        return self._order.leg

    @property
    def joint_positions(self) -> Array | None:
        """Where the joints are commanded to end, shape (4, 3) [rad]; None before they move."""
        return self._output.last

    @property
    def footholds(self) -> Array:
        """Where the feet would stand after it on even ground, shape (4, 3) [m]; z by the map."""
        return self._goal.footholds_on(self.height_map)

    @property
    def in_contact(self) -> NDArray[np.bool_]:
        """Which feet stand, by what was measured last, shape (4,)."""
        standing, swing = np.ones(len(LEGS), dtype=bool), self._swinging
        if self._phase is _Phase.SWINGING and swing is not None:
            is_lifted = self._output.has_reached(swing.lifted_at)
            standing[self.leg] = not is_lifted and self._return_to is None
        return standing

    def update(self, now: Stance) -> JointTrajectory | None:
        """
        Take a measurement; plan on if a foot has met the ground, or a motion is over.

        Parameters
        ----------
        now : Stance
            The robot as it stands.

        Returns
        -------
        JointTrajectory or None
            What replaces the last one, if anything does.

        Raises
        ------
        GaitError
            If the legs do not reach, or a foot finds no ground.
        """
        trajectory = self._decide(now)
        self.is_over, self.end = self._phase is _Phase.OVER, self._output.end
        return trajectory

    def _decide(self, now: Stance) -> JointTrajectory | None:
        if self._phase is _Phase.OVER:
            return None
        again = self._output.follow(now.time, now.joint_positions)
        if again is not None and not self._is_held(now):
            return self._output.give(again)
        if self._phase is _Phase.SEEKING:
            return self._seek(now)
        if self._phase is _Phase.FINISHING:
            if self._output.is_done:
                self._phase = _Phase.OVER
            return None
        swing = self._swinging
        assert swing is not None
        self._output.forget_way_before(swing.lifted_at)
        if self._is_slipping(now, swing):
            with suppress(GaitError):
                return self._catch(now)
        return self._feel(now, swing)

    def _is_held(self, now: Stance) -> bool:
        """Tell whether a foot that is to be in the air bears load: it has met something."""
        swing, legs = self._swinging, self._lowered.legs
        if self._phase is not _Phase.SEEKING:
            # Before it may feel, it may well bear load: what lifts it has not come to the joints.
            may_feel = swing is not None and self._output.has_reached(swing.feels_from)
            legs = [self.leg] if may_feel and self._phase is _Phase.SWINGING else []
        return not set(legs).isdisjoint(loaded_legs(self._robot, now, self._options))

    def _is_slipping(self, now: Stance, swing: PlannedSwing) -> bool:
        """Tell whether one of the three feet that stand slides off what it stood on."""
        # Without a map feet stand on edges, and find ground below: the foot in the air goes on.
        if self.height_map is None or not self._output.has_reached(swing.lifted_at):
            return False
        slips = self._catches < _MOST_CATCHES and self._felt.is_slipping(now, self.leg)
        # Loads last: to find them takes longer than all the rest of a measurement.
        return slips and now.loads is not None

    def _catch(self, now: Stance) -> JointTrajectory:
        """Lower all feet that bear nothing at once: on two of them a robot tips over."""
        self._catches += 1
        legs = sorted({self.leg, *unloaded_legs(self._robot, now, self._options)})
        search = self._search(now, legs, quickly=True)
        self._return_to = None
        self.limit = f'a foot has slipped, so {LEGS[self.leg]} is put down again'
        return search

    def _search(self, now: Stance, legs: list[int], quickly: bool = False) -> JointTrajectory:
        """Begin to lower feet."""
        search = self._planner.search(now, self._output.commanded, legs, quickly)
        self._lowered.begin(legs)
        self._phase = _Phase.SEEKING
        return self._output.give(search)

    def _feel(self, now: Stance, swing: PlannedSwing) -> JointTrajectory | None:
        """Go on when the foot that swings has met the ground, or should have."""
        motion, leg = self._output.motion, self.leg
        assert motion is not None
        if motion.given < swing.given:
            return self._lift(now, swing.given - motion.given)
        if motion.done < swing.feels_from:
            return None
        is_felt, met = self._touch.look(now, leg)
        if met is not None:
            is_new = self._return_to is None
            is_wall = is_new and not may_stand(self._robot, met, leg)
            if not is_wall:
                self._felt.note_contact(leg, met, self.height_map)
            if is_new and self._raises < _MOST_RAISES and motion.done < swing.falls_from:
                with suppress(GaitError):
                    return self._over(now)
            if is_wall:
                with suppress(GaitError):
                    return self._go_back(now)
                self._felt.note_contact(leg, met, self.height_map)
            return self._land(met)
        if not is_felt and not motion.is_done:
            return self._output.go_on(now.time, BIT)
        if not is_felt and now.loads is None:
            return self._land(now)
        if is_felt or now.time < motion.end + self._options.reaction_time:
            return None
        if self._return_to is not None:
            raise FootholdNotFound(LEGS[leg], swing.depth)
        if not self._has_lowered:
            self._has_lowered = True
            with suppress(GaitError):
                deeper = self._planner.search_deeper(now, self._output.commanded, leg, swing.depth)
                return self._begin(deeper)
        # No ground here.
        self._felt.note_gap(leg, now, self.height_map)
        return self._go_back(now)

    def _go_back(self, now: Stance) -> JointTrajectory:
        """Take a foot back to where it stood, or as it came where joints get nowhere else."""
        assert self._stood is not None
        self._return_to = self._stood.place_in(now, self.leg)
        try:
            return self._swing(now)
        except GaitError:
            if len(self._output.way) < 2:
                raise
        return self._begin(self._planner.way_back(now, self._output.way))

    def _over(self, now: Stance) -> JointTrajectory:
        """Lift a foot over what it has met on its way: beside an edge it bears next to nothing."""
        self._raises += 1
        self._has_lowered = False
        self._touch.forget()
        ground = self._felt.under(now, self.height_map, self.leg)
        swing = self._planned(now, ground, self.leg, stands=False)
        return self._begin(replace(swing, lifted_at=0))

    def _lift(self, now: Stance, samples: int) -> JointTrajectory | None:
        """
        Have a foot lifted once the three others are seen to stand; lower those that do not.

        Where a contact was noticed late, after a pause of the machine for example, that foot stands
        deeper than is known and the one across from it is in the air: on two feet a robot falls.
        """
        lifting = self._output.more(now.time, samples)
        if lifting is None:
            return None
        hanging = [k for k in unloaded_legs(self._robot, now, self._options) if k != self.leg]
        if hanging and self._searches < _MOST_SEARCHES:
            self._searches += 1
            # Where the legs have no room for it the foot is lifted all the same.
            with suppress(GaitError):
                return self._search(now, hanging)
        return self._output.give(lifting)

    def _seek(self, now: Stance) -> JointTrajectory | None:
        """Lower feet that bear nothing until all four stand."""
        lowered, is_quick = self._lowered, self._catches > 0
        is_moving = self._output.motion is not None
        if is_moving and not lowered.look(now, self._output.is_done, is_quick):
            return self._output.go_on(now.time, BIT)
        hanging = lowered.next_legs(now)
        if hanging and (lowering := self._lower(now, hanging)) is not None:
            return lowering
        if not self._goal.is_exact and not self._order.hangs:
            self._order.bring_hanging(lowered.in_vain)
        self._felt.note_stance(now)
        self._phase = _Phase.SWINGING
        return self._swing(now)

    def _lower(self, now: Stance, hanging: list[int]) -> JointTrajectory | None:
        """Begin to lower feet, all or one; None where a single one hangs, which swings first."""
        try:
            search, legs = self._planner.search_some(now, self._output.commanded, hanging)
        except GaitError:
            # A stretched leg gets no farther down. No other may be lifted while its foot hangs.
            if self._goal.is_exact or not self._order.bring_hanging(hanging):
                raise
            return None
        self._lowered.go_on(legs)
        return self._output.give(search)

    def _land(self, now: Stance) -> JointTrajectory:
        """Go on with the next leg, or bring the body to its place."""
        self._return_to, self._searches, self._raises = None, 0, 0
        return self._swing(now) if self._order.advance() else self._finish(now)

    def _finish(self, now: Stance) -> JointTrajectory:
        """Bring the body to its place; feet that have not swung stay where they are."""
        self._phase = _Phase.FINISHING
        self._order.end()
        ground, place = self._felt.under(now, self.height_map), self._goal.place
        return self._output.give(self._planner.shift(now, self._output.commanded, ground, place))

    def _swing(self, now: Stance) -> JointTrajectory:
        """Swing the leg that is next, or take it back to where it stood."""
        leg, back_to = self.leg, self._return_to
        ground = self._felt.under(now, self.height_map, leg if back_to is not None else None)
        if back_to is not None:
            swing = self._planner.swing_back(now, self._output.commanded, ground, leg, back_to)
        else:
            try:
                swing, problem = self._order.choose(
                    lambda leg: self._planned(now, ground, leg, True), self._goal.is_exact
                )
            except GaitError as error:
                if self._order.hangs or not self._order.has_begun:
                    raise
                # Some feet are farther on: the body follows them as far as the others allow.
                self.stuck = leg
                self.limit = self.limit or f'a foot stays where it is: {error}'
                return self._finish(now)
            if problem is not None:
                self.limit = self.limit or f'another foot goes first: {problem}'
        self.limit = self.limit or swing.limit
        self._stood, self._has_lowered = now, False
        self._touch.forget()
        return self._begin(swing)

    def _planned(self, now: Stance, ground: GroundModel, leg: int, stands: bool) -> PlannedSwing:
        """Plan a swing, just onto its foothold or near to it."""
        plan = self._planner.swing_onto if self._goal.is_exact else self._planner.swing
        return plan(now, self._output.commanded, ground, leg, self._goal.footholds[leg], stands)

    def _begin(self, swing: PlannedSwing) -> JointTrajectory:
        self._swinging = swing
        return self._output.give(swing.motion)
