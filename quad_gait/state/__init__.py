"""
The robot's state by its measurements: sensors, stance, contact and leg odometry.
"""
