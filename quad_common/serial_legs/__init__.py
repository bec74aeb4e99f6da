"""
Legs of three joints whose axes lie in any manner: kinematics by iteration.
"""
