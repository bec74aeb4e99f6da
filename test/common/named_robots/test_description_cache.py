"""
Robots of the package robot_descriptions: what its cache holds is taken, and nothing is fetched.
"""

import sys

import pytest

from quad_common.errors import DescriptionNotCached, MissingOptionalDependency, RobotUnknown
from quad_common.named_robots.description_cache import cached_names
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot

pytest.importorskip('yourdfpy')

# As the package is made: modules clone when they are imported.
FILES = {
    '__init__.py': 'from ._descriptions import DESCRIPTIONS',
    '_cache.py': "def clone_to_cache(name, commit=None): raise AssertionError('cloned')",
    '_repositories.py': (
        'from types import SimpleNamespace as R\n'
        "REPOSITORIES = {'mine': R(cache_path='my_robots'), 'far': R(cache_path='far_robots')}"
    ),
    '_descriptions.py': (
        'from types import SimpleNamespace as D\n'
        "four = D(tags={'quadruped'})\n"
        "DESCRIPTIONS = {'mine_description': four, 'far_description': four,\n"
        "    'grown_mj_description': four, 'hand_description': D(tags={'hand'})}"
    ),
    'mine_description.py': (
        'from os import path\nfrom ._cache import clone_to_cache\n'
        "URDF_PATH = path.join(clone_to_cache('mine'), 'mine.urdf')"
    ),
    'grown_mj_description.py': (
        'from os import path\nfrom ._cache import clone_to_cache\n'
        "XACRO_PATH = path.join(clone_to_cache('mine'), 'grown.xacro')\n"
        "XACRO_ARGS = {'effort': 7}"
    ),
    'far_description.py': "from ._cache import clone_to_cache\nclone_to_cache('far')",
    'hand_description.py': "from ._cache import clone_to_cache\nclone_to_cache('far')",
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """An installed robot_descriptions whose cache holds one of its two repositories."""
    folder = tmp_path / 'site' / 'robot_descriptions'
    folder.mkdir(parents=True)
    for name, text in FILES.items():
        (folder / name).write_text(text)
    for name in [name for name in sys.modules if name.partition('.')[0] == 'robot_descriptions']:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.syspath_prepend(str(tmp_path / 'site'))
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    monkeypatch.setenv('ROBOT_DESCRIPTIONS_CACHE', str(tmp_path / 'descriptions'))
    held = tmp_path / 'descriptions' / 'my_robots'
    held.mkdir(parents=True)
    text = urdf_from_robot(load_robot('genibo'))
    (held / 'mine.urdf').write_text(text)
    argument = '<xacro:arg name="effort" default="1"/>'
    opening = f'<robot name="grown" xmlns:xacro="http://www.ros.org/wiki/xacro">{argument}'
    text = text[text.index('<link') :].replace('effort="2"', 'effort="$(arg effort)"')
    (held / 'grown.xacro').write_text(opening + text)
    yield
    for name in [name for name in sys.modules if name.partition('.')[0] == 'robot_descriptions']:
        del sys.modules[name]


@pytest.mark.parametrize('name', ['mine', 'mine_description'])
def test_descriptions_of_the_cache_are_robots(package, name):
    robot = load_robot(name)
    assert robot.name == name
    assert robot.mass == pytest.approx(load_robot('genibo').mass)


def test_arguments_that_the_package_names_are_given(package):
    pytest.importorskip('xacro')
    assert load_robot('grown').effort.max() == 7.0


def test_what_the_cache_does_not_hold_is_not_fetched(package):
    with pytest.raises(DescriptionNotCached, match='robot_descriptions pull far_description'):
        load_robot('far')
    with pytest.raises(RobotUnknown):
        load_robot('nowhere')


def test_only_quadrupeds_of_the_cache_are_offered(package):
    assert cached_names() == ('mine_description', 'grown_mj_description')


def test_the_package_stays_as_it_is(package):
    load_robot('mine')
    assert 'robot_descriptions.mine_description' not in sys.modules
    from robot_descriptions._cache import clone_to_cache

    with pytest.raises(AssertionError, match='cloned'):
        clone_to_cache('mine')


def test_names_that_only_it_can_know_ask_for_it(monkeypatch, tmp_path):
    monkeypatch.setattr('importlib.util.find_spec', lambda name: None)
    with pytest.raises(MissingOptionalDependency, match='pip install robot_descriptions'):
        load_robot('go2_description')
    with pytest.raises(RobotUnknown):
        load_robot('go2')
