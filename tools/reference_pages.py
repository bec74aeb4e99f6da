"""
Writes the pages of ``docs/reference`` from the code: commands with their options, and parameters.

``PYTHONPATH=. python tools/reference_pages.py`` writes them again. They are made of the parsers
and the parameter tables themselves, and so are the same under every version of Python.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path

from quad_cli.main import COMMANDS, command_module
from quad_cli.parameters import TABLES
from quad_common.parameters import Parameter, parameters_of, valid_range, yaml_from_parameters
from quad_common.planar_pose import Pose2D

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / 'docs' / 'reference'

_NOTE = """Written from the code by `tools/reference_pages.py`; do not edit.
"""

_COMMANDS = f"""# Commands

{_NOTE}
Each command, and each action of one, prints the same with `--help`. All exit with 0 if all went
well, with 1 if it did not, and with 2 and one sentence if it could not be tried. Poses are
`x,y,yaw` in metres and radians, or `x,y,90deg`.
"""

_PARAMETERS = f"""# Parameters

{_NOTE}
All parameters of all nodes, by name. A parameter that several nodes have needs the same value in
each. The page of a node says more: {{nodes}}.

`quadwalk parameters gait_node` prints those of a node as a file for `--params-file`; `config/`
holds these files.
"""


def default_as_yaml(parameter: Parameter) -> str:
    """Write a default as it stands in parameter files."""
    last = yaml_from_parameters('node', [parameter]).splitlines()[-1]
    return last.split(': ', 1)[1]


def commands_page() -> str:
    """Write the page of the commands."""
    parts = [_COMMANDS, '\n'.join(['| command | what it does |', '| --- | --- |'])]
    parts[-1] += ''.join(f'\n| [{name}](#{name}) | {does} |' for name, does in COMMANDS.items())
    for name, does in COMMANDS.items():
        module = command_module(name)
        parser = argparse.ArgumentParser(prog=f'quadwalk {name}')
        module.add_arguments(parser)
        parts.append(f'\n## {name}\n\n{does[0].upper()}{does[1:]}.')
        parts += command_tables(parser)
        parts.append(f'\n```text\n{module.EXAMPLES.strip()}\n```')
    return '\n'.join(parts) + '\n'


def command_tables(parser: argparse.ArgumentParser) -> Iterator[str]:
    """Yield the tables of a command's arguments, and those of its actions."""
    rows, actions = [], []
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            does = {choice.dest: choice.help or '' for choice in action._choices_actions}
            actions = [(does[name], below) for name, below in action.choices.items()]
        elif not isinstance(action, argparse._HelpAction):
            rows.append(f'| {argument(action)} | {meaning(action)} |')
    if rows:
        yield '\n| argument | meaning |\n| --- | --- |\n' + '\n'.join(rows)
    for does, below in actions:
        command = below.prog.removeprefix('quadwalk ')
        yield f'\n### {command}\n\n{does[0].upper()}{does[1:]}.'
        yield from command_tables(below)


def argument(action: argparse.Action) -> str:
    """Write how an argument is given, for example ``--seed SEED``."""
    values = action.metavar or (action.dest if not action.option_strings else action.dest.upper())
    value = '' if action.nargs == 0 else str(values)
    several = ' ...' if action.nargs in ('+', '*') else ''
    return f'`{" ".join([*action.option_strings[:1], value]).strip()}{several}`'


def meaning(action: argparse.Action) -> str:
    """Write what an argument means, with what may be chosen, its default, and if it must be."""
    parts = [' '.join(((action.help or '') % vars(action)).split())]
    if action.choices is not None:
        parts.append('one of ' + ', '.join(f'`{choice}`' for choice in action.choices))
    if action.option_strings and action.required:
        parts.append('needed')
    default = default_text(action.default)
    if default and default not in parts[0] and '(default' not in parts[0]:
        parts.append(f'default `{default}`')
    return '; '.join(filter(None, parts)).replace('|', '\\|')


def default_text(default: object) -> str:
    """Write a default as it would be given; empty for none, and for one of the machine's."""
    if default is None or default is False or isinstance(default, Path):
        return ''
    if isinstance(default, Pose2D):
        return f'{default.x:g},{default.y:g},{math.degrees(default.yaw):g}deg'
    if isinstance(default, list | tuple):
        return ' '.join(map(str, default))
    return str(default)


def parameters_page() -> str:
    """Write the page of the parameters of every node."""
    rows = sorted(
        (parameter.name, node, parameter)
        for node, table in TABLES.items()
        for parameter in parameters_of(table)
    )
    listed: dict[tuple[str, str, str], list[str]] = {}
    for name, node, parameter in rows:
        valid = ', '.join(filter(None, (parameter.unit, valid_range(parameter))))
        says = f'{parameter.description} [{valid}]' if valid else parameter.description
        listed.setdefault((name, default_as_yaml(parameter), says), []).append(node)
    nodes = ', '.join(link(node) for node in sorted(TABLES))
    lines = [_PARAMETERS.replace('{nodes}', nodes)]
    lines += ['| parameter | default | of | meaning |', '| --- | --- | --- | --- |']
    for (name, default, says), owners in listed.items():
        of = ', '.join(link(node) for node in owners)
        lines.append(f'| `{name}` | `{default}` | {of} | {says} |')
    return '\n'.join(lines) + '\n'


def link(node: str) -> str:
    """Write a link to the page of a node."""
    return f'[{node}](../../msg_docs/{node}.md)'


PAGES = {
    FOLDER / 'commands.md': commands_page,
    FOLDER / 'parameters.md': parameters_page,
}
"""Each generated page, and what writes it."""


def main() -> None:
    """Write the pages."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for path, write in PAGES.items():
        path.write_text(write(), encoding='utf-8')


if __name__ == '__main__':
    main()
