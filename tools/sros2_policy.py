"""
Writes the SROS2 policy of quadwalk from the pages of its interfaces.

``python tools/sros2_policy.py`` writes ``config/sros2_policy.xml`` again; ``--namespace``
and ``--output`` make one for a robot in a namespace. Each node gets an enclave in which it
may publish, subscribe to and serve what ``msg_docs`` says, and what every node of rclpy has;
people with their tools and a real robot's own nodes get one each. The format is that of "ROS 2
Access Control Policies" (design.ros2.org), version 0.2.0.
"""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[1]
OUTPUT = ROOT / 'config' / 'sros2_policy.xml'

NODES = ('ceiling_camera_node', 'gait_node', 'planner_node', 'sim_node', 'viewer_node')

VIEWER = 'viewer_node'
"""Through which people at a page ask for what an operator may."""

OPERATOR = 'operator'
"""Who gives goals, steers, calls services, and looks at everything."""

ROBOT = 'robot'
"""What takes the simulator's place on a real robot: drivers, controllers, localisation."""

_WORDS = {
    ROBOT: re.compile(r'real robot|localiser|map server|joint controller|driver'),
    OPERATOR: re.compile(r'\byou\b|RViz|teleoperation|Nav2|quadwalk'),
}
"""How the pages name them."""

_OF_EVERY_NODE = (
    'describe_parameters',
    'get_parameter_types',
    'get_parameters',
    'list_parameters',
    'set_parameters',
    'set_parameters_atomically',
    'get_type_description',
)
"""Services that rclpy offers for each node, below the node's name."""

_OF_MANAGED = (
    'change_state',
    'get_state',
    'get_available_states',
    'get_available_transitions',
    'get_transition_graph',
)
"""Services of a node with ``managed:=true``, below the node's name."""

_MANAGED = ('gait_node', 'planner_node')

_ABSOLUTE = ('/clock', '/rosout', '/parameter_events', '/tf', '/tf_static')
"""Topics that no namespace moves, as ROS has it; parameter_events is relative there."""

_COMMENT = """
  Written by tools/sros2_policy.py from the pages of msg_docs: do not edit. See docs/network.md.
"""


@dataclass(frozen=True)
class Page:
    """What a page says of one topic, service or action."""

    name: str
    """As the page writes it: absolute with a leading slash."""
    rows: dict[str, str]
    """Row of its first table, by the row's name."""

    def names_in(self, row: str) -> tuple[str, ...]:
        """List the owners of enclaves that a row names."""
        text = self.rows.get(row, '')
        nodes = [node for node in NODES if f'`{node}`' in text or 'every node' in text]
        return (*nodes, *(owner for owner, words in _WORDS.items() if words.search(text)))


def pages(folder: Path = ROOT / 'msg_docs') -> list[Page]:
    """
    Read the pages of topics, services and actions.

    Parameters
    ----------
    folder : Path
        Where they are.

    Returns
    -------
    list of Page
        One for each topic, service or action, by name.
    """
    found = []
    for path in sorted(folder.glob('*.md')):
        parts = path.read_text(encoding='utf-8').split('\n\n')
        lines = [line.strip('|').split('|', 1) for line in parts[1].splitlines() if '|' in line]
        rows = {line[0].strip(): line[1].strip() for line in lines if len(line) == 2}
        if rows.keys() & {'published by', 'subscribed by', 'offered by', 'served by'}:
            found += [Page(name, rows) for name in re.findall('`([^`]+)`', parts[0])]
    return sorted(found, key=lambda page: page.name)


def permissions(found: list[Page]) -> dict[str, dict[tuple[str, str], set[str]]]:
    """
    Work out who may do what.

    Parameters
    ----------
    found : list of Page
        The pages.

    Returns
    -------
    dict
        By enclave, then by kind and right (``('topic', 'publish')``): the names.
    """
    rights: dict[str, dict[tuple[str, str], set[str]]] = {}
    for owner in (*NODES, ROBOT, OPERATOR):
        rights[owner] = {
            ('topic', 'publish'): {'/rosout', '/parameter_events'},
            ('topic', 'subscribe'): {'/clock', '/parameter_events'},
            ('service', 'reply'): {f'{owner}/{service}' for service in _OF_EVERY_NODE},
            ('service', 'request'): set(),
            ('action', 'execute'): set(),
            ('action', 'call'): set(),
        }
    operator = rights[OPERATOR]
    operator['topic', 'subscribe'].add('/rosout')
    for page in found:
        for owner in page.names_in('published by'):
            rights[owner]['topic', 'publish'].add(page.name)
        for owner in page.names_in('subscribed by'):
            rights[owner]['topic', 'subscribe'].add(page.name)
        for owner in page.names_in('offered by'):
            rights[owner]['service', 'reply'].add(page.name)
            operator['service', 'request'].add(page.name)
            rights[VIEWER]['service', 'request'].add(page.name)
        for owner in page.names_in('served by'):
            rights[owner]['action', 'execute'].add(page.name)
            # What nodes call of one another moves joints, and is not for people.
            for caller in page.names_in('called by') or (OPERATOR,):
                rights[caller]['action', 'call'].add(page.name)
        if not page.rows.keys() & {'offered by', 'served by'}:
            operator['topic', 'subscribe'].add(page.name)
    for node in NODES:
        operator['service', 'request'] |= {f'{node}/{service}' for service in _OF_EVERY_NODE}
    for node in _MANAGED:
        rights[node]['service', 'reply'] |= {f'{node}/{service}' for service in _OF_MANAGED}
        rights[node]['topic', 'publish'].add(f'{node}/transition_event')
        operator['service', 'request'] |= {f'{node}/{service}' for service in _OF_MANAGED}
        operator['topic', 'subscribe'].add(f'{node}/transition_event')
    rights[VIEWER]['service', 'request'] |= {
        f'{node}/set_parameters' for node in ('gait_node', 'planner_node')
    }
    return rights


def policy(namespace: str = '') -> str:
    """
    Write the policy.

    Parameters
    ----------
    namespace : str
        Of the robot; the root if empty.

    Returns
    -------
    str
        An XML document.
    """
    prefix = f'/{namespace.strip("/")}' if namespace.strip('/') else ''
    root = ElementTree.Element('policy', version='0.2.0')
    root.append(ElementTree.Comment(_COMMENT))
    enclaves = ElementTree.SubElement(root, 'enclaves')
    for owner, rights in permissions(pages()).items():
        enclave = ElementTree.SubElement(enclaves, 'enclave', path=f'{prefix}/quadwalk/{owner}')
        profiles = ElementTree.SubElement(enclave, 'profiles')
        profile = ElementTree.SubElement(profiles, 'profile', ns=prefix or '/', node=owner)
        for (kind, right), names in rights.items():
            if names:
                listed = ElementTree.SubElement(profile, f'{kind}s', {right: 'ALLOW'})
                for name in sorted(_resolved(name, prefix) for name in names):
                    ElementTree.SubElement(listed, kind).text = name
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding='unicode')
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _resolved(name: str, prefix: str) -> str:
    return name if name in _ABSOLUTE else f'{prefix}/{name.strip("/")}'


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description='Write the SROS2 policy of quadwalk.')
    parser.add_argument('--namespace', default='', help='of the robot; the root by default')
    parser.add_argument('--output', type=Path, default=OUTPUT)
    arguments = parser.parse_args()
    arguments.output.write_text(policy(arguments.namespace), encoding='utf-8')


if __name__ == '__main__':
    main()
