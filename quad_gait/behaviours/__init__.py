"""
What the robot does, and what comes next.
"""
