"""
Attacks by files and arguments.
"""
