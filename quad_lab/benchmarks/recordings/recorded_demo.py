"""
A part of ``quadwalk bench fleet``: a demo that is recorded, and what its recording is worth.
"""

from __future__ import annotations

import contextlib
import importlib.util
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import rclpy
from rich.console import Console
from rosbags.rosbag2 import Reader
from std_srvs.srv import Trigger

from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks.recordings.laws import Limits, Moved, differing, jumps, without_way
from quad_lab.benchmarks.recordings.playback import Messages, play
from quad_lab.benchmarks.recordings.witness import Witness, digest
from quad_lab.recordings.recorded_topics import FIXED_TRANSFORMS, GOAL, RECORDED, TRANSFORMS
from quad_lab.recordings.shared_transforms import transforms_in
from quad_lab.tools.criterion import Criterion, at_most, figure
from quad_lab.topic_walk.node_processes import isolated_domain
from quad_lab.topic_walk.walk import WalkOptions, walk
from quad_lab.topic_walk.walk_record import WalkRecord

_START = Pose2D(1.2, 1.2, 0.0)

_GOALS = {'crawl': Pose2D(1.8, 1.4, 0.5), 'trot': Pose2D(3.0, 2.0, 0.5)}
_QUICK_GOALS = {'trot': Pose2D(1.6, 1.2, 0.0)}
"""Where a robot walks, by gaits."""

_PACE = 4.0
"""Times real time: two listeners of their own, which lose nothing, beside the nodes."""

_ROBOT = 'titan_viii'

_BODY = 'base_link'

_TRANSFORMS = {topic.in_namespace('') for topic in (TRANSFORMS, FIXED_TRANSFORMS)}


def recording_bars(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, Any]]:
    """
    Walk demos that are recorded; count what was published, read it, play it, look for leaps.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        A single short walk.
    seed : int
        Of the sensors' noise.

    Returns
    -------
    tuple
        The bars, and the figures of each walk for JSON.
    """
    walks: dict[str, dict[str, int]] = {}
    for gait, goal in (_QUICK_GOALS if quick else _GOALS).items():
        with tempfile.TemporaryDirectory(prefix='quadwalk_') as folder, isolated_domain():
            recording = Path(folder) / 'recording'
            heard = _walk(recording, gait, goal, seed)
            walks[gait] = found = _counts(recording, heard) | _proofs(console, recording)
        said = ', '.join(f'{what}: {count}' for what, count in found.items())
        console.print(f'recording of a {gait}: {said}', highlight=False)
    total = {what: sum(one[what] for one in walks.values()) for what in next(iter(walks.values()))}
    figures = ('messages', 'transforms')
    bars = [figure(f'recording: {what}', total.pop(what), '') for what in figures]
    bars += [at_most(f'recording: {what}', count, '', 0) for what, count in total.items()]
    return bars, {'recording': walks}


def _walk(folder: Path, gait: str, goal: Pose2D, seed: int) -> dict[str, list[bytes]]:
    """Walk once, recorded; return what a witness heard until all nodes were silent."""
    heard: dict[str, list[bytes]] = {}
    with Witness() as witness, _pauser() as pause:

        def stop(record: WalkRecord, go_on: Callable[[], None]) -> None:
            pause(go_on)
            witness.wait_for_silence(go_on)
            heard.update(witness.heard())

        options = WalkOptions(
            sample_map(), _START, goal, robot=_ROBOT, gait=gait, seed=seed,
            real_time_factor=_PACE, recording=folder,
        )  # fmt: skip
        walk(options, on_end=stop)
    return heard


