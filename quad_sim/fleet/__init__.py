"""
Several robots in one world: an engine's world that they have in common, and their controllers.
"""
