"""
Commands that make recordings, and use them.
"""
