"""
Robots of the package robot_descriptions: what its cache holds is taken, and nothing is fetched.
"""

import importlib
import sys
import threading

import pytest

from quad_common.errors import (
    DescriptionNotCached,
    DescriptionPackageUnusable,
    MissingOptionalDependency,
    RobotFileUnusable,
    RobotUnknown,
)
from quad_common.named_robots.description_cache import cached_description, cached_names
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


def forget_package():
    for name in [name for name in sys.modules if name.partition('.')[0] == 'robot_descriptions']:
        del sys.modules[name]
    importlib.invalidate_caches()


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
    yield folder
    forget_package()


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
    import robot_descriptions

    assert not hasattr(robot_descriptions, 'mine_description')
    assert not [name for name in sys.modules if 'without_cloning' in name]
    from robot_descriptions._cache import clone_to_cache

    with pytest.raises(AssertionError, match='cloned'):
        clone_to_cache('mine')


def test_names_that_only_it_can_know_ask_for_it(monkeypatch, tmp_path):
    monkeypatch.setattr('importlib.util.find_spec', lambda name: None)
    with pytest.raises(MissingOptionalDependency, match='pip install robot_descriptions'):
        load_robot('go2_description')
    with pytest.raises(RobotUnknown):
        load_robot('go2')


def test_what_it_clones_with_is_not_needed(package):
    # As GitPython without git: this error has no name of a module.
    (package / '_cache.py').write_text("raise ImportError('Bad git executable')")
    assert load_robot('mine').name == 'mine'
    assert 'mine_description' in cached_names()


def test_other_threads_that_use_it_get_its_own_function(package):
    folder = package.parents[1] / 'descriptions' / 'my_robots'
    (package / 'mine_description.py').write_text(
        'import robot_observer\nfrom os import path\nfrom ._cache import clone_to_cache\n'
        "robot_observer.look()\nURDF_PATH = path.join(clone_to_cache('mine'), 'mine.urdf')"
    )
    (package.parent / 'robot_observer.py').write_text(
        'import threading\nseen = []\n'
        'def use():\n'
        '    from robot_descriptions._cache import clone_to_cache\n'
        '    try:\n        clone_to_cache("mine")\n'
        '    except AssertionError as error:\n        seen.append(str(error))\n'
        'def look():\n'
        '    thread = threading.Thread(target=use)\n    thread.start()\n    thread.join()\n'
    )
    try:
        assert cached_description('mine').path == folder / 'mine.urdf'
        import robot_observer

        assert robot_observer.seen == ['cloned']
    finally:
        sys.modules.pop('robot_observer', None)


def test_threads_may_ask_at_once(package):
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(cached_description('mine')), daemon=True)
        for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=30.0)
    assert len(found) == 8
    assert len({str(each.path) for each in found}) == 1


@pytest.mark.parametrize(
    ('file', 'text', 'told'),
    [
        ('mine_description.py', "{}['mine']", "KeyError: 'mine'"),
        ('mine_description.py', 'from ._cache import another', "cannot import name 'another'"),
        ('mine_description.py', "raise ImportError('of another version')", 'of another version'),
        ('_repositories.py', 'REPOSITORIES = {}', "KeyError: 'mine'"),
        ('_repositories.py', "REPOSITORIES = {'mine': ()}", 'cache_path'),
    ],
)
def test_other_versions_are_refused_with_what_they_raise(file, text, told, package):
    (package / file).write_text(text)
    with pytest.raises(DescriptionPackageUnusable) as error:
        load_robot('mine')
    assert told in str(error.value)
    assert 'without_cloning' not in str(error.value)


def test_damaged_descriptions_hide_no_others(package):
    (package / 'mine_description.py').write_text("{}['mine']")
    assert cached_names() == ('grown_mj_description',)
    (package / '_descriptions.py').write_text("{}['all']")
    assert cached_names() == ()


def test_packages_that_it_lacks_are_named(package):
    (package / 'mine_description.py').write_text('import no_such_package')
    with pytest.raises(MissingOptionalDependency, match="the package 'no_such_package'"):
        load_robot('mine')


def test_mistyped_names_do_not_need_the_package_to_work(package):
    (package / '__init__.py').write_text('import no_such_package')
    with pytest.raises(RobotUnknown):
        load_robot('titan_vi')


def test_a_module_that_is_called_so_knows_no_robots(package, tmp_path, monkeypatch):
    (tmp_path / 'stray').mkdir()
    (tmp_path / 'stray' / 'robot_descriptions.py').write_text('x = 1')
    monkeypatch.syspath_prepend(str(tmp_path / 'stray'))
    assert cached_names() == ()
    for name in ('titan_vi', 'mine'):
        with pytest.raises(RobotUnknown):
            load_robot(name)


def test_its_own_modules_are_no_robots(package):
    (package / '_empty_description.py').write_text('"""For tests."""')
    for name in ('_empty', '_empty_description'):
        with pytest.raises(RobotUnknown):
            load_robot(name)


def test_a_cache_of_a_user_who_does_not_exist_is_said(package, monkeypatch):
    monkeypatch.setenv('ROBOT_DESCRIPTIONS_CACHE', '~nobody_of_that_name/x')
    assert cached_names() == ()
    with pytest.raises(RobotFileUnusable, match='home of a user who does not exist'):
        load_robot('mine')
    with pytest.raises(RobotUnknown):
        load_robot('nowhere')
