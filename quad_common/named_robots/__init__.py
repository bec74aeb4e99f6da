"""
Robots that are asked for by a name or by a description, and imported at their first use.
"""
