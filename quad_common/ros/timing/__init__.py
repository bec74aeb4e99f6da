"""
A node's time: its clock, the order of stamps, and whether it keeps up.
"""
