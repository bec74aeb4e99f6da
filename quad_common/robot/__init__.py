"""
Robots: their data files, the kinematics of their legs, their reach, their shape and their pace.
"""
