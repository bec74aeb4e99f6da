"""
Robots that share a map: where the others are and want to go, and who gives way to whom.
"""
