"""
Benchmarks of walking and perception.
"""
