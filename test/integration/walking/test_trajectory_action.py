"""A robot whose joint controller takes trajectories by an action alone."""

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('control_msgs', reason='control_msgs is not installed; make control builds it')

from control_msgs import action as actions
from geometry_msgs.msg import Twist
from node_in_process import NodeInProcess
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

from quad_common.errors import EmptyTrajectory
from quad_common.ros.goal_actions import GoalAction, GoalPort
from quad_common.ros.guarded_node import GuardedNode
from quad_common.ros.run_node import make_executor
from quad_sim.ros_conversions import trajectory_from_message

pytestmark = pytest.mark.ros

NAME = 'controller/follow_joint_trajectory'


class Controller(GuardedNode):
    """Serves the action, and moves the joints of a simulation."""

    def __init__(self, context):
        super().__init__('controller', context=context)
        self.goals, self.refused, self.cancellations = [], 0, 0
        self.refuses = False
        self.simulation = None
        port = GoalPort(self.check, self.take, self.cancel)
        self.action = GoalAction(self, actions.FollowJointTrajectory, NAME, port)

    def report_error(self, error):
        """Reject the goal, and nothing more."""

    def report_unexpected(self, sentence, kind, stack):
        raise AssertionError(sentence)

    def check(self, goal):
        if self.refuses:
            self.refused += 1
            raise EmptyTrajectory()

    def take(self, goal):
        self.goals.append(goal)
        self.simulation.accept(trajectory_from_message(goal.trajectory))

    def cancel(self):
        self.cancellations += 1
        self.action.canceled(actions.FollowJointTrajectory.Result())


class WalkByAction:
    """A gait node whose trajectories reach the joints by the action alone."""

    def __init__(self, made: NodeInProcess):
        self.made, self.node = made, made.node
        self.controller = Controller(self.node.context)
        self.controller.simulation = made.simulation
        self.executor = make_executor(self.node.context)
        self.executor.add_node(self.node)
        self.executor.add_node(self.controller)
        self.published = []
        self.node._topics._trajectories.publish = self.published.append
        self.tell, made.tell = made.tell, self._tell
        client = self.node._topics._goals._client
        self.until(client.server_is_ready)

    def until(self, condition):
        for _ in range(2000):
            if condition():
                return
            self.executor.spin_once(timeout_sec=0.01)
        raise AssertionError('it did not come to pass')

    def _tell(self, topic, message):
        """Hand a message on, and let what follows of it arrive before time goes on."""
        self.tell(topic, message)
        controller = self.controller
        self.until(lambda: len(controller.goals) + controller.refused == len(self.published))

    @property
    def problem(self):
        return self.node._topics._goals.problem()

    def close(self):
        self.executor.remove_node(self.controller)
        self.executor.remove_node(self.node)
        self.controller.destroy_node()


@pytest.fixture
def walk(make_node):
    made = WalkByAction(make_node(trajectory_action=NAME))
    yield made
    made.close()


def test_a_robot_walks_by_goals_that_replace_one_another(walk):
    forward = Twist()
    forward.linear.x = 0.04
    walk.made.run(12.0, forward)
    assert walk.made.simulation.observe().position[0] > 0.15
    assert len(walk.controller.goals) >= 3
    assert [goal.trajectory for goal in walk.controller.goals] == walk.published
    tolerances = walk.controller.goals[0].path_tolerance
    assert [each.name for each in tolerances] == walk.published[0].joint_names
    assert {each.position for each in tolerances} == {-1.0}
    walk.until(lambda: walk.problem == '')

    # The controller gives up: it is said, with its reason.
    code = actions.FollowJointTrajectory.Result.PATH_TOLERANCE_VIOLATED
    result = actions.FollowJointTrajectory.Result(error_code=code, error_string='a knee lags')
    walk.controller.action.abort(result)
    walk.until(lambda: walk.problem)
    assert f'{NAME} gave up the trajectory: PATH_TOLERANCE_VIOLATED (a knee lags)' in walk.problem
    walk.node.update_status()
    assert 'a knee lags' in walk.made.said[-1][1]


def test_an_emergency_stop_is_a_goal_and_a_cancellation_where_that_is_rejected(walk):
    forward = Twist()
    forward.linear.x = 0.04
    walk.made.run(6.0, forward)
    before = len(walk.controller.goals)
    walk.until(lambda: walk.node._topics._goals._followed is not None)
    stop = next(s for s in walk.node.services if s.srv_name.endswith('emergency_stop'))
    stop.callback(SetBool.Request(data=True), SetBool.Response())
    walk.until(lambda: len(walk.controller.goals) == before + 1)
    assert walk.controller.cancellations == 0
    last = walk.controller.goals[-1].trajectory.points
    assert max(map(abs, last[-1].velocities)) == 0.0
    walk.controller.refuses = True
    stop.callback(SetBool.Request(data=True), SetBool.Response())
    walk.until(lambda: walk.controller.cancellations == 1)
    assert 'rejected a trajectory' in walk.problem


def test_a_controller_that_is_missing_is_named(make_node):
    made = make_node(trajectory_action='nobody/follow_joint_trajectory')
    made.run(0.5)
    assert any('nobody/follow_joint_trajectory is not there' in said for _, said in made.said)


def test_goals_that_nobody_answers_are_not_kept_for_good(walk):
    goals, trajectory = walk.node._topics._goals, JointTrajectory()
    walk.executor.remove_node(walk.controller)
    for _ in range(200):
        goals.send(trajectory)
    assert len(goals._client._pending_goal_requests) <= 50
    # One that is answered at last counts.
    walk.controller.refuses = True
    walk.executor.add_node(walk.controller)
    walk.until(lambda: 'rejected' in walk.problem)
