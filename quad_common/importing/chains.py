"""
Which joints of a description are legs.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from quad_common.description.tree import TURNING, KinematicTree, TreeJoint
from quad_common.errors import LegNotFeasible, NotAQuadruped
from quad_common.importing.options import Notes
from quad_common.robot.robot_build import JOINTS_PER_LEG, LEGS

_ALIKE = 0.02
"""Part by which lengths of two legs of one build may differ: left legs are mirrored by hand."""

_NUMBERS = ('no', 'one', 'two', 'three', 'four', 'five', 'six', 'seven', 'eight')


@dataclass(frozen=True)
class LegChain:
    """The three joints of a leg, from the body outward."""

    joints: tuple[TreeJoint, ...]
    """Joints of the leg."""

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links that these joints move."""
        return tuple(joint.child for joint in self.joints)


def find_legs(tree: KinematicTree, notes: Notes) -> list[LegChain]:
    """
    Find the four legs: chains of three turning joints that share none, and nothing moves after.

    Of more than four such chains those count that have their like among them.

    Parameters
    ----------
    tree : KinematicTree
        The description.
    notes : Notes
        What else moves is added to it; it is held where it is at 0.

    Returns
    -------
    list of LegChain
        Four of them, in the description's order.

    Raises
    ------
    NotAQuadruped
        If there are not four, naming what there is.
    LegNotFeasible
        If one of their joints slides.
    """
    chains = [_moving(tree, link) for link in _ends(tree)]
    used = Counter(joint.name for chain in chains for joint in chain)
    apart = [chain for chain in chains if all(used[joint.name] == 1 for joint in chain)]
    legs = [chain for chain in apart if len(chain) == JOINTS_PER_LEG]
    if len(legs) > len(LEGS):
        # An arm or a mast may have three joints too, but nothing on the robot is its like.
        legs = [chain for chain in legs if any(_are_alike(tree, chain, other) for other in legs)]
    if len(legs) != len(LEGS):
        raise NotAQuadruped(tree.path, _what_moves(chains, apart))
    for joint in (joint for leg in legs for joint in leg):
        if joint.kind not in TURNING:
            problem = f"cannot be used: its joint '{joint.name}' is {joint.kind}"
            raise LegNotFeasible(tree.path, joint.name, problem)
    _check_motors(tree, legs)
    others = [chain for chain in chains if chain not in legs]
    _note_others({joint.name: joint for chain in others for joint in chain}, notes)
    return [LegChain(tuple(leg)) for leg in legs]


def _check_motors(tree: KinematicTree, legs: list[list[TreeJoint]]) -> None:
    """Refuse legs with a joint that follows another: a gait moves each joint for itself."""
    for leg in legs:
        followers = [joint for joint in leg if joint.follows]
        if followers:
            joint, driven = followers[0], JOINTS_PER_LEG - len(followers)
            problem = (
                f"cannot be used: its joint '{joint.name}' follows '{joint.follows}' (mimic), and "
                f'{f"only {_word(driven)}" if driven else "none"} of its joints '
                f'{"has a motor" if driven == 1 else "have motors"}'
            )
            raise LegNotFeasible(tree.path, leg[0].name, problem)


def _note_others(others: dict[str, TreeJoint], notes: Notes) -> None:
    """Say which joints are held, by their names; joints that follow others, too."""
    if not others:
        return
    names = ', '.join(sorted(others)[:4]) + (' ...' if len(others) > 4 else '')
    notes.assume(
        f'{len(others)} other {"joint is" if len(others) == 1 else "joints are"} held at 0 '
        f'({names})'
    )
    followers = sorted(name for name, joint in others.items() if joint.follows)
    if followers:
        said = [f"'{name}' follows '{others[name].follows}'" for name in followers[:2]]
        notes.assume(
            'joints that follow others (mimic) are held at 0, too '
            f'({", ".join(said)}{" ..." if len(followers) > 2 else ""})'
        )


def _are_alike(tree: KinematicTree, chain: list[TreeJoint], other: list[TreeJoint]) -> bool:
    """Return whether two chains have joints at the same distances from one another."""
    if chain is other:
        return False
    lengths, others = (
        np.linalg.norm(np.diff([tree.pose(joint.child)[:3, 3] for joint in own], axis=0), axis=1)
        for own in (chain, other)
    )
    return bool(np.allclose(lengths, others, rtol=_ALIKE, atol=_ALIKE * lengths.max()))


def _ends(tree: KinematicTree) -> list[str]:
    """List the links that a joint moves, and after which nothing moves."""
    return [
        link
        for link, joint in tree.parents.items()
        if joint.moves
        and not any(
            after.moves for member in tree.rigid_group(link) for after in tree.children[member]
        )
    ]


def _moving(tree: KinematicTree, link: str) -> list[TreeJoint]:
    # A base that floats in its description does so here anyway.
    return [j for j in tree.chain(link) if j.moves and j.kind not in ('floating', 'planar')]


def _what_moves(chains: list[list[TreeJoint]], apart: list[list[TreeJoint]]) -> str:
    """Describe chains of moving joints in words."""
    if not chains:
        return 'no joint that moves'
    lengths = Counter(len(chain) for chain in apart)
    parts = [
        f'{_word(count)} chain{"s" if count > 1 else ""} of {_word(length)} joint'
        f'{"s" if length > 1 else ""}'
        for length, count in sorted(lengths.items(), key=lambda item: -item[0])
    ]
    shared = len(chains) - len(apart)
    if shared:
        parts.append(f'{_word(shared)} that share joints')
    if lengths.get(4, 0) == len(LEGS) and all(
        c[-1].kind == 'continuous' for c in apart if len(c) == 4
    ):
        parts.append('the last joints turn without end, as wheels do')
    return ', '.join(parts)


def _word(number: int) -> str:
    return _NUMBERS[number] if number < len(_NUMBERS) else str(number)
