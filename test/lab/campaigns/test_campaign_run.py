"""A campaign has the same results in whatever order walks come, and however often it is ended."""

import errno
from dataclasses import replace

import pytest
from campaign_parts import BEST, GRID, TUNED, ShuffledPool, figures_of

from quad_common.errors import FileUnusable, QuadError
from quad_lab.campaigns import replayed_walk
from quad_lab.campaigns.campaign_run import run_campaign
from quad_lab.campaigns.jobs import jobs_of
from quad_lab.campaigns.replayed_walk import WalkNotFound, differing, find_walk
from quad_lab.campaigns.result_store import ResultStore
from quad_lab.campaigns.summary import markdown, summarise
from quad_lab.seeded_walks.walk_task import key_of

pytest.importorskip('pyarrow')


def same(one, other):
    return one.job == other.job and not differing(one.figures, other.figures)


def all_same(ones, others):
    return len(ones) == len(others) and all(same(a, b) for a, b in zip(ones, others))


def test_results_come_in_the_campaigns_order_whatever_theirs(tmp_path):
    one = run_campaign(GRID, ResultStore(tmp_path / 'a'), ShuffledPool(1))
    other = run_campaign(GRID, ResultStore(tmp_path / 'b'), ShuffledPool(2))
    assert [result.job for result in one.results] == jobs_of(GRID)
    assert all_same(one.results, other.results)


@pytest.mark.parametrize('spec', [GRID, TUNED])
def test_an_interrupted_campaign_goes_on_without_a_walk_twice(tmp_path, spec):
    pytest.importorskip('cma')
    whole = ShuffledPool()
    expected = run_campaign(spec, ResultStore(tmp_path / 'whole'), whole)
    first, second = ShuffledPool(1, most=11), ShuffledPool(2)
    with pytest.raises(KeyboardInterrupt):
        run_campaign(spec, ResultStore(tmp_path / 'parts'), first)
    outcome = run_campaign(spec, ResultStore(tmp_path / 'parts'), second)
    assert len(first.walked) == 11
    assert len(first.walked) + len(second.walked) == len(whole.walked)
    assert not {key_of(job) for job in first.walked} & {key_of(job) for job in second.walked}
    assert all_same(outcome.results, expected.results)
    assert outcome.tuned == expected.tuned


def test_a_campaign_that_is_over_walks_nothing(tmp_path):
    run_campaign(GRID, ResultStore(tmp_path), ShuffledPool())
    again = ShuffledPool()
    assert run_campaign(GRID, ResultStore(tmp_path), again).walked == 0
    assert again.walked == []


def test_what_is_kept_is_read_bit_for_bit(tmp_path):
    store = ResultStore(tmp_path)
    outcome = run_campaign(GRID, store, ShuffledPool())
    read = ResultStore(tmp_path).results
    assert all_same([read[key_of(result.job)] for result in outcome.results], outcome.results)


def test_small_files_become_one_and_lose_nothing(tmp_path):
    spec = replace(GRID, walks=30)
    run_campaign(spec, ResultStore(tmp_path), ShuffledPool())
    assert len(list(tmp_path.glob('*.parquet'))) < 64
    assert len(ResultStore(tmp_path).results) == 180


def test_a_file_that_was_not_finished_counts_for_nothing(tmp_path):
    run_campaign(GRID, ResultStore(tmp_path), ShuffledPool())
    path = next(tmp_path.glob('*.parquet'))
    path.rename(path.with_suffix('.part'))
    assert len(ResultStore(tmp_path).results) == len(jobs_of(GRID)) - 1


def test_results_that_cannot_be_written_leave_nothing_half_written(tmp_path, monkeypatch):
    store = ResultStore(tmp_path)

    def write_table(table, path):
        path.write_bytes(b'half')
        raise OSError(errno.ENOSPC, 'No space left on device')

    monkeypatch.setattr(store._parquet, 'write_table', write_table)
    with pytest.raises(FileUnusable, match='cannot be written: No space left on device'):
        run_campaign(GRID, store, ShuffledPool())
    assert list(tmp_path.iterdir()) == []


def test_a_damaged_file_is_named(tmp_path):
    (tmp_path / 'walks-1.parquet').write_bytes(b'nothing')
    with pytest.raises(FileUnusable, match=r'walks-1\.parquet holds no results'):
        ResultStore(tmp_path)


def test_a_campaign_goes_on_as_is_said_when_a_cut_file_is_moved_away(tmp_path):
    run_campaign(GRID, ResultStore(tmp_path / 'results'), ShuffledPool())
    path = sorted((tmp_path / 'results').glob('*.parquet'))[0]
    path.write_bytes(path.read_bytes()[:-100])
    said = 'once it is moved out of the folder the campaign goes on, and walks its walks again'
    with pytest.raises(FileUnusable, match=said):
        ResultStore(tmp_path / 'results')
    path.rename(tmp_path / path.name)
    outcome = run_campaign(GRID, ResultStore(tmp_path / 'results'), ShuffledPool())
    assert (len(outcome.results), outcome.walked) == (len(jobs_of(GRID)), 1)


