"""The life of a managed node: which transition may be requested when."""

from __future__ import annotations

import pytest

from quad_common.lifecycle import TRANSITIONS, Lifecycle, LifeState, NotActive

PATHS = {
    LifeState.UNCONFIGURED: [],
    LifeState.INACTIVE: [1],
    LifeState.ACTIVE: [1, 3],
    LifeState.FINALIZED: [1, 3, 7],
}


def life_in(state):
    rests = []
    life = Lifecycle(lambda: rests.append(life.state))
    for number in PATHS[state]:
        assert life.change(number) is not None
    rests.clear()
    return life, rests


@pytest.mark.parametrize('state', LifeState)
@pytest.mark.parametrize('number', range(10))
def test_a_transition_leads_where_the_table_says_and_only_from_its_state(state, number):
    life, rests = life_in(state)
    matches = [t for t in TRANSITIONS if t.start is state and t.number == number]
    done = life.change(number)
    assert ([done] if done else []) == matches
    assert life.state is (matches[0].goal if matches else state)
    # The robot is to stand whenever the node was active and is no longer, and at no other time.
    was_active = state is LifeState.ACTIVE and bool(matches)
    assert rests == ([life.state] if was_active else [])


@pytest.mark.parametrize('state', LifeState)
def test_a_label_goes_before_the_number(state):
    life, _ = life_in(state)
    done = life.change(1, 'shutdown')
    assert (done is None) == (state is LifeState.FINALIZED)
    assert life.state is LifeState.FINALIZED
    assert life.change(0, 'nonsense') is None


def test_a_node_may_be_activated_again():
    life, _ = life_in(LifeState.ACTIVE)
    for label in ('deactivate', 'cleanup', 'configure', 'activate'):
        assert life.change(0, label).label == label
    assert life.state is LifeState.ACTIVE


def test_numbers_and_labels_are_those_of_the_messages():
    msg = pytest.importorskip('lifecycle_msgs.msg')
    for state in LifeState:
        assert getattr(msg.State, f'PRIMARY_STATE_{state.name}') == state
    for transition in TRANSITIONS:
        name = transition.label.upper()
        if name == 'SHUTDOWN':
            name = f'{transition.start.name}_{name}'
        assert getattr(msg.Transition, f'TRANSITION_{name}') == transition.number


def test_a_node_that_is_finalized_is_to_be_started_again():
    assert str(NotActive('gait_node', 'inactive')).endswith('configure, then activate)')
    assert str(NotActive('gait_node', 'finalized')) == (
        'gait_node is finalized: it does nothing any more; start it again'
    )
