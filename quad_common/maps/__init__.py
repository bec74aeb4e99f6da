"""
Occupancy grids and height maps, and their files.
"""
