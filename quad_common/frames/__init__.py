"""
Coordinate frames: a tree of transforms, and where odometry is in the map.
"""
