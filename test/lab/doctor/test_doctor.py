"""
The doctor finds what works, and names what does not with the step that mends it.
"""

from __future__ import annotations

import importlib.util
import json
import socket
import subprocess
import sys
from collections import namedtuple

import pytest

from quad_cli.main import main
from quad_lab.doctor import engine_checks, machine_checks, ros_checks
from quad_lab.doctor.engine_checks import check_engines
from quad_lab.doctor.finding import State, good
from quad_lab.doctor.machine_checks import check_files, check_port, check_processors, check_python
from quad_lab.doctor.ros_checks import check_ros
from quad_sim.engines.registry import ENGINES

needs_ros = pytest.mark.skipif(
    importlib.util.find_spec('rclpy') is None, reason='rclpy is not installed'
)


def found(check, subject):
    (finding,) = [finding for finding in check() if finding.subject == subject]
    return finding


@pytest.fixture
def absent(monkeypatch):
    """Hide packages."""
    names = set()
    find = importlib.util.find_spec
    monkeypatch.setattr(
        'importlib.util.find_spec', lambda name, *rest: None if name in names else find(name, *rest)
    )
    return names


@pytest.fixture
def own_domain():
    """Stay among ourselves."""
    from quad_lab.topic_walk.node_processes import isolated_domain

    with isolated_domain():
        yield


def test_what_is_here_is_good():
    assert found(check_python, 'Python').state is State.GOOD
    assert found(check_python, 'packages').state is State.GOOD
    for subject in ('this folder', 'temporary files', 'imported robots'):
        assert found(check_files, subject).state is State.GOOD


def test_another_python_is_said(monkeypatch):
    version = namedtuple('version', 'major minor micro')(3, 9, 0)
    monkeypatch.setattr(sys, 'version_info', version)
    finding = found(check_python, 'Python')
    assert finding.state is State.WRONG
    assert 'make venv' in finding.mend


def test_packages_that_all_need_are_told_from_those_that_some_need(absent):
    absent.update({'scipy', 'rosbags'})
    needed, extra = found(check_python, 'packages'), found(check_python, 'rosbags')
    assert (needed.state, extra.state) == (State.WRONG, State.OPTIONAL)
    assert 'scipy' in needed.said
    assert extra.mend == "pip install 'quadwalk[record]'"


def test_places_that_cannot_be_written_are_named(monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', '/proc/nobody')
    finding = found(check_files, 'imported robots')
    assert finding.state is State.WRONG
    assert 'XDG_CACHE_HOME' in finding.mend


def test_a_full_disk_is_named(monkeypatch):
    usage = namedtuple('usage', 'total used free')(10**9, 10**9, 10**7)
    monkeypatch.setattr(machine_checks.shutil, 'disk_usage', lambda path: usage)
    assert '0.01 GB free' in found(check_files, 'this folder').said


def test_a_taken_port_is_named():
    port = machine_checks.ViewerParameters().port
    with socket.socket() as other:
        other.bind(('127.0.0.1', 0))
        other.listen()
        taken = other.getsockname()[1]
        assert found(check_port, 'port').said.startswith(str(port))
        with pytest.MonkeyPatch.context() as patch:
            page = machine_checks.ViewerParameters(port=taken)
            patch.setattr(machine_checks, 'ViewerParameters', lambda: page)
            finding = found(check_port, 'port')
    assert finding.state is State.OPTIONAL
    assert str(taken) in finding.said


@pytest.mark.parametrize(('load', 'state'), [(0.0, State.GOOD), (999.0, State.OPTIONAL)])
def test_a_busy_machine_is_named(monkeypatch, load, state):
    monkeypatch.setattr(machine_checks.os, 'getloadavg', lambda: (load, 0.0, 0.0))
    assert found(check_processors, 'processors').state is state


@pytest.mark.parametrize('name', [name for name, engine in ENGINES.items() if engine.package])
def test_engines_are_tried(name):
    finding = found(check_engines, ENGINES[name].package)
    if ENGINES[name].is_installed:
        assert finding.state is State.GOOD
        assert 'a robot stands' in finding.said
    else:
        assert finding.mend.startswith('pip install')


def test_without_engines_nothing_walks(absent):
    absent.update(engine.package for engine in ENGINES.values())
    assert found(check_engines, 'engine by default').state is State.WRONG


def test_pictures_that_end_their_process_are_named(monkeypatch):
    monkeypatch.setattr(engine_checks, '_PICTURE', 'import os; os.abort()')
    for engine in ENGINES.values():
        if engine.package and engine.is_installed:
            finding = found(check_engines, f'pictures by {engine.package}')
            assert finding.state is State.OPTIONAL
            assert 'exit code' in finding.said


def test_without_ros_the_rest_is_not_looked_at(absent):
    absent.add('rclpy')
    (finding,) = check_ros()
    assert finding.state is State.WRONG
    assert 'quadwalk[ros]' in finding.mend


@needs_ros
def test_messages_come_back_from_another_process(own_domain):
    finding = found(check_ros, 'round trip')
    assert finding.state is State.GOOD
    assert 'answers in' in finding.said


@needs_ros
def test_a_process_that_is_not_found_is_named(own_domain, monkeypatch):
    monkeypatch.setattr(ros_checks, '_PATIENCE', 0.5)
    start = subprocess.Popen
    monkeypatch.setattr(
        ros_checks.subprocess,
        'Popen',
        lambda command, **options: start([sys.executable, '-c', 'input()'], **options),
    )
    finding = found(check_ros, 'round trip')
    assert finding.state is State.WRONG
    assert 'was not found' in finding.said


@needs_ros
@pytest.mark.parametrize('domain', ['abc', '9999', '-1'])
def test_a_domain_that_is_none_is_named(monkeypatch, domain):
    monkeypatch.setenv('ROS_DOMAIN_ID', domain)
    finding = found(check_ros, 'network')
    assert finding.state is State.WRONG
    assert domain in finding.said


@needs_ros
def test_a_middleware_that_does_not_start_is_named(monkeypatch):
    monkeypatch.setattr('rclpy.init', raising)
    assert found(check_ros, 'round trip').said == 'no middleware'


def raising(*arguments, **options):
    raise RuntimeError('no middleware')


@needs_ros
def test_security_that_cannot_be_had_is_named(monkeypatch):
    monkeypatch.setenv('ROS_SECURITY_ENABLE', 'yes')
    finding = found(check_ros, 'rclpy')
    assert finding.state is State.WRONG
    assert 'ROS_SECURITY_ENABLE' in finding.said


@needs_ros
def test_the_command_says_whether_it_works(own_domain, capfd, monkeypatch):
    assert main(['doctor', '--json']) == 0
    told = json.loads(capfd.readouterr().out)
    assert told['works']
    assert {'Python', 'rclpy', 'round trip', 'port'} <= {f['subject'] for f in told['findings']}
    monkeypatch.setattr('quad_cli.doctor.CHECKS', (check_python, check_files))
    monkeypatch.setenv('XDG_CACHE_HOME', '/proc/nobody')
    assert main(['doctor']) == 1
    assert 'mend what is marked NO' in capfd.readouterr().out


def test_what_was_found_is_printed_before_the_next_check(monkeypatch, capsys):
    printed = []

    def first():
        yield good('first', 'is here')
        printed.append(capsys.readouterr().out)

    def second():
        printed.append(capsys.readouterr().out)
        yield good('second', 'too')

    monkeypatch.setattr('quad_cli.doctor.CHECKS', (first, second))
    assert main(['doctor']) == 0
    assert 'first' in printed[0]
    assert not printed[1]
    assert 'second' in capsys.readouterr().out
