"""
From a path of turning points to joint trajectories for four legs.

The core (everything but ``ros_conversions`` and ``gait_node``) imports no rclpy.
"""
