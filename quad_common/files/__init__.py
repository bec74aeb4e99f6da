"""
Files of users: opened within bounds, read as YAML with one clear sentence for each fault.
"""
