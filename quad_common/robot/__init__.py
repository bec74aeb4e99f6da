"""
Robots: the kinematics of their legs, their reach, their masses, their shape.
"""
