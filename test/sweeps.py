"""
Laws that are asserted in many cases: a few of them in every run, all where they are asked for.

A test with the marker ``sweep(kept)`` is run in so many of its cases, spread over all of them; with
``--sweeps`` in every one.
"""

from collections import defaultdict


def spread(count, kept):
    """
    Choose cases that lie apart.

    Where cases are a product of parameters the last one changes from case to case: steps that
    are one longer than a row of them go through its values, too.

    Parameters
    ----------
    count : int
        Number of cases.
    kept : int
        Number of cases to choose.

    Returns
    -------
    set of int
        Their indices; all where there are no more.
    """
    if kept >= count:
        return set(range(count))
    step = count / kept
    return {int(k * step) + k % int(step) for k in range(kept)}


def leave_out(items):
    """Return the items to run, and those of sweeps that are left out; both in their order."""
    cases = defaultdict(list)
    for item in items:
        if item.get_closest_marker('sweep') is not None:
            cases[item.path, item.originalname].append(item)
    left_out = set()
    for each in cases.values():
        kept = spread(len(each), each[0].get_closest_marker('sweep').kwargs['kept'])
        left_out.update(item for k, item in enumerate(each) if k not in kept)
    run = [item for item in items if item not in left_out]
    return run, [item for item in items if item in left_out]
