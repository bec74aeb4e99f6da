"""
Start and end of processes: signals, temporary folders.
"""
