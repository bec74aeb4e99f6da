"""
The documents say what the code does: interfaces, parameters, errors, sources, links.

``PYTHONPATH=. python test/project/test_docs.py`` writes what is generated again: tables,
and the pages of ``docs/reference``.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import runpy
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from test_core_imports import imported_modules

from quad_cli.parameters import TABLES
from quad_common import errors
from quad_common.parameters import parameters_of, valid_range
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.cycle.gait import Gait
from quad_lab.seeded_walks.walk_settings import WalkSettings

ROOT = Path(__file__).resolve().parents[2]
MSG_DOCS = ROOT / 'msg_docs'
SOURCES = sorted(ROOT.glob('quad_*/**/*.py'))
DATA = sorted(ROOT.glob('quad_*/**/*.yaml'))
SITE = runpy.run_path(str(ROOT / 'tools' / 'build_site.py'))
REFERENCE = runpy.run_path(str(ROOT / 'tools' / 'reference_pages.py'))
PAGES, links = SITE['all_pages'](), SITE['links']
NODES = sorted(TABLES)
ARCHITECTURE = ROOT / 'docs' / 'architecture.md'
TOP = 'the top'
LIBRARY = ('quad_common', 'quad_planner', 'quad_gait', 'quad_sim', 'quad_perception', 'quad_lab')

SHARED = {
    'ros_node': tuple(NODES),
    'map_frame_listener': ('gait_node', 'planner_node', 'viewer_node'),
    'transform_publisher': ('ceiling_camera_node', 'sim_node'),
    'batch_topics': ('sim_node',),
    'camera_topics': ('ceiling_camera_node',),
    'gait_topics': ('gait_node',),
    'gait_services': ('gait_node',),
    'plan_topics': ('gait_node',),
    'entity_services': ('sim_node',),
    'gait_actions': ('gait_node',),
    'navigation_actions': ('planner_node',),
    'path_actions': ('planner_node',),
    'plan_services': ('planner_node',),
    'map_topics': ('planner_node',),
    'planner_topics': ('planner_node',),
    'sim_topics': ('sim_node',),
    'simulated_robot_topics': ('sim_node',),
    'traffic_topics': ('planner_node',),
    'robot_topics': ('viewer_node',),
    'command_topics': ('viewer_node',),
}
"""The nodes that a module makes publishers and subscriptions for."""

QUALITIES = {
    '10': 'reliable, volatile, depth 10',
    '100': 'reliable, volatile, depth 100',
    '500': 'reliable, volatile, depth 500',
    '_LATCHED': 'reliable, transient local, depth 1',
    '_EVERY_PLAN': 'reliable, transient local, depth 10',
    '_EVERY_ONE': 'reliable, transient local, depth 10',
    '_STATIC': 'reliable, transient local, depth 100',
    '_CLOCK': 'best effort, volatile, depth 1',
    '_NEWEST': 'best effort, volatile, depth 1',
    'qos_profile_sensor_data': 'best effort, volatile, depth 5',
}
"""How the pages call what the code asks for; ``test_..._profiles_mean_...`` checks it."""

CALLED = {'follow_joint_trajectory': ('gait_node', 'trajectory_action')}
"""Pages of what others serve: the node that calls it, and its parameter with the name."""

ROWS = {
    'create_publisher': 'published by',
    'create_subscription': 'subscribed by',
    '_listen': 'subscribed by',
    'create_service': 'offered by',
    'GoalAction': 'served by',
}
"""The row of a page's first table that names the nodes."""

# A citation: S0 or [Nguyen2017], then eq., fig. or sec. with numbers, "to" for ranges.
_KINDS = {'eq': 'eq', 'eqs': 'eq', 'fig': 'fig', 'figs': 'fig', 'sec': 'sec', 'section': 'sec'}
_PLACE = r'(?:eqs?\.|figs?\.|sec\.|section)\s\d+(?:\sto\s\d+)?'
_KEY = r'\b(S\d)\b|\[(Nguyen2017|Hoang2013|Liu|Marin|Yi)\](?!:)'
_CITATION = re.compile(rf"(?:{_KEY})(?:'s)?\s?\(?((?:(?:,\s|\sand\s)?{_PLACE})*)")
_EACH = re.compile(r'(eqs?|figs?|sec|section)\.?\s(\d+)(?:\sto\s(\d+))?')


