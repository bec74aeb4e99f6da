"""Walks are, bit for bit, what they were when their hashes were written."""

import json

import pytest

pytest.importorskip('pybullet')

from fixed_walks import RECORD, WALKS, machine

KEPT = json.loads(RECORD.read_text(encoding='utf-8'))
DIGESTS = KEPT['machines'].get(machine(), {})
"""Hashes that were written on such a machine, if any."""


def test_every_walk_is_kept():
    assert KEPT['walks'].keys() == WALKS.keys()
    assert all(digests.keys() == WALKS.keys() for digests in KEPT['machines'].values())


@pytest.mark.sweep(kept=10)
@pytest.mark.parametrize('name', WALKS)
def test_a_walk_is_as_it_was(name):
    trace, kept = WALKS[name](), KEPT['walks'][name]
    if name in DIGESTS:
        assert trace.digest == DIGESTS[name]
    # Another processor rounds otherwise; in physics that grows.
    in_physics = ' on ' in name or 'joint' in name or 'physics' in name
    if ' on ' in name:
        # A foot that lands beside an edge takes another stride.
        assert trace.end[:2] == pytest.approx(kept['end'][:2], abs=0.1)
        assert trace.end[2] == pytest.approx(kept['end'][2], abs=0.3)
    elif in_physics:
        assert trace.end == pytest.approx(kept['end'], abs=0.05)
    else:
        assert trace.trajectories == kept['trajectories']
        assert trace.travel == pytest.approx(kept['travel'], rel=1e-6)
        assert trace.end == pytest.approx(kept['end'], abs=1e-6)
