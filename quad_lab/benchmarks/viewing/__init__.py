"""
Benchmarks of what is seen and kept of a walk.
"""
