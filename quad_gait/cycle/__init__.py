"""
One gait cycle: which foot moves when, body, feet, joints and stability margin.
"""
