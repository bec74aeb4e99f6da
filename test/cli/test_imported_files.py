"""An import writes over nothing but what an import has written, and nothing that cannot walk."""

import re

import pytest

from quad_cli.main import main
from quad_common.importing.robot_document import urdf_path, write_robot
from quad_common.importing.robot_import import import_robot
from quad_common.named_robots.robot_cache import assumptions
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot

pytest.importorskip('yourdfpy')


@pytest.fixture
def description(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / 'genibo.urdf'
    path.write_text(urdf_from_robot(load_robot('genibo')))
    return path


def imported(path):
    return main(['robot', 'import', path.name, '--no-picture'])


def test_the_description_stays_as_it_was_however_often_it_is_imported(description, capsys):
    text = description.read_text()
    for _ in range(2):
        assert imported(description) == 0
        assert 'written: genibo.yaml, genibo_imported.urdf' in capsys.readouterr().out
        assert description.read_text() == text
    assert load_robot(description.with_name('genibo.yaml')).mass > 0.0
    names = sorted(path.name for path in description.parent.iterdir())
    assert names == ['genibo.urdf', 'genibo.yaml', 'genibo_imported.urdf']


def test_what_an_import_has_written_can_be_imported_itself(description):
    assert imported(description) == 0
    ours = description.with_name('genibo_imported.urdf')
    text = ours.read_text()
    # Into the same data file, beside both.
    assert main(['robot', 'import', ours.name, '--no-picture', '--output', 'genibo.yaml']) == 0
    assert ours.read_text() == text
    assert load_robot(description.with_name('genibo.yaml')).mass > 0.0


def test_another_urdf_of_the_same_name_is_not_written_over(tmp_path):
    data_file, source = tmp_path / 'dog.yaml', tmp_path / 'dog.urdf.xacro'
    assert urdf_path(data_file, source) == tmp_path / 'dog.urdf'
    (tmp_path / 'dog.urdf').write_text("somebody's own")
    assert urdf_path(data_file, source) == tmp_path / 'dog_imported.urdf'
    data_file.write_text('name: dog\nurdf: dog.urdf\n')
    assert urdf_path(data_file, source) == tmp_path / 'dog.urdf'


def test_nothing_is_written_of_what_cannot_be_a_robot(description, capsys):
    assert imported(description) == 0
    before = {path: path.read_bytes() for path in description.parent.iterdir()}
    in_millimetres = re.sub(
        r'(<origin[^>]*xyz=")([^"]*)"',
        lambda match: match[1] + ' '.join(f'{1e3 * float(x)}' for x in match[2].split()) + '"',
        description.read_text(),
    )
    wrong = description.with_name('wrong.urdf')
    wrong.write_text(in_millimetres)
    capsys.readouterr()
    assert main(['robot', 'import', wrong.name, '--no-picture', '--output', 'genibo.yaml']) == 2
    said = capsys.readouterr().err
    assert said.startswith('error: wrong.urdf: ')
    assert 'quadwalk_' not in said
    assert {path: path.read_bytes() for path in before} == before


def test_what_was_assumed_stays_with_the_robot(description):
    robot = import_robot(description)
    robot.notes.assume("forward is the root link's +x;\nchoose otherwise with --forward")
    data_file, _ = write_robot(robot, description.with_name('dog.yaml'))
    said = "forward is the root link's +x; choose otherwise with --forward"
    assert assumptions(data_file)[-1] == said
    assert load_robot(data_file).mass == pytest.approx(robot.masses.total)


def test_a_file_that_is_no_text_and_a_name_that_is_too_long_are_no_import(tmp_path):
    data_file = tmp_path / 'dog.yaml'
    data_file.write_bytes(b'\xff\xfe\x00urdf')
    (tmp_path / 'dog.urdf').write_text('somebody')
    assert urdf_path(data_file, tmp_path / 'x.urdf') == tmp_path / 'dog_imported.urdf'
    long = tmp_path / ('d' * 300 + '.yaml')
    assert urdf_path(long, tmp_path / 'x.urdf') == long.with_suffix('.urdf')
