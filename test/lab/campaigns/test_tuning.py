"""A tuning comes to its end whatever its walks cost, and wherever it begins."""

from dataclasses import replace

import numpy as np
import pytest
from campaign_parts import BEST, TUNED, figures_of

pytest.importorskip('cma')

from quad_lab.campaigns.campaign_spec import Span
from quad_lab.campaigns.tuning import Tuner
from quad_lab.seeded_walks.walk_figures import WalkFigures
from quad_lab.seeded_walks.walk_task import Result, key_of

NAME = 'gait.swing_height'


def spec_of(spans, generations=6):
    tuning = replace(TUNED.tuning, spans=spans, generations=generations)
    return replace(TUNED, vary={}, tuning=tuning)


def fallen(job):
    """Fail with any change."""
    return WalkFigures(problem='it fell') if NAME in job.case else figures_of(job)


def unchanged(job):
    """Cost the same whatever is changed."""
    return figures_of(replace(job, case={'engine': 'bullet'}))


def arrived(job):
    """Cost more the farther away from the best."""
    return replace(figures_of(job), arrived=True, problem='')


def rising(job):
    """Cost less the lower the number is."""
    return replace(arrived(job), tilt_rms=1.0 + job.case.get(NAME, 0.0))


def tune(spec, figures):
    """Tune to the end; return the tuner and the numbers of all candidates, by generations."""
    tuner = Tuner(spec, spec.tuning)
    tuner.take_baseline([Result(job, arrived(job), 0.5) for job in tuner.baseline.jobs])
    asked = []
    while (candidates := tuner.ask()) is not None:
        asked.append([dict(candidate.numbers) for candidate in candidates])
        jobs = [job for candidate in candidates for job in candidate.jobs]
        tuner.tell({key_of(job): Result(job, figures(job), 0.5) for job in jobs})
    return tuner, asked


SPANS = {
    'around what is untuned': Span(0.005, 0.03),
    'below what is untuned': Span(0.001, 0.006),
    'above what is untuned': Span(0.5, 1.0),
}


@pytest.mark.parametrize('span', SPANS.values(), ids=SPANS)
@pytest.mark.parametrize('figures', [fallen, unchanged, arrived, rising])
def test_one_number_is_tuned_to_the_end(span, figures):
    tuner, asked = tune(spec_of({NAME: span}), figures)
    assert [len(costs) for costs in tuner.outcome().history] == [6] * 6
    numbers = [candidate for generation in asked for candidate in generation]
    assert all(set(candidate) == {NAME} for candidate in numbers)
    assert all(span.lower <= candidate[NAME] <= span.upper for candidate in numbers)
    assert len({candidate[NAME] for candidate in numbers}) > 6
    if figures is fallen:
        assert tuner.outcome().cost == 1.0


def test_one_number_is_found():
    tuned = tune(spec_of({NAME: Span(0.005, 0.03)}, 10), arrived)[0].outcome()
    assert tuned.numbers == pytest.approx({NAME: BEST[NAME]}, abs=1e-3)


def test_several_numbers_are_drawn_as_cma_draws_them_in_as_many_dimensions():
    cma = pytest.importorskip('cma')
    spans = TUNED.tuning.spans
    tuner, asked = tune(spec_of(spans), arrived)
    names = sorted(spans)
    lower = np.array([spans[name].lower for name in names])
    widths = np.array([spans[name].upper for name in names]) - lower
    start = ([tuner.outcome().before[name] for name in names] - lower) / widths
    options = {'seed': TUNED.seed + 1, 'bounds': [0.0, 1.0], 'popsize': 6, 'verbose': -9}
    plain = cma.CMAEvolutionStrategy(start.tolist(), 0.25, options)
    for generation, costs in zip(asked, tuner.outcome().history):
        drawn = plain.ask()
        numbers = [[candidate[name] for name in names] for candidate in generation]
        np.testing.assert_allclose(numbers, lower + np.array(drawn) * widths, rtol=1e-3)
        plain.tell(drawn, list(costs))
