"""The reproduce command draws a paper's figures and prints its numbers."""

import json

import numpy as np
import pytest

pytest.importorskip('matplotlib')

from quad_cli.main import main
from quad_cli.reproduce import PAPERS
from quad_lab.papers.s3 import SWEEPS


def test_s3_draws_its_figures_and_lists_every_posture_of_the_captions(capsys, tmp_path):
    assert main(['reproduce', 'S3', '--output', str(tmp_path / 'new'), '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told['pictures']) == 4
    assert {str(path) for path in (tmp_path / 'new').iterdir()} == set(told['pictures'])
    assert all(path.stat().st_size > 10_000 for path in (tmp_path / 'new').iterdir())
    given = [(row['input'], row['value']) for row in told['rows']]
    assert given[1:] == [
        ('hip i x [m]', -2.6),
        ('hip i x [m]', -0.76),
        ('hip i z [m]', 0.818),
        ('hip i z [m]', 0.978),
        ('u1 j [rad]', 0.18),
        ('u1 j [rad]', 0.3),
        ('u1 j [rad]', -0.16),
    ]
    # Leg i knows nothing of knee j but by the body's angle.
    knees = {row['u1 i [deg]'] for row in told['rows'] if row['input'] == 'u1 j [rad]'}
    assert len(knees) == 1
    for row in told['rows']:
        between = row['u2 i [deg]'] + row['theta [deg]']
        if row['input'] == 'u1 j [rad]':
            first = told['rows'][0]
            assert between == pytest.approx(first['u2 i [deg]'] + first['theta [deg]'], abs=0.01)


def test_people_are_told_a_table_and_where_the_pictures_are(capsys, tmp_path):
    assert main(['reproduce', 'S3', '--output', str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert told.count(f'drawn: {tmp_path}') == 4
    assert 'theta [deg]' in told
    assert 'chosen, as the paper has lost its own' in told


def test_a_paper_that_is_not_there_is_refused_with_those_that_are(capsys):
    with pytest.raises(SystemExit) as caught:
        main(['reproduce', 'S9'])
    assert caught.value.code == 2
    told = capsys.readouterr().err
    assert all(paper in told for paper in PAPERS)


def test_a_sweep_varies_one_input_only():
    for sweep in SWEEPS:
        posture = sweep.posture(sweep_values := np.linspace(*sweep.ends, 5))
        varying = [
            name
            for name, values in (
                ('x', posture.hip_i.real),
                ('z', posture.hip_i.imag),
                ('u1', posture.u1_j),
            )
            if values == pytest.approx(sweep_values)
        ]
        constant = [
            values
            for values in (posture.hip_i.real, posture.hip_i.imag, posture.u1_j)
            if values == pytest.approx(values[0])
        ]
        assert len(varying) == 1
        assert len(constant) == 2
