"""
What a robot's description says of its legs, and the data file that follows from it.
"""
