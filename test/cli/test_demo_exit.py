"""``quadwalk demo`` exits with 1 and the robot's reason if it does not arrive."""

import json

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('matplotlib')

from quad_cli.main import main
from quad_common.planar_pose import Pose2D
from quad_lab.topic_walk import walk
from quad_lab.topic_walk.walk_record import WalkRecord


def test_a_demo_with_a_lame_robot_ends_with_its_reason(tmp_path, monkeypatch, capsys):
    def walked(options, on_progress, on_page, on_end):
        record = WalkRecord(options.goal)
        record.note_pose(1.0, Pose2D(1.2, 1.2, 0.0))
        record.problem = 'lame: lf_knee_joint of leg lf does not hold'
        return record

    monkeypatch.setattr(walk, 'walk', walked)
    code = main(['demo', '--json', '--no-recording', '--output', str(tmp_path)])
    summary = json.loads(capsys.readouterr().out)
    assert code == 1
    assert (summary['arrived'], summary['problem']) == (
        False,
        'lame: lf_knee_joint of leg lf does not hold',
    )
    assert (tmp_path / 'walk.png').is_file()
