"""
Paths at any angle: the free cells as rectangles, and searches through their openings.
"""
