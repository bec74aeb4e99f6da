"""The SROS2 policy allows what the code does and nothing else, in the form that SROS2 reads."""

from __future__ import annotations

import runpy
from pathlib import Path
from xml.etree import ElementTree

import pytest
from test_docs import INTERFACES, Interface

ROOT = Path(__file__).resolve().parents[2]
TOOL = runpy.run_path(str(ROOT / 'tools' / 'sros2_policy.py'))
FILE = ROOT / 'config' / 'sros2_policy.xml'
NODES = TOOL['NODES']

RIGHTS = {
    'create_publisher': ('topics', 'publish'),
    'create_subscription': ('topics', 'subscribe'),
    '_listen': ('topics', 'subscribe'),
    'create_service': ('services', 'reply'),
    'GoalAction': ('actions', 'execute'),
}

# "ROS 2 Access Control Policies", schema 0.2.0: element, its attributes, its children.
STRUCTURE = {
    'policy': ({'version'}, {'enclaves'}),
    'enclaves': (set(), {'enclave'}),
    'enclave': ({'path'}, {'profiles'}),
    'profiles': (set(), {'profile'}),
    'profile': ({'ns', 'node'}, {'topics', 'services', 'actions'}),
    'topics': ({'publish', 'subscribe'}, {'topic'}),
    'services': ({'reply', 'request'}, {'service'}),
    'actions': ({'execute', 'call'}, {'action'}),
    'action': (set(), set()),
    'topic': (set(), set()),
    'service': (set(), set()),
}
REQUIRED = {'policy': {'version'}, 'enclave': {'path'}, 'profile': {'ns', 'node'}}


def allowed(owner: str, kind: str, right: str, text: str | None = None) -> set[str]:
    """List what an enclave may do, by absolute names."""
    root = ElementTree.fromstring(text or FILE.read_text(encoding='utf-8'))
    [profile] = root.findall(f"./enclaves/enclave/profiles/profile[@node='{owner}']")
    return {
        name.text or ''
        for listed in profile.findall(f"./{kind}[@{right}='ALLOW']")
        for name in listed
    }


def test_the_file_is_what_the_pages_say():
    written = FILE.read_text(encoding='utf-8')
    assert written == TOOL['policy'](), 'write it again: python tools/sros2_policy.py'


def test_it_has_the_structure_that_sros2_documents():
    root = ElementTree.fromstring(FILE.read_text(encoding='utf-8'))
    assert root.tag == 'policy'
    assert root.get('version') == '0.2.0'
    for element in root.iter():
        attributes, children = STRUCTURE[element.tag]
        assert set(element.attrib) <= attributes
        assert set(element.attrib) >= REQUIRED.get(element.tag, set())
        assert {child.tag for child in element} <= children
        assert bool(len(element)) == bool(children), f'{element.tag} is empty'
        if element.tag in ('topics', 'services', 'actions'):
            assert set(element.attrib.values()) == {'ALLOW'}
            assert len(element.attrib) == 1
    paths = [enclave.get('path') for enclave in root.iter('enclave')]
    assert len(paths) == len(set(paths)) == len(NODES) + 2


@pytest.mark.parametrize('interface', [i for i in INTERFACES if i.nodes], ids=str)
def test_each_node_may_do_what_its_code_does(interface: Interface):
    kind, right = RIGHTS[interface.call]
    for owner in interface.nodes:
        assert f'/{interface.name}' in allowed(owner, kind, right)


@pytest.mark.parametrize('node', NODES)
def test_no_node_may_say_or_offer_what_its_code_does_not(node):
    of_all = {'/rosout', '/parameter_events', '/tf', '/tf_static'}
    for kind, right in (('topics', 'publish'), ('services', 'reply'), ('actions', 'execute')):
        # What a module makes for a node that is handed to it counts for each of them.
        done = {
            f'/{i.name}'
            for i in INTERFACES
            if (node in i.nodes or not i.nodes) and RIGHTS[i.call] == (kind, right)
        }
        for name in allowed(node, kind, right) - done - of_all:
            assert name.startswith(f'/{node}/'), name


def test_only_people_and_the_camera_give_goals_and_only_people_call_services():
    givers = [
        n for n in (*NODES, 'robot', 'operator') if '/goal_pose' in allowed(n, 'topics', 'publish')
    ]
    assert givers == ['ceiling_camera_node', 'viewer_node', 'operator']
    others = {*NODES, 'robot'} - {'viewer_node'}
    assert not any(allowed(node, 'services', 'request') for node in others)
    assert '/stop' in allowed('viewer_node', 'services', 'request')
    assert '/sim_node/set_parameters' not in allowed('viewer_node', 'services', 'request')
    assert '/stop' in allowed('operator', 'services', 'request')
    assert '/joint_trajectory' not in allowed('operator', 'topics', 'publish')
    assert '/navigate_to_pose' in allowed('operator', 'actions', 'call')
    joints = '/joint_trajectory_controller/follow_joint_trajectory'
    assert set(allowed('gait_node', 'actions', 'call')) == {joints}
    assert joints in allowed('robot', 'actions', 'execute')
    assert joints not in allowed('operator', 'actions', 'call')
    assert not any(allowed(node, 'actions', 'call') for node in ({*NODES, 'robot'} - {'gait_node'}))


def test_a_namespace_moves_all_but_what_is_absolute():
    text = TOOL['policy']('/robot1/')
    for name in allowed('gait_node', 'topics', 'publish', text):
        assert name.startswith('/robot1/') or name in ('/rosout', '/parameter_events')
    assert '/robot1/stop' in allowed('gait_node', 'services', 'reply', text)
    assert '/clock' in allowed('gait_node', 'topics', 'subscribe', text)
    assert {'/tf', '/tf_static'} <= set(allowed('gait_node', 'topics', 'subscribe', text))
    assert 'path="/robot1/quadwalk/gait_node"' in text
