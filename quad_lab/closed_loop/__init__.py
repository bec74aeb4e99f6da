"""
Walks in one process, without topics.
"""
