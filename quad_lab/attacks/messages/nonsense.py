"""
Messages that can have no meaning: each has to be refused, and said to be.

Every one breaks a range that is stated on the message's page, or no robot and no room can be
so. What is merely unwise is not here: the attack by mutations sends that too, but a node may
take it.
"""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass

import numpy as np

from quad_lab.attacks.messages.attacker import Attacker
from quad_lab.attacks.messages.mutations import Path, replaced
from quad_lab.attacks.stage.graph import Interface
from quad_lab.attacks.stage.stage import Stage

_TRIES = 10
"""A message is sent so often before it counts as accepted: what is best effort may be lost."""

_AGAIN = 0.05
"""Between two times [s]."""

_WORDS_LAST = 1.5
"""A sentence stays on diagnostics no longer, unless it is still true [s]."""

_RECENT = 3
"""Sentences that may still come in from the case before."""

_WORDS = {
    '/goal_pose': ('goal',),
    '/plan/impassable': ('pose without footing',),
    '/odom': ('odom', 'stamp'),
    '/map': ('map',),
    '/height_map': ('height map',),
    '/plan': ('plan',),
    '/cmd_vel': ('cmd_vel',),
    '/joint_states': ('joint',),
    '/imu': ('imu',),
    '/joint_trajectory': ('trajectory', 'joint'),
    '/obstacles': ('obstacle',),
    '/goal_marker': ('goal_marker',),
    '/push': ('push',),
    '/ceiling_camera/camera_info': ('camera_info', 'camera'),
    '/ceiling_camera/image_raw': ('image',),
    '/odom/legs': ('odom', 'stamp'),
}
"""A refusal names what it refuses, in one of these words."""


@dataclass(frozen=True)
class Nonsense:
    """A message that must be refused."""

    node: str
    topic: str
    path: Path
    """The field that is changed."""
    value: object
    """What it is changed to."""
    reason: str
    """Why it makes no sense."""

    def __str__(self) -> str:
        field = '.'.join(map(str, self.path))
        value = str(self.value)
        return f'{self.node}: {self.topic} {field} = {value[:40]} ({self.reason})'


_NO_NUMBER = 'a pose is made of numbers'
_NO_ROTATION = 'a quaternion has length 1'
_NO_PLACE = 'nothing is so far away'
_NO_FRAME = 'nobody knows that frame'
_X = ('position', 'x')
_W = ('orientation', 'w')
_FRAME = ('header', 'frame_id')
_FORCE = ('wrench', 'force')


def _poses(node: str, topic: str, *pose: str | int) -> tuple[Nonsense, ...]:
    """List what no pose can be."""
    return (
        Nonsense(node, topic, (*pose, *_X), math.nan, _NO_NUMBER),
        Nonsense(node, topic, (*pose, *_X), -math.inf, _NO_NUMBER),
        Nonsense(node, topic, (*pose, *_W), math.nan, _NO_NUMBER),
        Nonsense(node, topic, (*pose, *_W), 1e308, _NO_ROTATION),
        Nonsense(node, topic, (*pose, *_W), 1.4e154, _NO_ROTATION),
        Nonsense(node, topic, (*pose, *_W), 2.0, _NO_ROTATION),
        Nonsense(node, topic, (*pose, *_X), 1e308, _NO_PLACE),
    )


_CAMERA = 'ceiling_camera_node'
_INFO = '/ceiling_camera/camera_info'
_PICTURE = '/ceiling_camera/image_raw'

_FIRST = ('points', 0, 'positions', 0)
_SPEED = ('points', 0, 'velocities', 0)

