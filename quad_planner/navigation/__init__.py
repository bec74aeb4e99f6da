"""
Goals that somebody answers for: how far the robot is, what is done about trouble, how it ended.
"""
