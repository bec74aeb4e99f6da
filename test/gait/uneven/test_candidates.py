"""Of what is tried of a motion the first that works is taken, and the first fault is said."""

import pytest

from quad_common.errors import FootholdNotFound, GaitError
from quad_gait.uneven.candidates import first_possible

KINDS = [(float(k),) for k in range(6)]


def planner(possible):
    planned = []

    def plan(kind):
        planned.append(kind)
        if kind not in possible:
            raise FootholdNotFound('lf', kind)
        return kind

    return plan, planned


@pytest.mark.parametrize('possible', [(0.0,), (3.0, 4.0), (5.0,), ()])
def test_a_quick_look_changes_nothing_but_how_many_are_planned(possible):
    found = []
    for look in (None, lambda kind: kind in possible):
        plan, planned = planner(possible)
        try:
            got, problem = first_possible(plan, KINDS, look)
        except GaitError as error:
            got, problem = None, error
        found.append((got, None if problem is None else problem.depth, planned))
    slow, quick = found
    assert slow[:2] == quick[:2]
    # The first is planned in any case: it is said what was wrong with it.
    assert quick[2] == [0.0, *[kind for kind in possible[:1] if kind > 0.0]]
