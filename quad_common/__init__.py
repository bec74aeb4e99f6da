"""
What every part of quadwalk shares: errors, geometry, maps, trajectories, robots.

This package is a leaf: it imports no other package of quadwalk, and its core
modules import neither rclpy nor pybullet.
"""
