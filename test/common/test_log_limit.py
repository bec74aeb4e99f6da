"""What is logged of a stream of bad input."""

from quad_common.log_limit import LogLimit


def test_the_same_sentence_is_logged_once_in_ten_seconds():
    now = [0.0]
    limit = LogLimit(lambda: now[0])
    assert limit.lets('ERROR', 'no map')
    now[0] = 9.0
    assert not limit.lets('ERROR', 'no map')
    assert limit.lets('WARNING', 'no map')
    now[0] = 10.0
    assert limit.lets('ERROR', 'no map')


def test_of_sentences_that_differ_in_figures_a_few_are_logged():
    now = [0.0]
    limit = LogLimit(lambda: now[0])
    logged = 0
    for k in range(500):
        now[0] = 0.01 * k
        logged += limit.lets('ERROR', f'the body would have moved by {0.3 * k:.2f} m in 0.02 s')
    assert logged == 5
    assert limit.lets('ERROR', 'another thing is wrong')
    now[0] = 20.0
    assert limit.lets('ERROR', 'the body would have moved by 7.7 m in 0.02 s')


def test_of_nothing_but_different_sentences_not_all_are_logged():
    limit = LogLimit(lambda: 0.0)
    letters = 'abcdefghijklmnopqrstuvwxyz'
    assert sum(limit.lets('ERROR', a + b) for a in letters for b in letters) == 200
