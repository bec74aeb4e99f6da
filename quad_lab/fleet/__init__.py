"""
Several robots on one map, walked in one process without topics.
"""
