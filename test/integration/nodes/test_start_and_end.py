"""Nodes begin with valid parameters only, and end quietly."""

from __future__ import annotations

import importlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip('rclpy')

import rclpy
from harness import WALL_TIMEOUT, Bench

from quad_common.errors import QuadError
from quad_common.network.reach import SecuritySettingUnknown, library_without_security, reach_of
from quad_common.network.transport import PROFILES, RANGE
from quad_common.planar_pose import Pose2D
from quad_lab.attacks.processes.traces import files_of
from quad_lab.topic_walk import composed_nodes
from quad_lab.topic_walk.node_processes import (
    NODES,
    NodeProcess,
    NodeProcesses,
    isolated_domain,
)

pytestmark = pytest.mark.ros

ROOT = Path(__file__).resolve().parents[3]

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

ENDS_WITHIN = 20.0
"""Three seconds and a half on a quiet machine, on one that does ten other things more [s]."""

INVALID = [
    ('gait_node', {'settle_time': -1}, "'settle_time' is -1; it must be a finite number from 0"),
    ('planner_node', {'robot': 'unicorn'}, "there is no robot 'unicorn'; available: "),
    ('gait_node', {'use_sim_time': 'perhaps'}, "'use_sim_time' to 'perhaps'"),
    ('sim_node', {'map_file': '/nowhere.yaml'}, 'map file /nowhere.yaml cannot be read: '),
    ('viewer_node', {'host': '192.0.2.1'}, "'host' is '192.0.2.1'; it must be an address of"),
    ('viewer_node', {'port': 70000}, "'port' is 70000; it must be a whole number from 0 to"),
]


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize(('node', 'parameters', 'words'), INVALID)
def test_an_invalid_parameter_ends_a_node_with_one_sentence(bench: Bench, node, parameters, words):
    bench.start(node, **parameters)
    end = bench.wait_for_end(node)
    assert end.code == 2
    [sentence] = end.log.splitlines()
    assert sentence.startswith('error: ')
    assert words in sentence


REFUSED = [
    ('gait_node', {'settle_time': float('nan')}, "'settle_time' is nan; it must be a finite"),
    ('gait_node', {'gait': 'gallop'}, "'gait' is 'gallop'; it must be one of crab, crawl,"),
    ('planner_node', {'robot': 5}, "'robot' is 5; it must be a text"),
    ('planner_node', {'method': 'magic'}, "'method' is 'magic'; it must be one of mesh, "),
    ('sim_node', {'start_pose': [1.0, 2.0]}, "'start_pose' is [1.0, 2.0]; it must be 3 finite"),
    ('sim_node', {'seed': -1}, "'seed' is -1; it must be a whole number of at least 0"),
]


@pytest.mark.parametrize(('node', 'parameters', 'words'), REFUSED)
def test_no_node_is_made_with_an_invalid_parameter(composed_bench: Bench, node, parameters, words):
    with pytest.raises(QuadError) as refused:
        composed_bench.start(node, **parameters)
    [sentence] = str(refused.value).splitlines()
    assert words in sentence


@pytest.mark.parametrize('node', ['ceiling_camera_node', 'gait_node', 'planner_node', 'sim_node'])
def test_a_node_begins_with_the_parameter_file_that_ships(domain, node):
    file = ROOT / 'config' / f'{node}.yaml'
    module, kind = composed_nodes._NODES[node]
    rclpy.init(args=['--ros-args', '--disable-stdout-logs', '--params-file', str(file)])
    try:
        made = getattr(importlib.import_module(module), kind)()
        assert made.parameters == type(made.parameters)()
        made.destroy_node()
    finally:
        rclpy.try_shutdown()


def test_whole_numbers_will_do_where_others_are_expected(composed_bench: Bench):
    bench = composed_bench
    bench.start('sim_node', start_pose=[2, 3, 0])
    bench.wait_until('odometry', lambda: bench.odometry is not None)
    assert bench.is_near(Pose2D(2.0, 3.0, 0.0))


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('gaps', [(0.0, 0.1, 0.0), (0.1, 0.0, 0.1)])
def test_two_interrupts_end_every_node_quietly_in_the_middle_of_a_walk(bench: Bench, gaps):
    bench.start_robot()
    bench.give_goal(Pose2D(2.0, 1.2, 0.0))
    bench.wait_for_walking()
    for (node, process), gap in zip(bench.processes.items(), gaps, strict=True):
        assert bench.interrupt(node, gap) == 0, node
        assert 'Traceback' not in process.log_tail(1000)


