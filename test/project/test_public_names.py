"""What packages offer at their top: there, documented, and imported when it is first used."""

import ast
import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ('quad_common', 'quad_planner', 'quad_gait', 'quad_sim', 'quad_perception', 'quad_lab')


def typed_names(package: str) -> dict[str, str]:
    """List what a package offers to type checkers, and the modules it is in."""
    tree = ast.parse((ROOT / package / '__init__.py').read_text(encoding='utf-8'))
    (choice,) = (node for node in tree.body if isinstance(node, ast.If))
    return {
        alias.asname: node.module
        for node in choice.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.asname == alias.name
    }


@pytest.mark.parametrize('package', PACKAGES)
def test_type_checkers_see_what_python_offers(package):
    module = importlib.import_module(package)
    typed = typed_names(package)
    assert sorted(typed) == sorted(module.__all__)
    for name, place in typed.items():
        assert getattr(module, name) is getattr(importlib.import_module(place), name)


@pytest.mark.parametrize('package', PACKAGES)
def test_every_name_has_a_docstring_and_is_listed(package):
    module = importlib.import_module(package)
    assert len(set(module.__all__)) == len(module.__all__) >= 5
    assert [name for name in module.__all__ if not getattr(module, name).__doc__] == []
    assert set(module.__all__) <= set(dir(module))


@pytest.mark.parametrize('package', PACKAGES)
def test_a_name_that_is_not_offered_is_no_attribute(package):
    module = importlib.import_module(package)
    with pytest.raises(AttributeError, match=f"'{package}' has no attribute 'nonsense'"):
        module.nonsense  # noqa: B018


@pytest.mark.parametrize('package', [*PACKAGES, 'quad_cli'])
def test_a_package_imports_nothing_large_before_a_name_of_it_is_used(package):
    code = (
        'import sys\nbefore = set(sys.modules)\n'
        f'import {package}\nprint(*(set(sys.modules) - before))'
    )
    result = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    ours = {package, 'quad_common', 'quad_common.lazy_names'}
    assert {name.partition('.')[0] for name in set(result.stdout.split()) - ours} <= {'importlib'}


@pytest.mark.parametrize('page', ['README.md', 'docs/api.md'])
def test_examples_for_users_import_from_the_top_of_packages(page):
    text = (ROOT / page).read_text(encoding='utf-8')
    places = re.findall(r'^(?:from|import) (quad_[\w.]+)', text, flags=re.MULTILINE)
    assert places
    assert [place for place in places if '.' in place and place != 'quad_common.errors'] == []
