"""
What the feet of a trotting robot tell of the ground.
"""