@dataclass(frozen=True)
class Interface:
    """One publisher, subscription, service or action in the code."""

    name: str
    """Without a leading slash."""
    kinds: tuple[str, ...]
    """Type in ROS's notation, for example ``nav_msgs/msg/Path``; two if a parameter chooses."""
    call: str
    """Key of :data:`ROWS`."""
    nodes: tuple[str, ...]
    """Empty for what is no node."""
    quality: str
    """Key of :data:`QUALITIES`; empty for services and actions."""

    def __str__(self) -> str:
        return f'{"+".join(self.nodes) or "quadwalk"}-{self.call}-{self.name}'


def interfaces() -> Iterator[Interface]:
    """Find every publisher, subscription, service and action that the sources make."""
    for path in SOURCES:
        text = path.read_text(encoding='utf-8')
        if not any(call in text for call in ROWS):
            continue
        tree = ast.parse(text, str(path))
        types = imported_types(tree)
        nodes = (path.stem,) if path.stem in NODES else ()
        nodes = SHARED.get(path.stem, nodes)
        for call in ast.walk(tree):
            if not isinstance(call, ast.Call):
                continue
            if isinstance(call.func, ast.Name) and call.func.id == 'GoalAction':
                name, arguments = 'GoalAction', call.args[1:]
            elif isinstance(call.func, ast.Attribute):
                name, arguments = call.func.attr, call.args
            else:
                continue
            # What forwards its own arguments has no literal type: its callers do.
            kinds = kinds_of(arguments[0], types, tree) if name in ROWS else ()
            if kinds:
                quality = ''
                if name not in ('create_service', 'GoalAction'):
                    place = 2 if name in ('create_publisher', '_listen') else 3
                    quality = resolved(arguments[place], tree)
                topic = topic_name(arguments[1], path.stem).lstrip('/')
                yield Interface(topic, kinds, name, nodes, quality)


def imported_types(tree: ast.Module) -> dict[str, str]:
    """List the messages, services and actions that a module imports, by their names in it."""
    return {
        alias.asname or alias.name: f'{node.module.replace(".", "/")}/{alias.name}'
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        if node.module is not None and node.module.endswith(('.msg', '.srv', '.action'))
        for alias in node.names
    }


def kinds_of(argument: ast.expr, types: dict[str, str], tree: ast.Module) -> tuple[str, ...]:
    """Return the type that an argument names, or the two between which a parameter chooses."""
    if isinstance(argument, ast.IfExp):
        chosen = (argument.body, argument.orelse)
        return tuple(sorted(kind for part in chosen for kind in kinds_of(part, types, tree)))
    if not isinstance(argument, ast.Name):
        return ()
    if argument.id in types:
        return (types[argument.id],)
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Assign)
            and ast.unparse(node.targets[0]) == argument.id
            and isinstance(node.value, ast.IfExp)
            and (kinds := kinds_of(node.value, types, tree))
        ):
            return kinds
    return ()


def topic_name(argument: ast.expr, module: str) -> str:
    """Return a literal name, or the default of the parameter that holds it."""
    if isinstance(argument, ast.Attribute):
        (node,) = SHARED.get(module, (module,))
        defaults = {p.name: p.default for p in parameters_of(TABLES[node])}
        return str(defaults[argument.attr])
    assert isinstance(argument, ast.Constant), f'{module}: {ast.unparse(argument)} is no literal'
    return str(argument.value)


def resolved(argument: ast.expr, tree: ast.Module) -> str:
    """Follow a quality of service through the names that stand for it."""
    if isinstance(argument, ast.IfExp):
        return resolved(argument.body, tree)
    text = ast.unparse(argument)
    for node in ast.walk(tree):
        if (
            text not in QUALITIES
            and isinstance(node, ast.Assign)
            and ast.unparse(node.targets[0]) == text
        ):
            return resolved(node.value, tree)
    return text


INTERFACES = sorted(set(interfaces()), key=str)


