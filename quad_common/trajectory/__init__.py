"""
Joint trajectories: the values, the limits they must keep, and how joints execute them.
"""
