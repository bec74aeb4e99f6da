"""
What a sound robot does, one file a behaviour, and what it is wished to do.
"""
