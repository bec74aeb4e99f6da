"""Papers beside this code: verdicts, files, and a page that the command would write again."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip('matplotlib')

from quad_common.errors import FileUnusable
from quad_common.process.end_signals import Interrupted
from quad_lab.papers import reproduction
from quad_lab.papers.comparison import (
    UNEXPLAINED,
    Exhibit,
    Part,
    at_least,
    at_most,
    less,
    more,
    same,
    words,
)
from quad_lab.papers.page import FOLDER, page_text
from quad_lab.papers.results import Results, read_results

DOCS = Path(__file__).resolve().parents[3] / 'docs'

WANTED = {
    'S0': [f'Fig. {n}' for n in (6, 7, 8, 10, 11, 15, 16, 17, 18)],
    'S1': [*(f'Fig. {n}' for n in range(5, 11)), 'Table I', 'Table II', 'Table III'],
    'S2': [*(f'Fig. {n}' for n in (8, 9, 10)), *(f'Table {n}' for n in ('I', 'II', 'III', 'IV'))],
    'S3': [f'Fig. {n}' for n in (8, 9, 10)],
    'S4': [f'Fig. {n}' for n in range(4, 12)],
}
"""What the papers show of results."""


@pytest.fixture(scope='module')
def published():
    return read_results(DOCS / reproduction.NUMBERS)


@pytest.fixture(scope='module')
def quick():
    parts = reproduction.parts_of(reproduction.PAPERS, quick=True)
    return {reproduction.key_of(part): part.measure() for part in parts}


@pytest.mark.parametrize(
    ('row', 'verdict', 'difference'),
    [
        (same('length', 215.7, 215.704, 'mm', 0.05), 'equal', '0.0'),
        (same('length', 215.7, 215.9, 'mm', 0.05), 'worse', '+0.2'),
        (same('length', 215.7, 215.5, 'mm', 0.05), 'worse', '-0.2'),
        (less('error', 9.0, 2.0, 'mm'), 'better', '-7.0'),
        (less('error', 9.0, 9.04, 'mm'), 'equal', '0.0'),
        (less('error', 9.0, 9.2, 'mm'), 'worse', '+0.2'),
        (more('stride', 60.0, 75.0, 'mm', 0), 'better', '+15'),
        (more('stride', 60.0, 59.0, 'mm', 0), 'worse', '-1'),
        (at_most('error', 'zero', 0.9, '%', 1.0), 'equal', 'holds'),
        (at_most('error', 'zero', 1.1, '%', 1.0), 'worse', 'does not hold'),
        (at_least('margin', 'inside', 0.0, 'mm', 0.0), 'equal', 'holds'),
        (at_least('margin', 'inside', -0.1, 'mm', 0.0), 'worse', 'does not hold'),
        (words('order', '3 1 4 2', '3 1 4 2'), 'equal', 'none'),
        (words('order', '3 1 4 2', '4 2 3 1'), 'worse', 'differs'),
        (same('length', 215.7, math.nan, 'mm', 0.05), 'worse', ''),
        (at_least('margin', 'inside', math.inf, 'mm', 0.0), 'worse', ''),
    ],
)
def test_a_row_says_what_is_better_and_by_how_much(row, verdict, difference):
    assert (row.verdict, row.difference) == (verdict, difference)


def test_a_row_that_is_worse_without_a_reason_fails_and_one_without_a_number_too():
    bad = same('a', 1.0, 2.0, '', 0.1)
    rows = (
        bad,
        bad.because('the paper rounds'),
        same('b', 1.0, math.nan, '', 0.1),
        words('c', 'x', 'x'),
    )
    part = reproduction.shown_exhibits([Exhibit('S0', 'Fig. 6', 'graph', rows)])
    told = reproduction.failures(Results({'S0, paths': part}))
    assert told == [f'S0 Fig. 6, a: {UNEXPLAINED}', 'S0 Fig. 6, b: not measured']


def test_results_come_back_from_their_file(tmp_path, quick):
    results = Results({key: reproduction.shown_exhibits(part) for key, part in quick.items()})
    (tmp_path / 'numbers.json').write_text(results.text(), encoding='utf-8')
    again = read_results(tmp_path / 'numbers.json')
    assert again == results
    assert read_results(tmp_path / 'nothing.json') == Results({})


@pytest.mark.parametrize(
    'text',
    [
        '[]',
        '{"S0, paths": 3}',
        '{"S0, paths": [{}]}',
        'nonsense',
        '{"S0, paths": [{"paper": "S0", "label": 6, "title": "", "note": "", "rows": []}]}',
        '[' * 100_000,
    ],
    ids=['a list', 'a number', 'no fields', 'no JSON', 'a label that is a number', 'deep'],
)
def test_another_file_in_the_place_of_the_numbers_is_refused_and_kept(tmp_path, text):
    (tmp_path / reproduction.NUMBERS).write_text(text, encoding='utf-8')
    with pytest.raises(FileUnusable, match='is not what quadwalk reproduce has written'):
        reproduction.reproduce(['S3'], tmp_path, True, lambda line: None)
    assert (tmp_path / reproduction.NUMBERS).read_text(encoding='utf-8') == text


def test_a_verdict_that_was_written_by_hand_is_refused(tmp_path, published):
    document = json.loads(published.text())
    row = document['S1, leg'][1]['rows'][2]
    assert row['verdict'] == 'worse'
    row['verdict'] = 'better'
    (tmp_path / 'numbers.json').write_text(json.dumps(document), encoding='utf-8')
    with pytest.raises(FileUnusable):
        read_results(tmp_path / 'numbers.json')


def test_what_needs_no_physics_comes_out_as_published(published, quick):
    assert len(quick) >= 6
    for key, exhibits in quick.items():
        ours = [(e.paper, e.label, e.title, e.note) for e in exhibits]
        theirs = [shown.exhibit for shown in published.parts[key]]
        assert ours == [(e.paper, e.label, e.title, e.note) for e in theirs]
        for one, other in zip(exhibits, theirs):
            assert list(map(as_shown, one.rows)) == list(map(as_shown, other.rows))


def as_shown(row):
    return row.what, row.texts, row.difference, row.verdict, row.explanation


def test_the_page_is_what_the_command_writes_of_its_numbers(published):
    page = page_text(published, reproduction.orders())
    assert (DOCS / reproduction.PAGE).read_text(encoding='utf-8') == page
    assert published.text() == (DOCS / reproduction.NUMBERS).read_text(encoding='utf-8')


def test_the_page_has_every_figure_and_table_that_shows_a_result(published):
    parts = reproduction.parts_of(reproduction.PAPERS, quick=False)
    assert list(published.parts) == [reproduction.key_of(part) for part in parts]
    for paper, order in reproduction.orders().items():
        shown = published.exhibits(paper, order)
        assert sorted(order) == sorted(WANTED[paper])
        assert [one.exhibit.label for one in shown] == list(order)
        assert all(one.exhibit.rows for one in shown)
        figures = [one for one in shown if one.exhibit.label.startswith('Fig.')]
        assert all(one.has_picture for one in figures)


def test_every_published_row_has_a_number_and_what_is_worse_is_explained(published):
    assert reproduction.failures(published) == []


def test_the_pictures_are_those_of_the_page_and_small(published):
    orders = reproduction.orders()
    named = {
        f'{shown.exhibit.stem}.png'
        for paper, order in orders.items()
        for shown in published.exhibits(paper, order)
        if shown.has_picture
    }
    files = {path.name: path.stat().st_size for path in (DOCS / FOLDER).iterdir()}
    assert set(files) == named
    assert min(files.values()) > 1000
    assert sum(files.values()) < 2e6


def one_exhibit():
    return [Exhibit('S0', 'Fig. 6', 'graph', (words('order', '1', '1'),), draw=lambda figure: None)]


def another_exhibit():
    return [Exhibit('S0', 'Fig. 7', 'room', (words('order', '2', '2'),))]


def test_an_interrupted_run_leaves_complete_files_and_the_next_goes_on(tmp_path, monkeypatch):
    first, second = Part('S0', 'paths', one_exhibit), Part('S0', 'cycles', another_exhibit)
    monkeypatch.setattr(reproduction, 'parts_of', lambda papers, quick: [first, second])
    said = []

    def interrupted(line):
        said.append(line)
        if line.startswith('1 of 2'):
            raise Interrupted(2)

    with pytest.raises(Interrupted):
        reproduction.reproduce(['S0'], tmp_path, True, interrupted)
    kept = read_results(tmp_path / reproduction.NUMBERS)
    assert len(kept.parts) == 1
    page = (tmp_path / reproduction.PAGE).read_text(encoding='utf-8')
    assert page == page_text(kept, reproduction.orders())
    assert not list(tmp_path.glob('**/.*'))
    (done,) = kept.parts
    other = second if done.endswith('paths') else first
    monkeypatch.setattr(
        reproduction,
        'parts_of',
        lambda papers, quick: [other] if quick else [first, second],
    )
    told = reproduction.reproduce(['S0'], tmp_path, True, said.append)
    assert len(told.parts) == 1
    assert len(read_results(tmp_path / reproduction.NUMBERS).parts) == 2
    assert (tmp_path / FOLDER / 's0_fig_6.png').read_bytes().startswith(b'\x89PNG')


def test_rows_of_one_exhibit_are_joined_wherever_they_were_measured():
    (exhibit,) = one_exhibit()
    more_of_it = replace(exhibit, rows=(words('end', '6', '6'),), note='walked', draw=None)
    results = Results(
        {
            'S0, paths': reproduction.shown_exhibits([exhibit]),
            'S0, walks': reproduction.shown_exhibits([more_of_it]),
        }
    )
    (joined,) = results.exhibits('S0', ('Fig. 6',))
    assert [row.what for row in joined.exhibit.rows] == ['order', 'end']
    assert joined.has_picture
    assert joined.exhibit.note == 'walked'
