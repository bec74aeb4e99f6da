"""
What a series of pictures shows: a steady map, the pose of the robot.
"""