@contextlib.contextmanager
def _pauser() -> Iterator[Callable[[Callable[[], None]], None]]:
    """Make what stops simulated time, and with it the nodes."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node('quadwalk_pauser', context=context)
    client = node.create_client(Trigger, 'pause')

    def pause(go_on: Callable[[], None]) -> None:
        client.wait_for_service(10.0)
        answer = client.call_async(Trigger.Request())
        executor = rclpy.executors.SingleThreadedExecutor(context=context)
        executor.add_node(node)
        while not answer.done():
            executor.spin_once(timeout_sec=0.0)
            go_on()
        executor.shutdown()

    try:
        yield pause
    finally:
        node.destroy_node()
        context.try_shutdown()


def _counts(folder: Path, heard: Mapping[str, Sequence[bytes]]) -> dict[str, int]:
    """Count what a recording has, and what only it or only the witness has."""
    messages = _read(folder)
    goal = next(time for name, time, _ in messages if name == GOAL.in_namespace(''))
    differ = 0
    for topic in RECORDED:
        name, there = topic.in_namespace(''), heard.get(topic.name, [])
        own = [(time, digest(data)) for one, time, data in messages if one == name]
        if name in _TRANSFORMS:
            # Those of the links are the recorder's own.
            known = set(there)
            own = [(time, data) for time, data in own if data in known]
        needed = sum(time >= goal for time, _ in own)
        differ += differing(there, [data for _, data in own], needed)
    return {'messages': len(messages), 'messages that differ from those published': differ}


def _proofs(console: Console, folder: Path) -> dict[str, int]:
    """Read a recording by every reader, play it, and look at its transforms."""
    messages = _read(folder)
    found: dict[str, int] = {}
    by_mcap = _read_by_mcap(folder)
    if by_mcap is None:
        console.print('recording: not read by mcap, which is not installed (pip install mcap)')
    else:
        pairs = zip(messages, by_mcap)
        other = sum(one != two for one, two in pairs) + abs(len(messages) - len(by_mcap))
        found['messages that rosbags and mcap read otherwise'] = other
    played, untyped = play(folder)
    if untyped:
        console.print(f'recording: not played, without their types: {", ".join(untyped)}')
    found['topics that do not arrive when played'] = sum(not p.arrived for p in played.values())
    late = sum(not p.arrived_late for p in played.values())
    found['latched topics that do not reach late subscribers'] = late
    moved = list(_transforms(messages))
    body, others = _limits(load_robot(_ROBOT))
    found['transforms'] = len(moved)
    found['jumps of frames'] = jumps(moved, {_BODY: body, 'base_footprint': body}, others)
    edges = {(one.parent, one.child) for one in moved}
    found['frames that do not lead to the map'] = len(without_way(edges, 'map')) if edges else 1
    return found


def _read(folder: Path) -> Messages:
    with Reader(folder) as reader:
        return [(c.topic, time, bytes(data)) for c, time, data in reader.messages()]


def _read_by_mcap(folder: Path) -> Messages | None:
    """Read the messages by the package mcap; None if it is not installed."""
    if importlib.util.find_spec('mcap') is None:
        return None
    from mcap.reader import make_reader

    (path,) = folder.glob('*.mcap')
    with path.open('rb') as file:
        return [
            (channel.topic, message.log_time, message.data)
            for _, channel, message in make_reader(file).iter_messages()
        ]


def _transforms(messages: Messages) -> Iterator[Moved]:
    """Yield what a recording says of frames."""
    for name, _, data in messages:
        for part in transforms_in(data) if name in _TRANSFORMS else ():
            stamp, move, turn = part.header.stamp, *_parts(part.transform)
            time = stamp.sec + 1e-9 * stamp.nanosec
            yield Moved(part.header.frame_id, part.child_frame_id, time, move, turn)


def _parts(transform: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
    move, turn = transform.translation, transform.rotation
    return (move.x, move.y, move.z), (turn.x, turn.y, turn.z, turn.w)


def _limits(robot: Robot) -> tuple[Limits, Limits]:
    """Return how fast the body moves at most by its legs, and each link on its joint."""
    rate = float(robot.velocity.max())
    reach = max(float(leg.thigh_length + leg.calf_length) for leg in robot.legs)
    width = min(abs(float(leg.hip[1])) for leg in robot.legs)
    speed = rate * reach
    return Limits(speed, speed / width), Limits(0.0, rate)
