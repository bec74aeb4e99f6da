"""
Which walks a campaign has, and their seeds.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from itertools import product

import numpy as np

from quad_common.parameters import Value
from quad_lab.campaigns.campaign_spec import CampaignSpec, Span
from quad_lab.seeded_walks.walk_settings import Case
from quad_lab.seeded_walks.walk_task import Job

_SEEDS = 2**31

_DRAWS = 9
"""Stream of a seed that values are drawn with; the walk has others."""


def combinations(spec: CampaignSpec) -> list[dict[str, Value]]:
    """
    Return the combinations of a grid.

    Parameters
    ----------
    spec : CampaignSpec
        The campaign; of one at random, ranges are taken at both ends.

    Returns
    -------
    list of dict
        Cases, without what is tuned.
    """
    lists = [listed(values) for values in spec.vary.values()]
    return [_sorted({**spec.fixed, **dict(zip(spec.vary, values))}) for values in product(*lists)]


def jobs_of(spec: CampaignSpec) -> list[Job]:
    """
    Return the walks of a campaign that tunes nothing.

    Parameters
    ----------
    spec : CampaignSpec
        The campaign.

    Returns
    -------
    list of Job
        Each has a seed of its own, which follows from what the walk is and how often it was there
        before: walks that are added to a campaign change no others. One walk of every combination
        comes before the second one of any.
    """
    used: set[int] = set()
    if spec.method == 'random':
        seeds = [_own_seed(spec, {}, number, used) for number in range(spec.walks)]
        return [Job(_drawn(spec, seed), seed) for seed in seeds]
    cases = combinations(spec)
    return [
        Job(case, _own_seed(spec, case, number, used))
        for number in range(spec.walks)
        for case in cases
    ]


def seed_of(spec: CampaignSpec, case: Case, number: int) -> int:
    """Return the seed of the so-many-th walk of a case; two walks in a billion have the same."""
    said = json.dumps([spec.seed, dict(case), number], sort_keys=True)
    return int.from_bytes(hashlib.sha256(said.encode()).digest()[:8], 'big') % _SEEDS


def listed(values: tuple[Value, ...] | Span) -> tuple[Value, ...]:
    """Return the values of a list, the steps of a range, or both ends of one without steps."""
    if not isinstance(values, Span):
        return values
    return values.values if values.steps else (values.lower, values.upper)


def _own_seed(spec: CampaignSpec, case: Case, number: int, used: set[int]) -> int:
    seed = seed_of(spec, case, number)
    while seed in used:
        seed = (seed + 1) % _SEEDS
    used.add(seed)
    return seed


def _drawn(spec: CampaignSpec, seed: int) -> dict[str, Value]:
    rng = np.random.default_rng((seed, _DRAWS))
    values: dict[str, Value] = {}
    for name in sorted(spec.vary):
        choices = spec.vary[name]
        if isinstance(choices, Span):
            values[name] = float(rng.uniform(choices.lower, choices.upper))
        else:
            values[name] = choices[int(rng.integers(len(choices)))]
    return _sorted({**spec.fixed, **values})


def _sorted(case: Mapping[str, Value]) -> dict[str, Value]:
    return {name: case[name] for name in sorted(case)}
