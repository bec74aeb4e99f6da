"""Campaigns, walks and pools for tests, without a simulator."""

import math
import random

from quad_lab.campaigns.campaign_spec import CampaignSpec, Span, Tuning
from quad_lab.seeded_walks.walk_figures import WalkFigures
from quad_lab.seeded_walks.walk_task import Result

GRID = CampaignSpec(
    name='grid',
    description='',
    seed=3,
    walks=4,
    method='grid',
    fixed={'task': 'goal'},
    vary={'robot': ('titan_viii', 'cuhk'), 'friction': Span(0.4, 0.8, 3)},
)

TUNED = CampaignSpec(
    name='tuned',
    description='',
    seed=0,
    walks=1,
    method='grid',
    fixed={'task': 'steer', 'robot': 'cuhk', 'gait': 'trot'},
    vary={'engine': ('bullet', 'mujoco')},
    tuning=Tuning(
        spans={'gait.swing_height': Span(0.005, 0.03), 'gait.support_depth': Span(0.0, 0.5)},
        objective={'transport_cost': 1.0, 'tilt_rms': 1.0},
        limits={'drift': 0.1},
        population=6,
        generations=10,
    ),
)

BEST = {'gait.swing_height': 0.012, 'gait.support_depth': 0.1}
"""Where the cost of :func:`figures_of` is least."""


def figures_of(job):
    """Invent figures that depend on the job alone."""
    case = job.case
    away = sum(
        ((case.get(name, start) - best) / width) ** 2
        for name, best, start, width in (
            ('gait.swing_height', BEST['gait.swing_height'], 0.02, 0.025),
            ('gait.support_depth', BEST['gait.support_depth'], 0.3, 0.5),
        )
    )
    return WalkFigures(
        arrived=job.seed % 5 != 0 or 'engine' in case,
        problem='' if job.seed % 5 != 0 or 'engine' in case else 'tired',
        duration=job.seed / 7.0,
        tilt_rms=0.01 + away,
        transport_cost=0.3 + away,
        drift=0.2 if case.get('gait.support_depth', 0.3) > 0.4 else math.ldexp(1.0, -9),
    )


class ShuffledPool:
    """Answers in any order, and counts; after some walks it is interrupted."""

    def __init__(self, seed=0, most=10**9, lost_seeds=()):
        self._rng = random.Random(seed)
        self._most = most
        self._lost_seeds = lost_seeds
        self.lost = []
        self.walked = []

    def run(self, jobs):
        jobs = list(jobs)
        self._rng.shuffle(jobs)
        for job in jobs:
            if len(self.walked) >= self._most:
                raise KeyboardInterrupt
            if job.seed in self._lost_seeds:
                self.lost.append(job)
                continue
            self.walked.append(job)
            yield [Result(job, figures_of(job), 0.5)]
