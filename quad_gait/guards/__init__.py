"""
What interrupts a walk when something is wrong: one file a guard.
"""