CASES = (
    *_poses('planner_node', '/goal_pose', 'pose'),
    Nonsense('planner_node', '/goal_pose', _FRAME, 'moon', _NO_FRAME),
    *_poses('planner_node', '/plan/impassable', 'pose'),
    *_poses('planner_node', '/odom', 'pose', 'pose'),
    Nonsense('planner_node', '/map', ('info', 'resolution'), math.nan, 'cells have a size'),
    Nonsense('planner_node', '/map', ('info', 'resolution'), 0.0, 'cells have a size'),
    Nonsense('planner_node', '/map', ('info', 'resolution'), -0.05, 'cells have a size'),
    Nonsense('planner_node', '/map', ('info', 'resolution'), 1e30, 'no room has such cells'),
    Nonsense('planner_node', '/map', ('info', 'width'), 2**31, 'there are not so many cells'),
    Nonsense('planner_node', '/map', ('info', 'height'), 0, 'there are cells'),
    Nonsense('planner_node', '/map', ('info', 'origin', *_X), math.nan, _NO_NUMBER),
    Nonsense('planner_node', '/map', ('info', 'origin', *_W), 1e308, _NO_ROTATION),
    Nonsense('planner_node', '/map', ('info', 'origin', *_X), 1e300, _NO_PLACE),
    Nonsense('planner_node', '/map', ('data', 0), 120, 'an occupancy is 100 at most'),
    Nonsense('planner_node', '/height_map', _FRAME, 'moon', _NO_FRAME),
    Nonsense('gait_node', '/plan', _FRAME, 'moon', _NO_FRAME),
    *_poses('gait_node', '/plan', 'poses', 0, 'pose'),
    *_poses('gait_node', '/odom', 'pose', 'pose'),
    Nonsense('gait_node', '/odom', ('header', 'stamp', 'sec'), -1, 'no time is before zero'),
    Nonsense('gait_node', '/cmd_vel', ('linear', 'x'), math.nan, 'a speed is a number'),
    Nonsense('gait_node', '/cmd_vel', ('angular', 'z'), math.inf, 'a speed is a number'),
    Nonsense('gait_node', '/cmd_vel', ('linear', 'z'), 1.0, 'a robot on legs does not rise'),
    Nonsense('gait_node', '/joint_states', ('position', 0), math.nan, 'an angle is a number'),
    Nonsense('gait_node', '/joint_states', ('position', 0), 1e308, 'no joint turns so far'),
    Nonsense('gait_node', '/joint_states', ('position', 0), 7.85, 'the joint ends at 1.4 rad'),
    Nonsense('gait_node', '/joint_states', ('velocity', 0), math.inf, 'a speed is a number'),
    Nonsense('gait_node', '/joint_states', ('effort', 0), math.nan, 'a torque is a number'),
    Nonsense('gait_node', '/joint_states', ('name', 0), 'wheel', 'a joint of the robot is missing'),
    Nonsense('gait_node', '/joint_states', ('name',), [], 'there are more angles than names'),
    Nonsense('gait_node', '/imu', ('orientation', 'x'), math.nan, _NO_NUMBER),
    Nonsense('gait_node', '/imu', _W, 1e308, _NO_ROTATION),
    Nonsense('gait_node', '/imu', ('angular_velocity', 'z'), math.nan, 'a rate is a number'),
    Nonsense('sim_node', '/joint_trajectory', _FIRST, math.nan, 'an angle is a number'),
    Nonsense('sim_node', '/joint_trajectory', _FIRST, 1e308, 'no joint turns so far'),
    Nonsense('sim_node', '/joint_trajectory', _FIRST, 7.85, 'the joint ends at 1.4 rad'),
    Nonsense('sim_node', '/joint_trajectory', _SPEED, math.inf, 'a speed is a number'),
    Nonsense('sim_node', '/joint_trajectory', _SPEED, 1e3, 'the joint has 6 rad/s'),
    Nonsense('sim_node', '/joint_trajectory', ('points',), [], 'it leads nowhere'),
    Nonsense('sim_node', '/joint_trajectory', ('joint_names', 0), 'wheel', 'no such joint'),
    Nonsense('sim_node', '/joint_trajectory', ('joint_names',), ['a'], 'joints are missing'),
    Nonsense(
        'sim_node', '/joint_trajectory', ('points', -1, 'time_from_start', 'sec'), -5,
        'times rise',
    ),
    Nonsense('sim_node', '/obstacles', ('markers', 0, 'type'), 99, 'no obstacle has that shape'),
    Nonsense('sim_node', '/obstacles', ('markers', 0, 'action'), 99, 'there is no such action'),
    Nonsense('sim_node', '/obstacles', ('markers', 0, 'scale', 'x'), -1.0, 'sizes are positive'),
    Nonsense('sim_node', '/obstacles', ('markers', 0, 'scale', 'x'), 1e308, 'no room holds it'),
    Nonsense('sim_node', '/obstacles', ('markers', 0, 'scale', 'y'), math.nan, 'sizes are numbers'),
    Nonsense('sim_node', '/obstacles', ('markers', 0, *_FRAME), 'moon', _NO_FRAME),
    *_poses('sim_node', '/obstacles', 'markers', 0, 'pose'),
    Nonsense('sim_node', '/goal_marker', _FRAME, 'moon', _NO_FRAME),
    *_poses('sim_node', '/goal_marker', 'pose'),
    Nonsense('sim_node', '/push', _FRAME, 'moon', _NO_FRAME),
    Nonsense('sim_node', '/push', (*_FORCE, 'x'), math.nan, 'a force is a number'),
    Nonsense('sim_node', '/push', (*_FORCE, 'y'), -1e6, 'nobody pushes so hard'),
    Nonsense('sim_node', '/push', (*_FORCE, 'z'), 1e308, 'nobody pushes so hard'),
    Nonsense('sim_node', '/push', ('wrench', 'torque', 'z'), 1.0, 'a push does not turn'),
    Nonsense(_CAMERA, _INFO, ('k', 0), math.nan, 'a focal length is a number'),
    Nonsense(_CAMERA, _INFO, ('k', 0), 0.0, 'the camera is not calibrated'),
    Nonsense(_CAMERA, _INFO, ('k', 4), 1e308, 'no lens has that focal length'),
    Nonsense(_CAMERA, _INFO, ('width',), 0, 'pictures have pixels'),
    Nonsense(_CAMERA, _INFO, ('height',), 2**31, 'no picture is so large'),
    Nonsense(_CAMERA, _INFO, ('d', 0), math.inf, 'coefficients of a lens are numbers'),
    Nonsense(_CAMERA, _INFO, ('distortion_model',), 'moon', 'nobody knows that model'),
    Nonsense(_CAMERA, _PICTURE, ('encoding',), 'moon', 'nobody knows that encoding'),
    Nonsense(_CAMERA, _PICTURE, ('width',), 0, 'pictures have pixels'),
    Nonsense(_CAMERA, _PICTURE, ('height',), 2**31, 'no picture is so large'),
    Nonsense(_CAMERA, _PICTURE, ('step',), 1, 'rows are longer'),
    Nonsense(_CAMERA, _PICTURE, ('data',), array('B'), 'its pixels are missing'),
    Nonsense(_CAMERA, '/odom/legs', _FRAME, 'map', 'legs cannot know where the map is'),
    *_poses(_CAMERA, '/odom/legs', 'pose', 'pose'),
)  # fmt: skip
"""What is sent, and why it has to be refused."""


