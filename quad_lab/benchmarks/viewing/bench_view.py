"""
``quadwalk bench view``: how fast the viewer shows a walk, and what it and a recording cost.

The page is read by a browser without a window for what a person does, and by a program that speaks
the page's protocol, and draws nothing, for rates and costs: without a graphics card a browser
draws with the very processor that simulates.
"""

from __future__ import annotations

import contextlib
import math
import statistics
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import rclpy
from geometry_msgs.msg import Twist, Vector3
from rich.console import Console

from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_lab.benchmarks.viewing.walk_costs import Course, recording_cost, viewer_cost
from quad_lab.tools.chromium import Chromium, find_chromium
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.page_reader import PageReader
from quad_lab.topic_walk.node_processes import NodeProcesses, isolated_domain
from quad_lab.topic_walk.viewer_process import PagePlace, start_viewer
from quad_lab.topic_walk.walk import START_TIMEOUT, NodesNotReady
from quad_lab.topic_walk.walk_observer import WalkObserver
from quad_sim.engines.registry import AUTO

PARTS = ('page', 'updates', 'cost', 'recording')
"""What can be measured alone."""

_PLACE = PagePlace(port=8700)

_START, _FAR_GOAL, _NEAR_GOAL = (
    Pose2D(1.2, 1.2, 0.0), Pose2D(6.8, 4.8, math.pi / 2), Pose2D(1.9, 2.6, 1.0),
)  # fmt: skip

_LOADS, _QUICK_LOADS = 5, 2
_PAIRS, _QUICK_PAIRS = 5, 1
"""Walks with the viewer and without it."""

_COUNTED, _QUICK_COUNTED = 20.0, 4.0
"""Time for which updates are counted [s]."""

_STEERING = (Twist, 'cmd_vel', 10)
"""What steers a robot: type, topic, quality of service."""

_STEERING_PERIOD = 0.1
"""Between two commands to a robot that is steered [s]."""

_WALKED = 0.05
"""A robot that has come so far walks [m]."""

_WALK_TIMEOUT = 60.0
"""For a robot to walk after a click [s]."""

_FLOOR = (330.0, 470.0)
"""A place on the floor of the sample map, as the page shows it at first [pixels]."""

_READY = """
(() => {
    const timer = setInterval(() => {
        const text = document.body ? document.body.innerText : '';
        if (!text.includes('standing') || !document.querySelector('canvas')) {
            return;
        }
        clearInterval(timer);
        window.readyAfter = performance.now();
        // Two frames later what is there now has been drawn.
        requestAnimationFrame(() => requestAnimationFrame(() => {
            window.drawnAfter = performance.now();
        }));
    }, 10);
})();
"""
"""
Notes down when buttons, the sentence about the robot and the scene's canvas are there, and when
they have been drawn, since the page was asked for [ms].
"""