def page_of(interface: Interface) -> Path:
    """Return the page of an interface, ``a_b.md`` for ``a/b``; tf and tf_static share one."""
    return MSG_DOCS / f'{interface.name.removesuffix("_static").replace("/", "_")}.md'


def first_table(page: Path) -> dict[str, str]:
    """Read the rows of a page's first table."""
    table = page.read_text(encoding='utf-8').split('\n\n')[1]
    rows = [line.strip('|').split('|', 1) for line in table.splitlines()[2:]]
    return {name.strip(): text.strip() for name, text in rows}


def parameter_table(table: type) -> str:
    """Write parameters, of a node or of a walk, as the Markdown table of a page."""
    lines = ['| name | default | unit | valid | description |', '| --- | --- | --- | --- | --- |']
    for parameter in parameters_of(table):
        cells = (
            f'`{parameter.name}`',
            f'`{REFERENCE["default_as_yaml"](parameter)}`',
            parameter.unit,
            valid_range(parameter) or 'any',
            parameter.description,
        )
        lines.append(f'| {" | ".join(cells)} |'.replace('|  |', '| |'))
    return '\n'.join(lines)


def error_table() -> str:
    """Write the errors that have a number as the Markdown table of the diagnostics page."""
    lines = ['| number | error | meaning |', '| --- | --- | --- |']
    for error in sorted(planner_errors(), key=lambda error: (error.code, error.__name__)):
        meaning = inspect.cleandoc(error.__doc__ or '').split('\n\n')[0]
        lines.append(f'| {error.code} | `{error.__name__}` | {" ".join(meaning.split())} |')
    return '\n'.join(lines)


def planner_errors() -> list[type[errors.PlannerError]]:
    """List the errors with a number, without those that only others are made of."""
    return [
        error
        for name, error in vars(errors).items()
        if inspect.isclass(error)
        and issubclass(error, errors.PlannerError)
        and not name.startswith('_')
    ]


def name_table(package: str) -> str:
    """Write the names that a package offers as a Markdown table of the library's page."""
    module = importlib.import_module(package)
    lines = [f'| from `{package}` | what it is |', '| --- | --- |']
    for name in module.__all__:
        meaning = inspect.cleandoc(getattr(module, name).__doc__).split('\n\n')[0]
        lines.append(f'| `{name}` | {" ".join(meaning.split())} |'.replace('``', '`'))
    return '\n'.join(lines)


def room_table(package: str) -> str:
    """Write the rooms of a package as a Markdown table: what each package says of itself."""
    lines = [f'| room of `{package}` | what lives there |', '| --- | --- |']
    for room in sorted(ROOT.glob(f'{package}/**/__init__.py')):
        name = room.parent.relative_to(ROOT / package).as_posix()
        text = ast.get_docstring(ast.parse(room.read_text(encoding='utf-8'))) or ''
        if name != '.':
            lines.append(f'| `{name}` | {" ".join(text.split())} |')
    return '\n'.join(lines)


def layer_table() -> str:
    """Write which rooms import which: each imports those before it at most."""
    uses: dict[str, dict[str, set[str]]] = {}
    for path in SOURCES:
        if path.name != '__init__.py':
            package, *room = path.relative_to(ROOT).parent.parts
            here = '/'.join(room) or TOP
            needs = uses.setdefault(package, {}).setdefault(here, set())
            for module in imported_modules(path):
                other, *parts = module.split('.')[:-1]
                if other == package:
                    needs.add('/'.join(parts) or TOP)
            needs.discard(here)
    lines = ['| package | its rooms, each of which imports those before an arrow at most |']
    lines.append('| --- | --- |')
    for package in (*LIBRARY[:-1], 'quad_view', 'quad_lab', 'quad_cli'):
        layers, left = [], dict(uses[package])
        while left:
            layers.append(sorted(room for room, needs in left.items() if not needs & left.keys()))
            assert layers[-1], f'these rooms import one another: {left}'
            left = {room: needs for room, needs in left.items() if room not in layers[-1]}
        lines.append(f'| `{package}` | {" <- ".join(map(", ".join, layers))} |')
    return '\n'.join(lines)


