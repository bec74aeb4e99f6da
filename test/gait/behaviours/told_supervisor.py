"""A supervisor for tests that make measurements by hand."""

from quad_gait.state.state_estimator import EstimatorOptions, StateEstimator
from quad_gait.supervisor import Supervisor


class ToldSupervisor(Supervisor):
    """Makes a state of each measurement that it is told."""

    def __init__(self, robot, *args, rest_speed=0.1):
        super().__init__(robot, *args)
        self.estimator = StateEstimator(robot, EstimatorOptions(rest_speed=rest_speed))

    def update(self, state):
        """Judge the measurement first."""
        return super().update(self.estimator.judge(state))
