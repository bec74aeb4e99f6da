"""Rooms, not halls: no class, module or function is longer than one can keep in mind."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CLASS, MODULE, FUNCTION = 300, 400, 60
"""Most lines of each; a function's docstring does not count."""


def modules():
    return sorted(ROOT.glob('quad_*/**/*.py'))


@cache
def defined():
    """Return all classes and functions, with the names of their places."""
    kinds = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    return [
        (f'{path.relative_to(ROOT)}: {node.name}', node)
        for path in modules()
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, kinds)
    ]


def of_kind(*kinds):
    return [(name, node) for name, node in defined() if isinstance(node, kinds)]


def length(function):
    first = function.body[0]
    documents = ast.get_docstring(function) is not None
    return function.end_lineno - (first.end_lineno if documents else function.lineno - 1)


def is_compiled(function):
    """Loops that Numba compiles may be longer: calls within them cost time to compile."""
    return any('compiled' in ast.unparse(each) for each in function.decorator_list)


def test_there_are_modules_to_look_at():
    assert len(modules()) > 500


def test_no_class_is_a_hall():
    lengths = {name: node.end_lineno - node.lineno + 1 for name, node in of_kind(ast.ClassDef)}
    assert not {name: lines for name, lines in lengths.items() if lines > CLASS}


def test_no_module_is_a_hall():
    lengths = {str(path.relative_to(ROOT)): path.read_text().count('\n') for path in modules()}
    assert not {name: lines for name, lines in lengths.items() if lines > MODULE}


def test_no_function_is_longer_than_a_page():
    functions = of_kind(ast.FunctionDef, ast.AsyncFunctionDef)
    lengths = {name: length(node) for name, node in functions if not is_compiled(node)}
    assert not {name: lines for name, lines in lengths.items() if lines > FUNCTION}
