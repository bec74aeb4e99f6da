"""
Finds one walk of a campaign by its seed or its key, and compares figures bit for bit.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, fields
from pathlib import Path

from quad_common.errors import QuadError
from quad_common.errors.quoting import quoted
from quad_lab.campaigns.campaign_spec import CampaignSpec
from quad_lab.campaigns.jobs import jobs_of
from quad_lab.campaigns.result_store import ResultStore
from quad_lab.seeded_walks.walk_figures import WalkFigures
from quad_lab.seeded_walks.walk_task import Job, Result, key_of

_LEAST_KEY = 6
"""Characters of a key that name a walk at least: fewer would be met by chance."""


@dataclass(eq=False, repr=False)
class WalkNotFound(QuadError):
    """A campaign has no such walk, or several."""

    campaign: str
    """Name of the campaign."""
    walk: str
    """Seed or key that was given."""
    found: tuple[str, ...]
    """Keys of the walks that it may mean."""

    def sentence(self) -> str:
        """Say what would find it."""
        if self.found:
            keys = ', '.join(key[:12] for key in self.found[:5])
            return (
                f'{len(self.found)} walks of {self.campaign} have {quoted(self.walk)}: give one by '
                f'its key, {keys}{", ..." if len(self.found) > 5 else ""}'
            )
        return (
            f'{self.campaign} has no walk of seed or key {quoted(self.walk)} (of a key at least '
            f"{_LEAST_KEY} characters); summary.json in the campaign's folder has those of failed "
            f'walks, results those of all'
        )


def find_walk(spec: CampaignSpec, folder: Path, walk: str) -> tuple[Job, Result | None]:
    """
    Find a walk.

    Parameters
    ----------
    spec : CampaignSpec
        The campaign.
    folder : Path
        Its results, which need not be there unless it tunes.
    walk : str
        Seed of the walk, or beginning of the key of its result, of at least six characters. A key
        may begin with digits alone: what is no seed of the campaign is looked for among keys.

    Returns
    -------
    Job
        The walk.
    Result or None
        What was kept of it, if it was.

    Raises
    ------
    WalkNotFound
        If there is none, or several.
    """
    kept = ResultStore(folder).results if folder.is_dir() else {}
    jobs = {} if spec.tuning is not None else {key_of(job): job for job in jobs_of(spec)}
    jobs = {**{key: result.job for key, result in kept.items()}, **jobs}
    found = [key for key, job in jobs.items() if str(job.seed) == walk]
    if not found and len(walk) >= _LEAST_KEY:
        found = [key for key in jobs if key.startswith(walk)]
    # Results of other code stay in the folder: the campaign's own walk is the one that is meant.
    own = [key for key in found if key == key_of(jobs[key])] or found
    if len(own) != 1:
        raise WalkNotFound(spec.name, walk, tuple(own))
    return jobs[own[0]], kept.get(own[0])


def differing(figures: WalkFigures, others: WalkFigures) -> list[str]:
    """Return the names of the figures of two walks that are not the same, bit for bit."""
    return [
        item.name
        for item in fields(figures)
        if _bits(getattr(figures, item.name)) != _bits(getattr(others, item.name))
    ]


def _bits(value: bool | float | str) -> object:
    return struct.pack('<d', value) if isinstance(value, float) else value
