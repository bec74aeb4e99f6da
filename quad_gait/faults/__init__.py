"""
Joints that do not follow their commands, and how the robot comes to stand.
"""
