"""Which cases of a sweep are run in every run of the tests."""

from itertools import product

import pytest
from sweeps import leave_out, spread


@pytest.mark.parametrize('count', [1, 2, 5, 16, 57])
@pytest.mark.parametrize('kept', [1, 2, 3, 5, 16])
def test_as_many_cases_are_chosen_as_are_to_be_kept_and_lie_apart(count, kept):
    chosen = sorted(spread(count, kept))
    assert len(chosen) == min(count, kept)
    assert 0 <= chosen[0] <= chosen[-1] < count
    if kept > 1 and count >= 2 * kept:
        assert chosen[-1] - chosen[0] >= count // 2


def test_of_a_product_each_value_of_each_parameter_is_chosen():
    cases = list(product('abcd', range(4)))
    chosen = [cases[k] for k in spread(len(cases), 4)]
    assert {first for first, _ in chosen} == set('abcd')
    assert {second for _, second in chosen} == set(range(4))


class Case:
    """One case of a test, with as many kept as its marker says; none for what is no sweep."""

    def __init__(self, function, kept=None):
        self.path, self.originalname = 'test_of.py', function
        self.marker = None if kept is None else pytest.mark.sweep(kept=kept).mark

    def get_closest_marker(self, name):
        """Return the marker of a sweep."""
        return self.marker if name == 'sweep' else None


def test_every_sweep_is_run_in_some_of_its_cases_and_what_is_none_in_all():
    # Cases of a fixture's parameter come one by one, among those of other tests.
    sweep, others = [Case('sweep', 2) for _ in range(9)], [Case('other') for _ in range(9)]
    items = [item for pair in zip(sweep, others) for item in pair]
    run, left_out = leave_out(items)
    assert [item for item in items if item in run] == run
    assert set(run) | set(left_out) == set(items)
    assert len(left_out) == 7
    assert set(left_out) < set(sweep)
    # One that was asked for by its name is run, whichever it is.
    assert leave_out([sweep[3]]) == ([sweep[3]], [])