@pytest.mark.parametrize('settings', [{}, {RANGE: 'LOCALHOST'}])
def test_nodes_as_users_start_them_share_no_memory(domain, monkeypatch, settings):
    # A lock in it would not survive its owner, and all others would wait for it.
    for name in (RANGE, PROFILES):
        monkeypatch.delenv(name)
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    with NodeProcesses() as nodes:
        node = nodes.start('planner_node')
        deadline = time.monotonic() + WALL_TIMEOUT
        while 'listening on' not in node.log_tail():
            node.check()
            assert time.monotonic() < deadline
            time.sleep(0.02)
        assert files_of(node.pid) == []
        words = 'this machine only' if settings else 'every machine of this subnet'
        assert words in node.log_tail()


STARTER = """
import signal, sys, time
# What runs in the background of a shell begins with interrupts ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
from quad_lab.topic_walk.node_processes import NodeProcesses
with NodeProcesses() as nodes:
    print(*(nodes.start(name).pid for name in sys.argv[1:]), flush=True)
    time.sleep(600)
"""


def is_running(pid: int) -> bool:
    """Whether a process lives; one that nobody waits for may stay behind as a zombie."""
    try:
        return Path(f'/proc/{pid}/cmdline').read_bytes() != b''
    except (FileNotFoundError, ProcessLookupError):
        return False


@pytest.mark.skipif(sys.platform != 'linux', reason='what ends with its parent is up to Linux')
@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('end', [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_no_node_outlives_the_command_that_started_it(bench: Bench, end):
    command = [sys.executable, '-c', STARTER, 'planner_node', 'gait_node']
    starter = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    nodes = [int(pid) for pid in starter.stdout.readline().split()]
    for name in ('planner_node', 'gait_node'):
        bench.wait_for_status(name, 'no clock')
    assert len(nodes) == 2
    assert all(map(is_running, nodes))
    starter.send_signal(end)
    assert starter.wait(WALL_TIMEOUT) != 0
    deadline = time.monotonic() + WALL_TIMEOUT
    while any(map(is_running, nodes)):
        assert time.monotonic() < deadline, f'{nodes} were left behind'
        time.sleep(0.05)


def test_a_planner_that_still_compiles_its_searches_ends_at_once(bench, tmp_path, monkeypatch):
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(tmp_path / 'empty'))
    bench.start('planner_node', method='quickest', any_angle=True)
    bench.wait_for_status('planner_node', 'no clock')
    process = bench.processes['planner_node']
    assert bench.interrupt('planner_node', 0.0) == 0
    assert 'were compiled' not in process.log_tail(1000)
    assert 'Traceback' not in process.log_tail(1000)


@pytest.mark.parametrize(('place', 'node'), enumerate(NODES), ids=NODES)
def test_a_node_ends_quietly_however_soon_a_signal_comes(domain, tmp_path, place, node):
    # A tenth of a second is about when its modules are imported, a second when it is made. Each
    # node hears each signal, and at each of these moments some node hears each of them.
    for turn, delay in enumerate((0.0, 0.1, 0.3, 1.0)):
        process = NodeProcess(node, {}, tmp_path / 'log')
        time.sleep(delay)
        os.kill(process.pid, SIGNALS[(place + turn) % len(SIGNALS)])
        began = time.monotonic()
        assert process.wait(WALL_TIMEOUT) == 0
        assert time.monotonic() - began < ENDS_WITHIN
        assert 'Traceback' not in process.log_tail(1000)


def test_a_node_says_on_which_network_it_listens(bench: Bench):
    bench.start('planner_node')
    process = bench.processes['planner_node']
    bench.wait_until('it says so', lambda: 'listening on domain' in process.log_tail(1000))
    domain = os.environ['ROS_DOMAIN_ID']
    words = f'listening on domain {domain} to this machine only (Fast DDS'
    assert words in process.log_tail(1000)


def test_what_the_command_starts_stays_on_this_machine(monkeypatch):
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    monkeypatch.setenv('ROS_STATIC_PEERS', '192.168.0.7')
    with isolated_domain():
        assert 'to this machine only (' in reach_of(os.environ)
    assert os.environ['ROS_STATIC_PEERS'] == '192.168.0.7'
    assert os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'SUBNET'


def test_a_command_does_not_start_nodes_without_the_security_that_was_asked_for(monkeypatch):
    monkeypatch.setenv('ROS_SECURITY_ENABLE', 'yes')
    with pytest.raises(SecuritySettingUnknown), isolated_domain():
        pytest.fail('nodes would be started')


@pytest.mark.parametrize('strategy', ['Enforce', 'Permissive'])
def test_a_node_does_not_start_without_the_security_that_was_asked_for(
    bench: Bench, monkeypatch, strategy
):
    if library_without_security() is None:
        pytest.skip('the middleware here has security')
    monkeypatch.setenv('ROS_SECURITY_ENABLE', 'true')
    monkeypatch.setenv('ROS_SECURITY_STRATEGY', strategy)
    bench.start('planner_node')
    end = bench.wait_for_end('planner_node')
    assert end.code == 2
    [sentence] = end.log.splitlines()
    assert sentence.startswith('error: ROS_SECURITY_ENABLE is true, but rmw_')
