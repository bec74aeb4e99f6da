"""The commands about campaigns: what they write, say and return."""

import json
from types import SimpleNamespace

import pytest

pytest.importorskip('pyarrow')
pytest.importorskip('mujoco')

from quad_cli.campaigns import replay_walk
from quad_cli.main import main
from quad_lab.campaigns.campaign_run import run_campaign
from quad_lab.campaigns.jobs import jobs_of
from quad_lab.campaigns.result_store import ResultStore
from quad_lab.campaigns.spec_file import load_campaign
from quad_lab.campaigns.walk_pool import InProcess

TEXT = """
name: short
walks: 1
fixed: {task: steer, robot: cuhk, gait: trot, engine: mujoco, duration: 2.0}
vary: {friction: [0.6, 0.8]}
"""


@pytest.fixture(scope='module')
def campaign(tmp_path_factory):
    """Return a campaign's file and its folder, in which every walk is there."""
    folder = tmp_path_factory.mktemp('campaign')
    path = folder / 'short.yaml'
    path.write_text(TEXT, encoding='utf-8')
    run_campaign(load_campaign(path), ResultStore(folder / 'out' / 'results'), InProcess())
    return path, folder / 'out'


def test_what_is_there_is_summed_up_without_a_cluster(campaign, capsys):
    path, folder = campaign
    assert main(['campaign', str(path), '--output', str(folder), '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    assert [group['walks'] for group in told['groups']] == [2, 1, 1]
    assert told['failures'] == []
    assert json.loads((folder / 'summary.json').read_text()) == told
    assert '| `friction` | 0.6 | 1 | 1 |' in (folder / 'summary.md').read_text()
    assert (folder / 'summary.png').stat().st_size > 5000


def test_a_walk_is_run_again_bit_for_bit(campaign, capsys):
    path, folder = campaign
    seed = str(jobs_of(load_campaign(path))[1].seed)
    arguments = ['replay-walk', str(path), seed, '--output', str(folder)]
    assert main([*arguments, '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told['seed'], told['kept'], told['different']) == (int(seed), True, [])
    assert told['figures']['succeeded']
    assert main(arguments) == 0
    assert 'bit for bit' in capsys.readouterr().out


def test_a_walk_in_a_window_takes_as_long_as_it_simulates():
    waited = []

    class Clock:
        now = 100.0

        def monotonic(self):
            return self.now

        def sleep(self, duration):
            waited.append(duration)
            self.now += duration

    loop = SimpleNamespace(on_observation=[])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(replay_walk, 'time', Clock())
        replay_walk.in_real_time(loop)
        for time in (0.0, 0.02, 0.04):
            loop.on_observation[0](SimpleNamespace(time=time))
    assert waited == pytest.approx([0.0, 0.02, 0.02])


@pytest.mark.parametrize(
    ('arguments', 'said'),
    [
        (['campaign', 'atlantis'], 'reliability'),
        (['replay-walk', 'reliability', '1'], 'no walk of seed'),
    ],
)
def test_a_fault_ends_a_command_with_one_sentence(arguments, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert told.startswith('error: ')
    assert said in told
    assert told.count('\n') == 1
