"""
Checks of joints near their commands, measurement by measurement: each notices one kind of failure.
"""
