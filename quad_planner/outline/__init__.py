"""
Planning with the robot's outline: cells and headings where a convex polygon fits.
"""
