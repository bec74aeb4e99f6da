"""
What benchmarks share: criteria, worker processes, maps.
"""