def accepted_nonsense(
    stage: Stage, attacker: Attacker, rng: np.random.Generator, count: int | None = None
) -> tuple[int, list[str]]:
    """
    Send a node what it must refuse, and listen for the refusal on diagnostics.

    Parameters
    ----------
    stage : Stage
        Where it runs.
    attacker : Attacker
        Of the node.
    rng : numpy.random.Generator
        Of the sample.
    count : int, optional
        How many of the messages; all if not given.

    Returns
    -------
    tuple of int and list of str
        How many were sent, and those that were not refused.
    """
    cases = [case for case in CASES if case.node == attacker.name]
    if count is not None and count < len(cases):
        chosen = sorted(rng.choice(len(cases), count, replace=False))
        cases = [cases[index] for index in chosen]
    targets = {target.name: target for target in attacker.inputs}
    return len(cases), [
        str(case) for case in cases if not _is_refused(stage, attacker, targets[case.topic], case)
    ]


def _is_refused(stage: Stage, attacker: Attacker, target: Interface, case: Nonsense) -> bool:
    """Return whether the node says so, in a sentence that it did not say just before."""
    known = _known(stage, case)
    if _says_it(stage, attacker, target, case, known):
        return True
    # On a busy machine the sentence may come later; or it is that of the case before: once that
    # is over, again.
    stage.spin(_WORDS_LAST)
    if _has_said_it(stage, case, known):
        return True
    # What the case before was answered has come in by now: only what is still said is known.
    stage.listener.refusals[case.node] = []
    return _says_it(stage, attacker, target, case, {stage.said(case.node)})


def _known(stage: Stage, case: Nonsense) -> set[str]:
    """Return what the node says already; what it says from now on is collected."""
    refusals = stage.listener.refusals
    known = {*refusals.get(case.node, [])[-_RECENT:], stage.said(case.node)}
    refusals[case.node] = []
    return known


def _says_it(
    stage: Stage, attacker: Attacker, target: Interface, case: Nonsense, known: set[str]
) -> bool:
    for _ in range(_TRIES):
        message = replaced(attacker.example(target), case.path, case.value)
        attacker.send(target, message, str(case))
        # What it answers to later requests comes after what it says of the message; that
        # holds on a busy machine as well, where no fixed time is enough.
        stage.ping(case.node)
        stage.spin(_AGAIN)
        if _has_said_it(stage, case, known):
            return True
    return False


def _has_said_it(stage: Stage, case: Nonsense, known: set[str]) -> bool:
    new = set(stage.listener.refusals[case.node]) - known
    return any(word in sentence for sentence in new for word in _WORDS[case.topic])
