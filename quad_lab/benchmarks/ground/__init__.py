"""
Benchmarks of walks over uneven ground, and of joints that fail.
"""