GENERATED = {
    **{node: (MSG_DOCS / f'{node}.md', partial(parameter_table, TABLES[node])) for node in NODES},
    'errors': (MSG_DOCS / 'diagnostics.md', error_table),
    **{package: (ROOT / 'docs' / 'api.md', partial(name_table, package)) for package in LIBRARY},
    **{
        f'rooms of {name}': (ARCHITECTURE, partial(room_table, name))
        for name in (*LIBRARY, 'quad_view')
    },
    'layers': (ARCHITECTURE, layer_table),
    'walks': (ROOT / 'docs' / 'campaigns.md', partial(parameter_table, WalkSettings)),
}
"""Each page that holds a generated table, and what writes the table."""


def citations(text: str) -> set[tuple[str, str, int]]:
    """Find what is cited, for example ('S0', 'eq', 16) for "S0 eq. 16"."""
    text = re.sub(r'\s*\n[\s#]*', ' ', text)
    found = set()
    for short, author, places in _CITATION.findall(text):
        key = short or author
        found.add((key, '', 0))
        for kind, first, last in _EACH.findall(places):
            found |= {(key, _KINDS[kind], n) for n in range(int(first), int(last or first) + 1)}
    return found


def resolvable() -> set[tuple[str, str, int]]:
    """Find what ``docs/references.md`` has: its sections are the keys, their text the places."""
    text = (ROOT / 'docs' / 'references.md').read_text(encoding='utf-8')
    found = set()
    for section in re.split(r'^## ', text, flags=re.MULTILINE)[1:]:
        author, short = section.split()[:2]
        for key in (author, short.strip('()')):
            found.add((key, '', 0))
            for kind, first, last in _EACH.findall(section):
                found |= {(key, _KINDS[kind], n) for n in range(int(first), int(last or first) + 1)}
    return found


