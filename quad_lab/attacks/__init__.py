"""
Attacks on nodes, files and commands, and every combination of robot, gait and planner.
"""