def test_lost_walks_are_told_and_left_out(tmp_path):
    lost = jobs_of(GRID)[3]
    pool = ShuffledPool(lost_seeds={lost.seed})
    outcome = run_campaign(GRID, ResultStore(tmp_path), pool)
    assert pool.lost == [lost]
    assert lost not in [result.job for result in outcome.results]


def test_a_summary_counts_by_what_varies(tmp_path):
    outcome = run_campaign(GRID, ResultStore(tmp_path), ShuffledPool())
    summary = summarise(GRID, outcome)
    total, *groups = summary.groups
    failed = [job for job in jobs_of(GRID) if not figures_of(job).succeeded]
    assert (total.walks, total.succeeded) == (24, 24 - len(failed))
    assert [group.walks for group in groups] == [12, 12, 8, 8, 8]
    assert {failure.seed for failure in summary.failures} == {job.seed for job in failed}
    assert failed, 'the test needs some'
    text = markdown(summary)
    assert all(f'| {job.seed} |' in text for job in failed)
    assert '| `robot` | cuhk | 12 |' in text


def test_ranges_at_random_are_counted_in_parts(tmp_path):
    spec = replace(
        GRID, method='random', walks=40, vary={'friction': replace(GRID.vary['friction'], steps=0)}
    )
    groups = summarise(spec, run_campaign(spec, ResultStore(tmp_path), ShuffledPool())).groups
    assert [group.value for group in groups[1:]] == [
        '0.4 to 0.5', '0.5 to 0.6', '0.6 to 0.7', '0.7 to 0.8'
    ]  # fmt: skip
    assert sum(group.walks for group in groups[1:]) == 40


def test_a_tuning_finds_what_is_best_within_its_limits(tmp_path):
    pytest.importorskip('cma')
    outcome = run_campaign(TUNED, ResultStore(tmp_path), ShuffledPool())
    tuned = outcome.tuned
    assert tuned.numbers == pytest.approx(BEST, abs=0.05)
    assert tuned.before['gait.support_depth'] == pytest.approx(0.25)
    assert tuned.cost < 0.6
    before, after = tuned.figures['tilt_rms']
    assert after < before / 2.0
    assert len(tuned.history) == 10
    assert '| `gait.swing_height` |' in markdown(summarise(TUNED, outcome))


def test_a_tuning_needs_something_that_walks(tmp_path):
    pytest.importorskip('cma')
    spec = replace(TUNED, tuning=replace(TUNED.tuning, objective={'slip': 1.0}))
    with pytest.raises(QuadError, match='slip is nan untuned'):
        run_campaign(spec, ResultStore(tmp_path), ShuffledPool())


def test_a_walk_is_found_by_its_seed_and_by_its_key(tmp_path):
    outcome = run_campaign(GRID, ResultStore(tmp_path), ShuffledPool())
    wanted = outcome.results[5]
    for text in (str(wanted.job.seed), key_of(wanted.job)[:10]):
        job, kept = find_walk(GRID, tmp_path, text)
        assert job == wanted.job
        assert same(kept, wanted)
    job, kept = find_walk(GRID, tmp_path / 'nothing', str(wanted.job.seed))
    assert (job, kept) == (wanted.job, None)
    # Fewer characters would name a walk by chance, and none names all of them.
    for text in (key_of(wanted.job)[:5], ''):
        with pytest.raises(WalkNotFound, match='no walk of seed or key'):
            find_walk(GRID, tmp_path, text)


def test_a_key_that_begins_with_digits_alone_is_no_seed(tmp_path, monkeypatch):
    jobs = jobs_of(GRID)

    def digits(job):
        return f'99247{jobs.index(job):05d}abcdef'

    monkeypatch.setattr(replayed_walk, 'key_of', digits)
    wanted = jobs[5]
    assert find_walk(GRID, tmp_path / 'nothing', digits(wanted)[:10]) == (wanted, None)
    assert find_walk(GRID, tmp_path / 'nothing', str(wanted.seed)) == (wanted, None)


def test_a_seed_of_several_candidates_needs_the_key(tmp_path):
    pytest.importorskip('cma')
    outcome = run_campaign(TUNED, ResultStore(tmp_path), ShuffledPool())
    wanted = outcome.results[-1]
    with pytest.raises(WalkNotFound, match='give one by its key'):
        find_walk(TUNED, tmp_path, str(wanted.job.seed))
    assert find_walk(TUNED, tmp_path, key_of(wanted.job))[0] == wanted.job


def test_figures_differ_by_one_bit():
    job = jobs_of(GRID)[1]
    figures = figures_of(job)
    assert differing(figures, figures_of(job)) == []
    assert differing(figures, replace(figures, duration=figures.duration * (1 + 2**-52))) == [
        'duration'
    ]
