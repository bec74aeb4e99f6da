"""
Proof that a recording holds what was published, and plays as it was.
"""
