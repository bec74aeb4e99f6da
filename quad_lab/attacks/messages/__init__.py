"""
Attacks by messages.
"""
