"""A real browser shows the robot, and walks it: page, click, drag, speed pad, emergency stop."""

from __future__ import annotations

import math

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('viser', reason='the viewer needs viser: pip install quadwalk[view]')

from geometry_msgs.msg import PoseStamped, Twist
from harness import Bench
from rcl_interfaces.srv import SetParameters
from std_msgs.msg import Bool

from quad_common.ros.pose_conversions import pose_from_message
from quad_lab.tools.chromium import Chromium, find_chromium
from quad_lab.tools.page_reader import PageReader
from quad_lab.topic_walk.viewer_process import PagePlace, free_port
from quad_view.ros_conversions import option_request

pytestmark = [
    pytest.mark.ros,
    pytest.mark.slow,
    pytest.mark.skipif(find_chromium() is None, reason='no Chromium: sudo apt install chromium'),
]

FLOOR = (290.0, 560.0)
"""A place on the floor before the robot as the page shows it at first [pixels]."""

OF_DRAGS = 'Unable to preventDefault inside passive event listener invocation.'
"""What Chromium says of viser's own drags; nothing comes of it."""

SHOWN = "document.body.innerText.includes('standing') && !!document.querySelector('canvas')"

VALUES = "Array.from(document.querySelectorAll('input'), field => field.value)"
"""What is chosen on the page."""


COARSE = 0.1
"""Of each side of the picture: what is drawn is not looked at here, and takes most of the time."""


def start(bench: Bench) -> str:
    """Start a robot and its page; return the page's address."""
    port = free_port(PagePlace(port=8600))
    bench.start_robot(real_time_factor=2.0)
    bench.start('viewer_node', port=port)
    bench.wait_for_status('viewer_node', 'showing the robot')
    return str(bench.statuses['viewer_node'].values['address'])


def test_a_click_on_the_floor_makes_the_robot_walk_there(bench: Bench):
    address = start(bench)
    goals = bench.hear(PoseStamped, 'goal_pose')
    twists = bench.hear(Twist, 'cmd_vel')
    stopped = bench.hear(Bool, 'emergency_stop/active')
    with Chromium((1400, 850), COARSE) as browser, PageReader(address) as reader:
        browser.open(address)
        browser.wait_for(SHOWN)
        still, _ = reader.count(1.0)
        assert still.poses[0] <= 1

        before = bench.pose
        browser.click(*FLOOR)
        bench.wait_until('a goal is given', lambda: len(goals) == 1)
        goal = pose_from_message(goals[0].pose)
        assert goal.yaw == pytest.approx(before.heading_to(goal), abs=1e-3)
        bench.wait_for_walking()
        walking, seconds = reader.count(2.0)
        assert walking.poses[0] / seconds > 5.0
        bench.wait_for_arrival(goal)
        browser.wait_for("document.body.innerText.includes('arrived')")

        assert browser.problems == []

        x, y = FLOOR
        browser.drag((x, y), (x + 80.0, y), shift=True)
        bench.wait_until('a goal with a heading is given', lambda: len(goals) == 2)
        dragged = pose_from_message(goals[1].pose)
        assert dragged.distance_to(goal) < 0.05
        assert abs(dragged.yaw) < math.radians(10.0)

        answer = bench.call(
            'gait_node/set_parameters', SetParameters, option_request('turning', 'crab')
        )
        assert answer.results[0].successful
        browser.wait_for(f"{VALUES}.includes('crab') && {VALUES}.includes('mesh')")
        assert 'not known yet' not in browser.evaluate(VALUES)

        browser.click(*browser.place_of('Steer'))
        place = browser.place_of('Turn left')
        browser.press(*place)
        bench.wait_until('the robot is steered', lambda: len(twists) > 5)
        assert all(twist.angular.z > 0.0 for twist in twists[:5])
        browser.release(*place)
        bench.wait_until('it is let go', lambda: not twists[-1].angular.z)

        browser.key('x')
        bench.wait_until('the emergency stop is on', lambda: stopped and stopped[-1].data)
        browser.wait_for("document.body.innerText.includes('emergency stop: all joints hold')")
        browser.click(*browser.place_of('Release the emergency stop'))
        bench.wait_until('it is released', lambda: not stopped[-1].data)

        assert set(browser.problems) <= {OF_DRAGS}
        assert browser.hosts() == {'localhost'}

        # A page that is closed lets the speed pad go.
        browser.press(*browser.place_of('Forward'))
        bench.wait_until('the robot is steered', lambda: twists[-1].linear.x > 0.0)
    bench.wait_until('the robot is told to stop', lambda: not twists[-1].linear.x)


def test_the_page_says_who_is_missing_and_ignores_clicks_without_a_robot(bench: Bench):
    port = free_port(PagePlace(port=8600))
    bench.start('viewer_node', port=port)
    bench.wait_for_status('viewer_node', 'no robot: waiting for joint_states')
    with Chromium((1400, 850), COARSE) as browser:
        browser.open(bench.statuses['viewer_node'].values['address'])
        browser.wait_for("document.body.innerText.includes('no robot: nobody publishes')")
        browser.click(*FLOOR)
        browser.click(*browser.place_of('EMERGENCY STOP'))
        bench.start_robot(real_time_factor=2.0)
        browser.wait_for(SHOWN)
        bench.wait_for_status('viewer_node', 'showing the robot')
        bench.kill('planner_node')
        browser.wait_for("document.body.innerText.includes('planner_node has ended, or hangs')")
        bench.kill('gait_node')
        browser.wait_for("document.body.innerText.includes('gait_node has ended, or hangs')")
        assert 'start it with: gait_node' in browser.text()
