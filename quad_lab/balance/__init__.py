"""
Pushes, silence and steady walks of robots that keep their balance.
"""
