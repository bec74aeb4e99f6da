"""
Checks of the machine that quadwalk runs on, and what mends what is missing.
"""
