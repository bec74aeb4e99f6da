"""
Checks of a campaign as a whole, before its first walk: its size, and what its values name.

Combinations are never listed here, of which there may be a million: values were checked one by
one, and few of them bear on one another.
"""

from __future__ import annotations

import math
from itertools import product
from typing import Any

from quad_common.errors import ParameterError, TooManyWalks
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.gait import load_gait
from quad_lab.campaigns.campaign_spec import CampaignSpec
from quad_lab.campaigns.jobs import listed
from quad_lab.seeded_walks.scene import RANDOM, map_path
from quad_lab.seeded_walks.walk_settings import WalkSettings, walk_of
from quad_sim.engines.registry import ENGINES
from quad_sim.world.terrain_spec import specs_from_text

MOST_WALKS = 1_000_000
"""Largest number of walks of a campaign."""


def check_campaign(spec: CampaignSpec) -> None:
    """
    Check that a campaign can be walked.

    Parameters
    ----------
    spec : CampaignSpec
        The campaign, each of whose values is valid by itself.

    Raises
    ------
    TooManyWalks
        If a grid has too many.
    QuadError
        If there is no such robot, gait, map, ground or engine, or two values exclude each other.
    """
    _check_count(spec)
    values = {name: _values(spec, name) for name in vars(WalkSettings())}
    # Of all pairs of lengths the one that fits least, with the first of all other values.
    walk_of({
        **spec.fixed,
        **{name: listed(choices)[0] for name, choices in spec.vary.items()},
        'shortest': max(values['shortest']),
        'longest': min(values['longest']),
    })  # fmt: skip
    robots = [load_robot(name) for name in values['robot']]
    for robot, gait in product(robots, values['gait']):
        load_gait(gait, robot)
    if 'goal' in values['task']:
        for name in values['map']:
            if name != RANDOM:
                map_path(name)
    for text in values['terrain']:
        specs_from_text(text)
    for engine in values['engine']:
        if not ENGINES[engine].is_installed:
            package = ENGINES[engine].package
            raise ParameterError('engine', engine, f'installed: pip install {package}')


def _check_count(spec: CampaignSpec) -> None:
    """Refuse too large a grid; a campaign at random has the walks that it says."""
    if spec.method == 'random':
        return
    count = math.prod(len(listed(choices)) for choices in spec.vary.values())
    if count * spec.walks > MOST_WALKS:
        raise TooManyWalks(count, spec.walks, MOST_WALKS)


def _values(spec: CampaignSpec, name: str) -> tuple[Any, ...]:
    """Return all values that one of the settings has; ranges at random are taken at both ends."""
    if name in spec.vary:
        return listed(spec.vary[name])
    return (spec.fixed.get(name, getattr(WalkSettings(), name)),)
