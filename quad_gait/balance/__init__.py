"""
A trot that keeps its balance: where feet are put, and how legs give way, within a step.
"""
