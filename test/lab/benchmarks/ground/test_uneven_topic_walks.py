"""Walks by topics are those of the scenes, and their bars say what became of them."""

import math

import pytest

pytest.importorskip('rclpy')

from rich.console import Console

from quad_common.maps.height_map_file import load_height_map
from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks.ground import uneven_topic_walks
from quad_lab.benchmarks.ground.bench_ground import TOPICS, measure
from quad_lab.benchmarks.ground.uneven_topic_walks import walk_by_topics
from quad_lab.closed_loop.ground_walk import make_scene
from quad_lab.topic_walk.walk_record import WalkRecord


@pytest.fixture
def walked(monkeypatch):
    """What was asked for, in place of walks; each is 12 times as fast as real time and arrives."""
    walked = []

    def walk(options):
        walked.append((options, load_height_map(options.terrain)))
        record = WalkRecord(options.goal, has_arrived=True, wall_time=5.0)
        record.note_pose(1.0, options.start)
        record.note_pose(61.0, options.goal)
        return record

    monkeypatch.setattr(uneven_topic_walks, 'walk', walk)
    return walked


def by_name(bars):
    return {bar.name.removeprefix('by topics: '): bar for bar in bars}


def test_walks_are_those_of_the_scenes_on_their_ground(walked):
    robots, terrains = ('titan_viii', 'genibo'), ('bumps', 'slope')
    bars, walks = walk_by_topics(Console(quiet=True), False, 40, robots, terrains)
    assert len(walked) == len(walks) == 20
    done = {(walk['robot'], walk['terrain'], walk['seed']) for walk in walks}
    assert done == {(r, t, s) for r in robots for t in terrains for s in range(40, 45)}
    options, heights = walked[0]
    scene = make_scene(load_robot('titan_viii'), 'bumps', 40)
    assert (options.start, options.goal) == (scene.start, scene.goal)
    assert options.real_time_factor == 0.0
    assert abs(heights.heights - scene.height_map.heights).max() < 1e-5
    figures = by_name(bars)
    assert figures['arrived, of 20'].value == 20
    assert figures['speed'].value == pytest.approx(12.0)
    assert all(bar.holds is not False for bar in bars)


def test_bars_are_missed_by_walks_that_are_slow_late_or_fall(walked, monkeypatch):
    good = uneven_topic_walks.walk

    def bad(options):
        record = good(options)
        record.has_fallen, record.late_trajectories, record.wall_time = True, 2, 20.0
        record.contacts = 'lf_calf'
        return record

    monkeypatch.setattr(uneven_topic_walks, 'walk', bad)
    bars, _ = measure(Console(quiet=True), True, 0, (TOPICS, 'bumps'))
    missed = {name for name, bar in by_name(bars).items() if bar.holds is False}
    assert missed == {
        'arrived, of 1',
        'falls',
        'walks with contacts of anything but feet',
        'late trajectories',
        'speed',
    }
    assert math.isfinite(by_name(bars)['farthest from the goal'].value)
