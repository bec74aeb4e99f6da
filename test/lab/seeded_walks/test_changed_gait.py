"""Numbers of a gait change alone, and its file gives it back."""

import pytest

from quad_common.errors import QuadError
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.gait import load_gait
from quad_lab.seeded_walks.gait_changes import changed_gait, gait_text, numbers_of
from quad_lab.seeded_walks.payload import loaded

ROBOT = load_robot('cuhk')


@pytest.mark.parametrize('name', ['crawl', 'trot', 'wave'])
def test_nothing_changes_without_numbers(name):
    gait = load_gait(name, ROBOT)
    assert changed_gait(gait, {}) == gait
    again = numbers_of(changed_gait(gait, numbers_of(gait)))
    assert again == pytest.approx(numbers_of(gait), rel=1e-12)


@pytest.mark.parametrize(
    ('number', 'value'),
    [
        ('cycle_period', 0.6),
        ('duty_factor', 0.6),
        ('swing_height', 0.02),
        ('support_depth', 0.1),
        ('sway_weight', 0.2),
    ],
)
def test_one_number_changes_and_no_other(number, value):
    gait = load_gait('trot', ROBOT)
    before, after = numbers_of(gait), numbers_of(changed_gait(gait, {number: value}))
    assert after.pop(number) == pytest.approx(value)
    before.pop(number)
    assert after == pytest.approx(before)


def test_a_duty_factor_leaves_swings_where_they_are():
    gait = load_gait('trot', ROBOT)
    changed = changed_gait(gait, {'duty_factor': 0.7})
    for before, after in zip(gait.swings, changed.swings):
        assert after.leg == before.leg
        assert after.liftoff + after.touchdown == pytest.approx(before.liftoff + before.touchdown)
        assert after.touchdown - after.liftoff == pytest.approx(0.3 * gait.cycle_period)


@pytest.mark.parametrize('name', ['crawl', 'trot'])
def test_a_gait_that_is_written_is_the_same_when_it_is_read(tmp_path, name):
    gait = changed_gait(load_gait(name, ROBOT), {'swing_height': 0.017})
    path = tmp_path / 'tuned.yaml'
    path.write_text(gait_text(gait, ROBOT, 'cuhk_tuned', 'For a test.'), encoding='utf-8')
    read = load_gait(path, ROBOT)
    assert read.name == 'cuhk_tuned'
    assert numbers_of(read) == pytest.approx(numbers_of(gait), rel=1e-12)
    assert read.swings == gait.swings
    assert read.body_progress == gait.body_progress
    assert (read.is_static, read.pendulum_rate) == (gait.is_static, gait.pendulum_rate)


def test_a_payload_makes_the_robot_heavier_by_itself():
    assert loaded(ROBOT, 0.5).mass == pytest.approx(ROBOT.mass + 0.5)
    assert loaded(ROBOT, 0.0) is ROBOT


def test_an_imported_robot_carries_it_on_its_body():
    bullet = pytest.importorskip('quad_sim.engines.bullet_simulator')
    try:
        robot = load_robot('a1')
    except QuadError:
        pytest.skip('the description is not installed')
    masses = []
    for one in (robot, loaded(robot, 3.0)):
        simulator = bullet.BulletSimulator(one, bullet.World(_no_walls()))
        client, body = simulator._bullet, simulator._body
        links = range(-1, client.getNumJoints(body))
        masses.append([client.getDynamicsInfo(body, link)[0] for link in links])
        simulator.close()
    heavier = [b - a for a, b in zip(*masses)]
    assert sum(heavier) == pytest.approx(3.0)
    assert sorted(heavier)[:-1] == pytest.approx([0.0] * (len(heavier) - 1), abs=1e-9)


def _no_walls():
    import numpy as np

    return np.empty((0, 4, 2))
