"""
Simulators that walk the robot: PyBullet's physics, and one that follows commands exactly.

PyBullet is imported in ``bullet_simulator`` only.
"""
