"""
What is in the simulated world: walls, obstacles, ground, and how it looks.
"""
