"""
From a plan or a velocity to the next cycle.
"""
