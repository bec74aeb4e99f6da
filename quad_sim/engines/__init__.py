"""
Simulators behind one protocol: PyBullet, and one that follows commands exactly.
"""
