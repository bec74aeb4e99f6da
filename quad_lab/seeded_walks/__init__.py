"""
Walks as pure functions: what varies and a seed make the scene, and figures come of it.
"""
