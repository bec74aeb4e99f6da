"""Dask computes what this process does, bit for bit, though a worker is killed meanwhile."""

import os
import signal

import pytest

pytest.importorskip('distributed')
pytest.importorskip('pyarrow')
pytest.importorskip('mujoco')

from quad_lab.campaigns.campaign_run import Unwatched, run_campaign
from quad_lab.campaigns.campaign_spec import CampaignSpec
from quad_lab.campaigns.replayed_walk import differing
from quad_lab.campaigns.result_store import ResultStore
from quad_lab.campaigns.walk_pool import InProcess, SchedulerNotReached, dask_pool

SPEC = CampaignSpec(
    name='short',
    description='',
    seed=0,
    walks=6,
    method='grid',
    fixed={'task': 'steer', 'robot': 'cuhk', 'gait': 'trot', 'engine': 'mujoco', 'duration': 2.0},
    vary={},
)


class Killer(Unwatched):
    """Kills a process when the first walks are over."""

    def __init__(self, victim):
        self.victims = [victim]

    def advance(self, results):
        while self.victims:
            os.kill(self.victims.pop(), signal.SIGKILL)


@pytest.mark.slow
def test_a_killed_worker_changes_nothing(tmp_path):
    expected = run_campaign(SPEC, ResultStore(tmp_path / 'here'), InProcess())
    with dask_pool(workers=2) as pool:
        assert pool.workers == 2
        assert pool.dashboard.startswith('http://127.0.0.1')
        victim, *_ = pool.on_every_worker(os.getpid).values()
        outcome = run_campaign(SPEC, ResultStore(tmp_path / 'there'), pool, Killer(victim))
    assert pool.lost == []
    assert len(outcome.results) == len(expected.results) == 6
    for one, other in zip(outcome.results, expected.results):
        assert one.job == other.job
        assert differing(one.figures, other.figures) == []


def test_a_scheduler_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setattr('quad_lab.campaigns.walk_pool._PATIENCE', 0.2)
    refused = pytest.raises(SchedulerNotReached, match=r'tcp://127\.0\.0\.1:9')
    with refused, dask_pool('tcp://127.0.0.1:9'):
        pass