def examples(page: Path) -> list[str]:
    """Return the Python blocks of a page."""
    blocks: list[str] = re.findall(
        r'^```python\n(.*?)^```', page.read_text(encoding='utf-8'), flags=re.DOTALL | re.MULTILINE
    )
    return blocks


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as code hosts make them."""
    text = re.sub(r'```.*?```', '', page.read_text(encoding='utf-8'), flags=re.DOTALL)
    headings = re.findall(r'^#+ (.*)$', text, flags=re.MULTILINE)
    plain = (re.sub(r'[^\w\- ]', '', heading) for heading in headings)
    return {heading.strip().lower().replace(' ', '-') for heading in plain}


def relative(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize('interface', INTERFACES, ids=str)
def test_every_topic_and_service_has_its_page(interface):
    assert page_of(interface).is_file()


@pytest.mark.parametrize('interface', INTERFACES, ids=str)
def test_a_page_has_the_type_the_nodes_and_the_quality_of_service_of_the_code(interface):
    table = first_table(page_of(interface))
    assert table['type'] == ' or '.join(f'`{kind}`' for kind in interface.kinds)
    for node in interface.nodes:
        assert f'`{node}`' in table[ROWS[interface.call]]
    if interface.quality:
        assert QUALITIES[interface.quality] in table['QoS']


@pytest.mark.parametrize('interface', [i for i in INTERFACES if i.nodes], ids=str)
def test_the_page_of_a_node_links_its_topics_and_services(interface):
    for node in interface.nodes:
        assert page_of(interface).name in set(links(MSG_DOCS / f'{node}.md'))


def test_the_search_for_interfaces_finds_those_of_every_node():
    found = {(node, interface.call) for interface in INTERFACES for node in interface.nodes}
    assert found == {
        (node, call)
        for node in NODES
        for call in ('create_publisher', 'create_subscription', 'create_service')
        if call != 'create_service' or node not in ('ceiling_camera_node', 'viewer_node')
    } | {('planner_node', 'GoalAction'), ('gait_node', 'GoalAction')}


@pytest.mark.ros
def test_the_profiles_mean_what_the_pages_call_them():
    pytest.importorskip('rclpy')
    from rclpy.qos import QoSProfile, qos_profile_sensor_data

    from quad_common.ros import map_frame_listener, transform_publisher
    from quad_gait import gait_node, gait_services, gait_topics, plan_topics
    from quad_perception import camera_topics, ceiling_camera_node
    from quad_planner import map_topics, planner_topics
    from quad_sim import sim_topics, simulated_robot_topics
    from quad_view import robot_topics

    profiles: dict[str, list[Any]] = {
        '10': [QoSProfile(depth=10)],
        '100': [QoSProfile(depth=100)],
        '500': [QoSProfile(depth=500)],
        '_LATCHED': [
            module._LATCHED
            for module in (
                camera_topics,
                gait_node,
                gait_services,
                gait_topics,
                map_topics,
                plan_topics,
                planner_topics,
                robot_topics,
                sim_topics,
                simulated_robot_topics,
                transform_publisher,
            )
        ],
        '_EVERY_PLAN': [planner_topics._EVERY_PLAN],
        '_EVERY_ONE': [gait_services._EVERY_ONE],
        '_STATIC': [map_frame_listener._STATIC],
        '_CLOCK': [sim_topics._CLOCK],
        '_NEWEST': [ceiling_camera_node._NEWEST, robot_topics._NEWEST],
        'qos_profile_sensor_data': [qos_profile_sensor_data],
    }
    assert profiles.keys() == QUALITIES.keys()
    for name, text in QUALITIES.items():
        for profile in profiles[name]:
            words = (profile.reliability.name, profile.durability.name, f'DEPTH_{profile.depth}')
            assert ', '.join(words).lower().replace('_', ' ') == text


@pytest.mark.parametrize(('page', 'table'), GENERATED.values(), ids=GENERATED)
def test_a_generated_table_is_that_of_the_code(page, table):
    assert f'\n{table()}\n' in page.read_text(encoding='utf-8'), (
        'write it again: PYTHONPATH=. python test/project/test_docs.py'
    )


@pytest.mark.parametrize('page', REFERENCE['PAGES'], ids=relative)
def test_a_page_of_the_reference_is_that_of_the_code(page):
    assert page.read_text(encoding='utf-8') == REFERENCE['PAGES'][page](), (
        'write it again: PYTHONPATH=. python test/project/test_docs.py'
    )


def test_every_page_of_an_interface_stands_in_the_index():
    index = set(links(MSG_DOCS / 'README.md'))
    assert {page.name for page in MSG_DOCS.glob('*.md')} - {'README.md'} <= index


def test_every_page_is_about_something_that_exists():
    about = {page_of(interface).stem for interface in INTERFACES} | set(NODES) | set(CALLED)
    for page, (node, parameter) in CALLED.items():
        assert f'`{node}`' in first_table(MSG_DOCS / f'{page}.md')['called by']
        assert f'{page}.md' in set(links(MSG_DOCS / f'{node}.md'))
        assert parameter in {each.name for each in parameters_of(TABLES[node])}
    assert {page.stem for page in MSG_DOCS.glob('*.md')} - {'README'} == about


def test_the_diagnostics_page_has_every_message_and_every_value():
    page = (MSG_DOCS / 'diagnostics.md').read_text(encoding='utf-8')
    said = {activity.value for activity in Activity}
    values = {'error', 'error_code'}
    for path in SOURCES:
        if not path.stem.endswith(('_node', '_session', '_status')):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
            reports = ('self.report', 'Status')
            if isinstance(node, ast.Call) and ast.unparse(node.func) in reports:
                said.add(beginning(node.args[1]))
                values |= {k.arg for k in node.keywords if k.arg not in (None, 'is_waiting')}
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == 'message':
                said.add(beginning(node.value))
            if (
                isinstance(node, ast.Assign)
                and ast.unparse(node.targets[0]) == 'values'
                and isinstance(node.value, ast.Dict)
            ):
                values |= {key.value for key in node.value.keys if isinstance(key, ast.Constant)}
            if isinstance(node, ast.FunctionDef) and node.name == 'clock_problem':
                returned = [n.value for n in ast.walk(node) if isinstance(n, ast.Return)]
                said |= {beginning(value).split(':')[0] for value in returned if value}
    assert len(said) > 15
    assert len(values) > 8
    assert [text for text in sorted(said) if text not in page] == []
    assert [name for name in sorted(values) if f'`{name}`' not in page] == []


def beginning(text: ast.expr) -> str:
    """Return a text, or that of an f-string up to its first value."""
    if isinstance(text, ast.JoinedStr):
        text = text.values[0]
    return str(text.value).strip() if isinstance(text, ast.Constant) and text.value else ''


def test_the_page_of_robots_has_every_number_of_a_data_file():
    page = (ROOT / 'docs' / 'robots.md').read_text(encoding='utf-8')
    missing = {
        name
        for name in load_robot('titan_viii').sources
        if any(f'`{part}' not in page and f'.{part}`' not in page for part in name.split('.'))
    }
    assert missing == set()


def test_the_page_of_gaits_has_every_key_of_a_gait_file():
    page = (ROOT / 'docs' / 'gaits.md').read_text(encoding='utf-8')
    assert [name for name in Gait.__dataclass_fields__ if f'`{name}`' not in page] == []


def test_every_source_that_is_cited_stands_in_the_references():
    known = resolvable()
    # A case for each file would take longer to collect than to run.
    cited = {
        relative(path): citations(path.read_text(encoding='utf-8'))
        for path in (*SOURCES, *DATA, *PAGES)
    }
    assert len(cited) > 500
    assert {path: found - known for path, found in cited.items() if not found <= known} == {}


def test_citations_are_read_over_line_breaks_ranges_and_lists():
    text = "# S0 eqs. 11 to 13, sec. 4; S0\n# fig. 12 and eq. 11; S4's mu; ROS2 eq. 1; [Yi] sec. 2"
    assert citations(text) == {
        ('S0', '', 0),
        *(('S0', 'eq', n) for n in (11, 12, 13)),
        ('S0', 'sec', 4),
        ('S0', 'fig', 12),
        ('S4', '', 0),
        ('Yi', '', 0),
        ('Yi', 'sec', 2),
    }


@pytest.mark.parametrize('page', PAGES, ids=relative)
def test_links_between_documents_lead_somewhere(page):
    dead = []
    for link in links(page):
        name, _, anchor = link.partition('#')
        target = (page.parent / name).resolve() if name else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            dead.append(link)
    assert dead == []


@pytest.mark.parametrize('page', PAGES, ids=relative)
def test_files_that_documents_name_exist(page):
    text = page.read_text(encoding='utf-8')
    named = re.findall(r'`((?:quad_\w+|test|tools|maps|config|launch|docs)/[\w./*-]+)`', text)
    assert [path for path in named if not list(ROOT.glob(path))] == []


@pytest.mark.parametrize('page', [page for page in PAGES if examples(page)], ids=relative)
def test_the_examples_are_python_and_those_without_ros_run(page, monkeypatch):
    monkeypatch.chdir(ROOT)
    for example in examples(page):
        code = compile(example, relative(page), 'exec')
        if 'rclpy' not in example:
            try:
                exec(code, {'__name__': 'example'})
            except errors.MissingOptionalDependency as error:
                pytest.skip(str(error))


def test_no_file_names_a_place_on_somebodys_machine():
    listed = subprocess.run(
        ['git', 'ls-files', '-z', '--cached', '--others', '--exclude-standard'],
        capture_output=True,
        check=False,
        cwd=ROOT,
    )
    if listed.returncode != 0:
        pytest.skip('this is no git checkout')
    place = re.compile(rb'(?<![\w.~])/(?:home|root|Users)/')
    named = []
    for name in filter(None, listed.stdout.decode().split('\0')):
        path = ROOT / name
        content = path.read_bytes() if path.is_file() else b''
        if b'\0' not in content and path.suffix != '.pgm' and place.search(content):
            named.append(name)
    assert named == []


def write_tables() -> None:
    """Put the generated tables into their pages, and write the generated pages."""
    for page, write in GENERATED.values():
        table = write()
        text = page.read_text(encoding='utf-8')
        header = re.escape(table.splitlines()[0])
        old = re.search(rf'{header}\n(?:\|.*\n)*', text)
        if old is not None:
            page.write_text(text.replace(old.group(), f'{table}\n'), encoding='utf-8')
    REFERENCE['main']()


if __name__ == '__main__':
    write_tables()
