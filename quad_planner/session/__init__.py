"""
What is planned, and when: maps, goals, poses and followed plans as they come.
"""
