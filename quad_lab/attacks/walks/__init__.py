"""
Walks that are disturbed: kills, silence, load, drift.
"""