def measure(
    console: Console, quick: bool, seed: int, only: tuple[str, ...] = PARTS
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Look at robots that walk, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        Short walks only.
    seed : int
        Of the sensors' noise.
    only : tuple of str
        Parts to measure.

    Returns
    -------
    tuple
        The bars, and details for JSON.
    """
    bars: list[Criterion] = []
    details: dict[str, object] = {'quick': quick, 'seed': seed}
    if 'page' in only:
        bars += _measure_page(console, _QUICK_LOADS if quick else _LOADS, details)
    if 'updates' in only:
        bars += _measure_updates(console, _QUICK_COUNTED if quick else _COUNTED, details)
    if 'cost' in only:
        goal, pairs = (_NEAR_GOAL, _QUICK_PAIRS) if quick else (_FAR_GOAL, _PAIRS)
        bars += viewer_cost(console, Course(_START, goal, seed, _PLACE), pairs, details)
    if 'recording' in only:
        goal, pairs = (_NEAR_GOAL, _QUICK_PAIRS) if quick else (_FAR_GOAL, _PAIRS)
        bars += recording_cost(console, Course(_START, goal, seed, _PLACE), pairs, details)
    return bars, details


def page_bars(
    loads: list[tuple[float, float]],
    clicks: int | None,
    problems: int | None,
    strangers: int | None,
) -> list[Criterion]:
    """
    Make the bars of what a browser has shown.

    Parameters
    ----------
    loads : list of (float, float)
        Times until the page was ready, and until it was drawn [s]; empty if there is no browser.
    clicks : int or None
        Clicks until the robot walked to a goal of one's own; None if it did not.
    problems, strangers : int or None
        Errors on the console, and other hosts that were asked for anything.
    """
    ready, drawn = (
        (statistics.median(times) for times in zip(*loads, strict=True)) if loads else (None, None)
    )
    return [
        at_most('clicks to the first own goal', clicks, '', 1),
        at_most('page ready, median', ready, 's', 2.0),
        figure('page drawn, by the processor, median', drawn, 's'),
        at_most('errors on the console', problems, '', 0),
        at_most('requests to other hosts', strangers, '', 0),
    ]


def _measure_page(console: Console, loads: int, details: dict[str, object]) -> list[Criterion]:
    if find_chromium() is None:
        console.print('no Chromium: what a person does is not measured (apt install chromium)')
        return page_bars([], None, None, None)
    with _robots(1) as (_, observer), NodeProcesses() as viewer:
        address = start_viewer(viewer, _PLACE)
        with Chromium((1400, 850)) as browser:
            browser.prepare(_READY)
            times = []
            for _ in range(loads):
                browser.open('about:blank')
                browser.open(address)
                drawn = 1e-3 * float(browser.wait_for('window.drawnAfter'))
                times.append((1e-3 * float(browser.evaluate('window.readyAfter')), drawn))
                console.print(
                    f'page ready after {times[-1][0]:.2f} s, drawn after {drawn:.2f} s',
                    highlight=False,
                )
            browser.click(*_FLOOR)
            clicks = 1 if _has_walked(observer) else None
            problems, strangers = browser.problems, browser.hosts() - {'localhost'}
    details['page'] = {'loads': times, 'problems': problems, 'strangers': sorted(strangers)}
    return page_bars(times, clicks, len(problems), len(strangers))


def _has_walked(observer: WalkObserver) -> bool:
    """Wait until the robot walks."""
    begin = observer.pose
    deadline = time.monotonic() + _WALK_TIMEOUT
    while time.monotonic() < deadline:
        observer.listen(0.1)
        if begin and observer.pose and observer.pose.distance_to(begin) > _WALKED:
            return True
    return False


def _measure_updates(
    console: Console, duration: float, details: dict[str, object]
) -> list[Criterion]:
    """Count how often two robots are shown that trot on the spot, so that none ever stands."""
    with _robots(2) as (twists, _), NodeProcesses() as viewer:
        address = start_viewer(viewer, _PLACE)
        with PageReader(address) as reader, _steered(twists):
            deadline = time.monotonic() + _WALK_TIMEOUT
            while len(reader.count(2.0)[0].poses) < 2 and time.monotonic() < deadline:
                continue
            updates, seconds = reader.count(duration)
    rates = [updates.poses[number] / seconds for number in range(2)]
    console.print(
        f'two robots: {rates[0]:.1f} and {rates[1]:.1f} updates a second, '
        f'{updates.size / seconds / 1e3:.0f} kB/s',
        highlight=False,
    )
    details['updates'] = {'rates': rates, 'bytes_a_second': updates.size / seconds}
    return [
        at_least('updates of each of two robots, the rarer', min(rates), '1/s', 25.0),
        figure('sent to a page', updates.size / seconds / 1e3, 'kB/s'),
    ]


@contextlib.contextmanager
def _steered(twists: list[Any]) -> Iterator[None]:
    """Let robots turn on the spot while the block runs."""
    is_over = threading.Event()

    def steer() -> None:
        while not is_over.wait(_STEERING_PERIOD):
            for publisher in twists:
                publisher.publish(Twist(angular=Vector3(z=0.3)))

    thread = threading.Thread(target=steer, name='steering', daemon=True)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


def _start(number: int) -> Pose2D:
    return _START @ Pose2D(0.0, 1.4 * number, 0.0)


@contextlib.contextmanager
def _robots(count: int) -> Iterator[tuple[list[Any], WalkObserver]]:
    """
    Start robots in real time; give what steers them, and an observer.

    A single one crawls; several trot, a gait that does not rest between its cycles.
    """
    map_file: Path = sample_map()
    with contextlib.ExitStack() as stack:
        stack.enter_context(isolated_domain())
        clock: dict[str, object] = {} if count == 1 else {'use_sim_time': False}
        for number in range(count):
            nodes = stack.enter_context(NodeProcesses(_namespace(number, count)))
            start = _start(number)
            nodes.start(
                'sim_node', map_file=str(map_file.resolve()), backend=AUTO, real_time_factor=1.0,
                start_pose=[start.x, start.y, start.yaw],
            )  # fmt: skip
            nodes.start('planner_node', **clock)
            nodes.start('gait_node', gait='crawl' if count == 1 else 'trot', **clock)
        observer = stack.enter_context(WalkObserver(_NEAR_GOAL))
        context = rclpy.Context()
        rclpy.init(context=context)
        stack.callback(context.try_shutdown)
        twists = []
        for number in range(count):
            namespace = _namespace(number, count)
            node = rclpy.create_node('bench', namespace=namespace, context=context)
            stack.callback(node.destroy_node)
            twists.append(node.create_publisher(*_STEERING))
        deadline = time.monotonic() + START_TIMEOUT
        while not all(publisher.get_subscription_count() for publisher in twists) or (
            count == 1 and not (observer.planner_is_ready() and observer.pose)
        ):
            observer.listen(0.1)
            if time.monotonic() > deadline:
                raise NodesNotReady(START_TIMEOUT, '')
        yield twists, observer


def _namespace(number: int, count: int) -> str:
    return f'/robot{number + 1}' if count > 1 else ''
