"""
Benchmarks of the planner.
"""
