"""The reproduce command measures a paper, and writes its page."""

import json

import numpy as np
import pytest

pytest.importorskip('matplotlib')

from quad_cli.main import main
from quad_lab.papers.reproduction import PAPERS
from quad_lab.papers.s3 import SWEEPS


def test_s3_draws_its_figures_and_finds_every_posture_of_the_captions(capsys, tmp_path):
    assert main(['reproduce', 'S3', '--output', str(tmp_path / 'new'), '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    (part,) = told['parts'].values()
    assert told['failures'] == []
    pictures = {path.name for path in (tmp_path / 'new' / 'reproduction').iterdir()}
    assert pictures == {'s3_fig_8.png', 's3_fig_9.png', 's3_fig_10.png'}
    found = [(row['what'], row['there'], row['here']) for one in part[1:] for row in one['rows']]
    assert [(what, value) for what, value, _ in found] == [
        ('hip i x', -2.6),
        ('hip i x', -0.76),
        ('hip i z', 0.818),
        ('hip i z', 0.978),
        ('u1 j', 0.18),
        ('u1 j', 0.3),
        ('u1 j', -0.16),
    ]
    assert [here for _, _, here in found] == pytest.approx([value for _, value, _ in found])
    # Leg i knows nothing of knee j but by the body's angle.
    knees = {
        row['reason'].split('u1 and u2 of i ')[1].split(' ')[0]
        for row in part[2]['rows']
        if row['what'] == 'u1 j'
    }
    assert len(knees) == 1


def test_people_are_told_a_table_and_where_the_page_is(capsys, tmp_path):
    assert main(['reproduce', 'S3', '--quick', '--output', str(tmp_path)]) == 0
    told = capsys.readouterr().out
    page = tmp_path / 'reproduction.md'
    assert f'written: {page}' in told.replace('\n', '')
    assert 'rows: 0 better, 8 equal, 0 worse' in told
    assert '## Marin (S3)' in page.read_text(encoding='utf-8')


def test_a_paper_that_is_not_there_is_refused_with_those_that_are(capsys):
    with pytest.raises(SystemExit) as caught:
        main(['reproduce', 'S9'])
    assert caught.value.code == 2
    told = capsys.readouterr().err
    assert all(paper in told for paper in (*PAPERS, 'all'))


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
