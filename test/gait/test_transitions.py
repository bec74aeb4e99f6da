"""The table of transitions is complete, and the robot keeps to it."""

from collections import Counter
from pathlib import Path

import pytest
from walk_scenes import BALANCED, CORNER, FAULT, FLAT, SCENES, UNEVEN, Traced, play

from quad_common.planar_pose import Twist2D
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import Walk
from quad_gait.guards.guard import Guard
from quad_gait.transitions import GUARDS, ROUTINE

# The table


def test_every_activity_is_in_the_table():
    said = set().union(*(row.says for row in (*GUARDS, *ROUTINE)))
    # A robot that sits waits as one that stands does.
    assert said == set(Activity)


@pytest.mark.parametrize('row', ROUTINE, ids=lambda row: row.behaviour.__name__)
def test_a_row_is_handed_over_to_by_what_it_says(row):
    assert row.takes in row.says
    assert issubclass(row.behaviour, Walk) == (row.takes in {Activity.WALKING, Activity.BALANCING})


@pytest.mark.parametrize('options', [FLAT, BALANCED, UNEVEN], ids=['flat', 'balanced', 'uneven'])
def test_every_behaviour_is_reached_from_the_first_and_leads_back_to_it(options):
    rows = {row.takes: row for row in ROUTINE if row.suits(options)}
    if options is not BALANCED:
        assert Activity.BALANCING not in rows
        rows[Activity.BALANCING] = rows[Activity.WALKING]
    first = ROUTINE[0].takes
    reached, new = {first}, {first}
    while new:
        new = set().union(*(rows[activity].hands_over_to for activity in new)) - reached
        reached |= new
    assert reached == set(rows) | {Activity.BALANCING}
    assert all(first in row.hands_over_to for row in rows.values() if row.takes is not first)


@pytest.mark.parametrize('options', [FLAT, BALANCED, UNEVEN], ids=['flat', 'balanced', 'uneven'])
def test_on_each_ground_one_behaviour_takes_an_activity(options):
    taken = Counter(row.takes for row in ROUTINE if row.suits(options))
    assert set(taken.values()) == {1}


def test_no_guard_walks_the_robot():
    walking = {Activity.WALKING, Activity.TURNING}
    assert all(issubclass(row.guard, Guard) and not row.says & walking for row in GUARDS)


# The robot


@pytest.fixture(scope='module')
def traced():
    """Play every scene."""
    return {scene: play(scene) for scene in SCENES}


def test_every_row_acts_and_keeps_to_what_it_says(traced):
    acted = set().union(*(walk.acted for walk in traced.values()))
    missing = {*GUARDS, *ROUTINE} - acted
    assert not missing


def test_every_activity_is_reached(traced):
    assert set().union(*(walk.said for walk in traced.values())) == set(Activity)


@pytest.mark.parametrize('wish', ['set_plan', 'set_twist'])
def test_what_is_refused_is_said_with_the_reason_of_the_most_urgent_guard(wish):
    walk = Traced()
    walk.run(0.5)
    walk.supervisor._joints.watch = lambda state: None
    walk.supervisor._joints.fault = FAULT
    walk.run(0.1)
    assert walk.supervisor.activity is Activity.LAME
    argument = CORNER if wish == 'set_plan' else Twist2D(0.02)
    getattr(walk.supervisor, wish)(argument)
    assert walk.supervisor.limit.endswith(f'{FAULT.name} does not answer')
    walk.supervisor.freeze()
    getattr(walk.supervisor, wish)(argument)
    assert walk.supervisor.limit.endswith('the emergency stop is on')


# The page


def rows_of_the_page():
    text = (Path(__file__).parents[2] / 'docs' / 'architecture.md').read_text(encoding='utf-8')
    section = text.split('## Inside the gait')[1].split('\n### ')[0]
    return [line for line in section.splitlines() if line.startswith('| `')]


def test_the_page_has_the_table_of_the_code():
    def words(activities):
        return ', '.join(sorted(activity.value for activity in activities))

    expected = [f'| `{r.guard.__name__}` | {r.acts_when} | ' for r in GUARDS]
    page = rows_of_the_page()
    assert [line[: len(start)] for line, start in zip(page, expected)] == expected
    for line, row in zip(page, GUARDS):
        assert set(line.split(' | ')[2].removesuffix(' |').split(', ')) == {
            activity.value for activity in row.says
        }
    assert page[len(GUARDS) :] == [
        f'| `{r.behaviour.__name__}` | {words(r.says)} | {words(r.hands_over_to)} |'
        for r in ROUTINE
    ]
