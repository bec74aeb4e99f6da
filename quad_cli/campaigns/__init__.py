"""
Commands about campaigns of walks.
"""
