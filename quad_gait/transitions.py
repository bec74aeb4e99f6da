"""
The table of transitions: who acts when, what it says, and to whom it hands over.

A new mode is a new file and a row here.
"""

from __future__ import annotations

from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.balanced_trot import BalancedTrot
from quad_gait.behaviours.cycle_walk import CycleWalk
from quad_gait.behaviours.routine import Row
from quad_gait.behaviours.sit import Sit
from quad_gait.behaviours.stand_up import StandUp
from quad_gait.behaviours.standing import Standing
from quad_gait.behaviours.uneven_walk import UnevenWalk
from quad_gait.guards.fallen import Fallen
from quad_gait.guards.frozen import Frozen
from quad_gait.guards.guard import GuardRow
from quad_gait.guards.lame import Lame
from quad_gait.guards.silent import Silent
from quad_gait.guards.unexecuted import Unexecuted

_STANDING = frozenset({Activity.STANDING})

GUARDS = (
    GuardRow(
        Frozen,
        'the emergency stop is on, or was released and the robot not asked to stand',
        frozenset({Activity.EMERGENCY_STOP, Activity.STOPPED, Activity.STANDING}),
    ),
    GuardRow(
        Lame,
        'a joint does not answer',
        frozenset({Activity.LAME, Activity.STANDING}),
    ),
    GuardRow(
        Fallen,
        'the body is tilted too far, or was and the robot not asked to stand',
        frozenset({Activity.FALLEN}),
    ),
    GuardRow(
        Silent,
        'joint states, or an imu that is needed, are missing',
        frozenset({Activity.WAITING}),
    ),
    GuardRow(
        Unexecuted,
        'no joint has followed its trajectories for a while',
        frozenset({Activity.NOT_EXECUTED, Activity.STANDING}),
    ),
)
"""What interrupts, the most urgent first; each is asked until one acts."""

ROUTINE = (
    Row(
        Standing,
        takes=Activity.STANDING,
        says=frozenset(
            {
                Activity.WAITING,
                Activity.STANDING,
                Activity.SITTING,
                Activity.ARRIVED,
                Activity.BLOCKED,
                Activity.STOPPED,
            }
        ),
        hands_over_to=frozenset(
            {
                Activity.STANDING_UP,
                Activity.SITTING_DOWN,
                Activity.WALKING,
                Activity.BALANCING,
            }
        ),
    ),
    Row(
        StandUp,
        takes=Activity.STANDING_UP,
        says=frozenset({Activity.STANDING_UP}),
        hands_over_to=_STANDING,
    ),
    Row(
        Sit,
        takes=Activity.SITTING_DOWN,
        says=frozenset({Activity.SITTING_DOWN}),
        hands_over_to=_STANDING,
    ),
    Row(
        CycleWalk,
        takes=Activity.WALKING,
        says=frozenset(
            {
                Activity.WALKING,
                Activity.TURNING,
                Activity.ARRIVED,
                Activity.BLOCKED,
                Activity.STOPPED,
            }
        ),
        hands_over_to=_STANDING,
        suits=lambda options: options.uneven is None,
    ),
    Row(
        BalancedTrot,
        takes=Activity.BALANCING,
        says=frozenset(
            {
                Activity.BALANCING,
                Activity.WALKING,
                Activity.TURNING,
                Activity.STANDING,
                Activity.WAITING,
                Activity.ARRIVED,
                Activity.BLOCKED,
                Activity.STOPPED,
            }
        ),
        hands_over_to=_STANDING,
        suits=lambda options: options.uneven is None and options.balance is not None,
    ),
    Row(
        UnevenWalk,
        takes=Activity.WALKING,
        says=frozenset({Activity.WALKING, Activity.TURNING, Activity.STOPPED}),
        hands_over_to=_STANDING,
        suits=lambda options: options.uneven is not None,
    ),
)
"""What a sound robot does; it begins with the first."""
