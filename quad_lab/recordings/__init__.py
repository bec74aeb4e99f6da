"""
Recordings of a robot's topics, and what can be read from them.
"""
