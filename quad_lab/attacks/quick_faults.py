"""
Small samples of all parts of ``quadwalk bench faults``, beside one another.

Parts that wait for nodes leave the processor to those that compute. Messages to the nodes of a
walk by odometry and the soak share these nodes.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from rich.console import Console

from quad_lab.attacks.parts import Result, attack_of
from quad_lab.tools.workers import worker_pool

if TYPE_CHECKING:
    # Other parts need no ROS.
    from quad_lab.attacks.messages.message_attack import MessageOutcome

_MESSAGES = 'messages'

_ON_SHARED_NODES = (_MESSAGES, 'soak')
"""Parts that share their nodes."""

_TIMED = ('kills', 'stops', 'commands')
"""Of the others, those that measure how soon something happens."""

_NICENESS = 10
"""Of parts that only compute: on a busy machine nodes would say, rightly, that they are late."""

_ALONE = (
    *_TIMED,
    'watch',
    'localisation',
    'files',
    'silence',
    'pauses',
    'late',
    'sensors',
    'gate',
    'execution',
)
"""All others, the longest first."""

_TASKS = 4
"""Tasks at one time: those with nodes wait for half of their time."""


Attack: TypeAlias = 'Callable[[Console], Result | MessageOutcome]'


@dataclass(frozen=True)
class Sample:
    """What came of a part, or of one half of it."""

    part: str
    said: str
    """Progress of the attack, in lines."""
    result: Result | MessageOutcome
    """That of messages is worked out when all have been sent."""


def attack_quickly(console: Console, parts: list[str], seed: int) -> dict[str, Result]:
    """
    Attack with small samples.

    Parameters
    ----------
    console : Console
        Where progress goes.
    parts : list of str
        Parts to run, of :data:`quad_lab.attacks.parts.PARTS`.
    seed : int
        Of what is drawn at random.

    Returns
    -------
    dict of str to tuple
        The bars, and details for JSON, of each part.
    """
    samples: list[Sample] = []
    # In a domain that the user has set, nodes of one task would hear those of another.
    with worker_pool(1 if 'ROS_DOMAIN_ID' in os.environ else _TASKS) as pool:
        running = [pool.submit(task, seed, console.width) for task in _tasks(parts)]
        for ended in as_completed(running):
            for sample in ended.result():
                console.rule(sample.part)
                console.out(sample.said, end='', highlight=False)
                samples.append(sample)
    return {part: _whole([s for s in samples if s.part == part]) for part in parts}


def _tasks(parts: list[str]) -> Iterator[Callable[[int, int], list[Sample]]]:
    """List what is done in a process of its own each, the longest first."""
    shared = [part for part in _ON_SHARED_NODES if part in parts]
    if shared:
        yield partial(_attack_shared_nodes, shared)
    if _MESSAGES in parts:
        yield _attack_camera
    yield from (partial(_attack_alone, part) for part in _ALONE if part in parts)


def _attack_shared_nodes(parts: list[str], seed: int, width: int) -> list[Sample]:
    """Attack the nodes of one walk by odometry in several ways, one after the other."""
    from quad_lab.attacks.messages import message_attack
    from quad_lab.attacks.stage.scenes import QUICK_WALK
    from quad_lab.attacks.walks import soak

    with QUICK_WALK.running() as stage:
        attacks: dict[str, Attack] = {
            _MESSAGES: lambda console: message_attack.attack_scene(
                console, stage, QUICK_WALK, message_attack.QUICK, seed
            ),
            'soak': lambda console: soak.walk_for_long(console, stage, soak.QUICK, seed),
        }
        return [_sample(part, attacks[part], width) for part in parts]


def _attack_camera(seed: int, width: int) -> list[Sample]:
    """Attack the node that perceives, in a walk by the ceiling camera."""
    from quad_lab.attacks.messages import message_attack
    from quad_lab.attacks.stage.scenes import QUICK_CAMERA

    def attack(console: Console) -> MessageOutcome:
        with QUICK_CAMERA.running() as stage:
            return message_attack.attack_scene(
                console, stage, QUICK_CAMERA, message_attack.QUICK, seed
            )

    return [_sample(_MESSAGES, attack, width)]


def _attack_alone(part: str, seed: int, width: int) -> list[Sample]:
    """Run a part that shares nothing."""
    if part not in _TIMED:
        os.nice(_NICENESS)
    return [_sample(part, lambda console: attack_of(part)(console, True, seed), width)]


def _sample(part: str, attack: Attack, width: int) -> Sample:
    """Attack, and keep what is said meanwhile: other tasks say something as well."""
    said = io.StringIO()
    result = attack(Console(file=said, width=width))
    return Sample(part, said.getvalue(), result)


def _whole(samples: list[Sample]) -> Result:
    """Put the samples of one part together."""
    first = samples[0].result
    if isinstance(first, tuple):
        return first
    for sample in samples[1:]:
        assert not isinstance(sample.result, tuple)
        first.add(sample.result)
    return first.result(quick=True)
