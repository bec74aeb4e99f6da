"""
Potentials over a map, and their descent.
"""
