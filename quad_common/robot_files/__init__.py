"""
Files of robots: their data, and how fast their gaits take them.
"""
