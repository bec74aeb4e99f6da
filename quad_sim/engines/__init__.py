"""
Simulators behind one protocol: PyBullet, MuJoCo, and one that follows commands exactly.
"""
