"""Ways out of where strides over uneven ground lead nowhere: their order, and their end."""

import math

import pytest

from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.following.step import Step
from quad_gait.uneven.ways_out import ORDER, Chosen, WayOut, WaysOut

STRIDE = 0.25
AHEAD = Step(is_turn=False, motion=BodyMotion(forward=0.2))
TURN = Step(is_turn=True, motion=BodyMotion(turn=0.5))
BLIND = [way for way in ORDER if way is not WayOut.FOOTSTEPS]
"""Ways out where there is no height map."""


def failed(times, step=AHEAD):
    """Return ways out after so many strides that could not be made, each taken."""
    ways = WaysOut(STRIDE)
    taken = []
    for number in range(times):
        assert ways.fail(f'problem {number}')
        taken.append(ways.next)
        done = ways.take(step)
    return ways, taken, done


def test_each_way_is_tried_once_and_in_the_stated_order():
    ways, taken, _ = failed(len(BLIND))
    assert taken == [WayOut.SHORTER, WayOut.LONGER, WayOut.BACK, WayOut.DETOUR]
    assert not ways.fail('one more')
    assert ways.problem == 'one more'


def test_over_a_height_map_footsteps_are_planned_before_another_path_is_asked_for():
    ways = WaysOut(STRIDE)
    ways.knows_ground = True
    for _ in range(3):
        assert ways.fail('no swing')
        assert not ways.take(AHEAD).is_planned
    assert ways.fail('no swing')
    assert ways.next is WayOut.FOOTSTEPS
    chosen = ways.take(AHEAD)
    assert chosen.is_planned
    assert chosen.remark.endswith(f'is tried (4 of {len(ORDER)}): no swing')
    assert ways.is_stepping
    # They are planned again and again, though not for ever.
    plans = 0
    while ways.is_stepping:
        assert ways.fail('no swing onto this foothold')
        assert ways.next is None
        plans += 1
        assert plans < 100
    assert ways.fail('no footsteps')
    assert ways.next is WayOut.DETOUR


@pytest.mark.parametrize(
    ('limit', 'is_strained', 'has_map', 'is_planned'),
    [
        ('a step was shortened', True, True, True),
        ('a step was shortened', False, True, False),
        ('', True, True, False),
        ('a step was shortened', True, False, False),
    ],
)
def test_after_a_stride_that_was_cut_short_far_feet_are_brought_back_by_footsteps(
    limit, is_strained, has_map, is_planned
):
    """A robot turned on a kerb until no foot could be lifted any more: each stride got on a bit."""
    ways = WaysOut(STRIDE)
    ways.knows_ground, ways.left = has_map, 1.0
    assert ways.choose(TURN) == Chosen(TURN)
    ways.left = 0.8
    chosen = ways.choose(TURN, limit, is_strained)
    assert chosen.is_planned == ways.is_stepping == is_planned
    assert chosen.step == TURN
    # Once they are planned there is nothing to choose.
    ways.left = 0.6
    assert not ways.choose(TURN, limit, is_strained).is_planned


def test_strides_take_over_where_footsteps_have_led():
    ways = WaysOut(STRIDE)
    ways.knows_ground = True
    for _ in range(4):
        ways.fail('no swing')
        ways.take(AHEAD)
    ways.end_footsteps()
    assert not ways.is_stepping
    assert ways.fail('no swing')
    assert ways.next is WayOut.DETOUR


@pytest.mark.parametrize('step', [AHEAD, TURN])
def test_strides_are_changed_as_they_are_said_to_be(step):
    size = {}
    for times in (1, 2):
        _, taken, (changed, remark, *_) = failed(times, step)
        assert remark.startswith(f'{taken[-1].value} is tried ({times} of {len(BLIND)}): problem')
        assert changed.is_turn == step.is_turn
        size[taken[-1]] = changed.motion.forward / 0.2 + changed.motion.turn / 0.5
    assert size[WayOut.SHORTER] < 1.0 < size[WayOut.LONGER]
    _, _, (back, *_) = failed(3, step)
    assert -STRIDE < back.motion.forward < 0.0
    assert back.motion.turn == 0.0


def test_nothing_is_changed_where_strides_get_on():
    ways = WaysOut(STRIDE)
    for stride in range(100):
        assert ways.note_left(30.0 - 0.2 * stride)
        assert ways.take(AHEAD) == Chosen(AHEAD)


def test_turns_to_and_fro_end():
    ways = WaysOut(STRIDE)
    strides = 0
    while ways.note_left(1.0 + 0.2 * math.sin(strides)):
        ways.take(TURN)
        strides += 1
        assert strides < 100
    assert strides > len(BLIND)
    assert 'no nearer to its goal' in ways.problem


def test_a_stride_that_was_kept_short_and_led_nowhere_is_answered_at_once():
    ways = WaysOut(STRIDE)
    assert ways.note_left(1.0)
    assert ways.note_left(1.0, limit='a step was shortened')
    assert ways.next is WayOut.SHORTER


def test_strides_that_get_on_grow_again_and_all_ways_are_open_again():
    ways, _, (short, *_) = failed(1)
    sizes = [short.motion.forward]
    for stride in range(5):
        assert ways.note_left(10.0 - 0.2 * stride)
        sizes.append(ways.take(AHEAD)[0].motion.forward)
    assert sizes == sorted(sizes)
    assert sizes[-1] == AHEAD.motion.forward
    assert ways.fail('again')
    assert ways.next is WayOut.SHORTER


def test_a_detour_is_asked_for_in_the_place_of_a_step():
    ways = WaysOut(STRIDE)
    ways.left = 1.0
    for _ in BLIND:
        ways.choose(AHEAD)
        ways.fail('no footing')
    assert ways.choose(AHEAD) == Chosen(AHEAD, is_detour=True)


def test_nothing_is_chosen_once_no_way_out_is_left():
    ways = WaysOut(STRIDE)
    ways.left = 1.0
    chosen = []
    while (step := ways.choose(AHEAD)) is not None:
        chosen.append(step)
        if step.is_detour:
            ways.take(AHEAD)
        assert len(chosen) < 100
    assert [step.is_detour for step in chosen].count(True) == 1


def test_footsteps_have_led_on_after_two_strides():
    ways = WaysOut(STRIDE)
    ways.knows_ground, ways.left = True, 2.0
    assert not ways.has_stepped_on
    assert ways.choose(AHEAD, 'a step was shortened', is_strained=True).is_planned
    for done, has_stepped_on in [(0.0, False), (1.9, False), (2.1, True)]:
        ways.left = 2.0 - done * STRIDE
        assert ways.has_stepped_on == has_stepped_on
    ways.reset()
    assert not ways.has_stepped_on


def test_footsteps_that_lead_nowhere_are_not_planned_early_for_ever():
    ways = WaysOut(STRIDE)
    ways.knows_ground, ways.left = True, 0.4
    planned = 0
    for _ in range(40):
        chosen = ways.choose(TURN, 'a step was shortened', is_strained=True)
        if chosen is None or chosen.is_detour:
            break
        planned += chosen.is_planned
        ways.end_footsteps()
    else:
        pytest.fail('no end')
    assert planned <= 3
