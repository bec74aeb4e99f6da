"""Whoever waits for simulated time notices that it stands still."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip('nav_msgs')

from quad_lab.topic_walk import composed_nodes, fleet
from quad_lab.topic_walk.composed_nodes import ComposedNodes
from quad_lab.topic_walk.node_processes import isolated_domain
from quad_lab.topic_walk.standstill import STALL_TIMEOUT, Standstill


class Clock:
    """A clock that goes on whenever it is looked at."""

    MOST_LOOKS = 1000

    def __init__(self, step: float = 1.0) -> None:
        self.now, self.step = 0.0, step

    def __call__(self) -> float:
        self.now += self.step
        assert self.now < self.MOST_LOOKS * self.step
        return self.now


class Paused:
    """A simulator whose time stands still."""

    time = 3.0

    def drive(self) -> float:
        return 0.1

    def destroy_node(self) -> None:
        pass


def test_it_counts_from_the_last_advance():
    standstill = Standstill(0.0, Clock())
    assert [standstill.duration(t) for t in (0.0, 0.5, 0.5, 0.5, 0.4)] == [1.0, 0.0, 1.0, 2.0, 3.0]


def test_a_composed_walk_does_not_wait_for_a_simulator_that_is_paused(monkeypatch):
    clock = Clock(0.1)
    monkeypatch.setattr(composed_nodes, 'Standstill', lambda time: Standstill(time, clock))
    with isolated_domain(), ComposedNodes() as nodes:
        nodes._nodes['sim_node'] = Paused()
        monkeypatch.setattr(nodes, '_drain', lambda: None)
        nodes.listen(0.1)
    assert clock.now < 1.0


def test_a_fleet_is_not_waited_for_when_time_stands_still(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(fleet, 'Standstill', lambda time: Standstill(time, clock))
    notes = fleet.FleetNotes({'robot1': fleet.RobotNotes()})
    observer = SimpleNamespace(is_ready=True, time=5.0, notes=notes, give_goals=lambda: None)
    fleet._walk(observer, lambda: None)
    assert STALL_TIMEOUT < clock.now < STALL_TIMEOUT + 5.0
    assert notes.problem.startswith('simulated time stands still since 60 s')
