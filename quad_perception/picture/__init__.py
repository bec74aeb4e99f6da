"""
What one picture shows: colors, floor, obstacles, markers.
"""
